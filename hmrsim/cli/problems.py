"""Problems of world files as lines that editors can parse."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.errors import Problem


def line_of(problem: Problem) -> str:
    """Return ``file:line: path: message``, with ``warning:`` after the place of a warning."""
    if problem.severity == "error":
        return str(problem)
    place = replace(problem, path="", message="")
    return f"{place}: {problem.severity}: {replace(problem, file='', line=None)}"

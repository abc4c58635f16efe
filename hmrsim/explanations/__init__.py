"""Explanations of codes: the texts of ``hmrsim explain``, and of the pages in docs/reference/errors.

A code is the error code of a result (Nav2's or MoveIt's), the reason of a rejection, the cause of a goal that did not
succeed, the result of a service, or the exit code of a command.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final

import yaml

if TYPE_CHECKING:
    from collections.abc import Mapping

_FILE: Final = Path(__file__).with_name("codes.yaml")


@dataclass(frozen=True)
class Explanation:
    """The explanation of a code.

    Attributes:
        code: The code, as text.
        name: The name in Nav2 or MoveIt, or the kind of the code.
        of: The actions that use the code.
        means: The meaning, in one sentence.
        why: The causes, in Markdown with one line per paragraph or list item.
        do: What to do about it, in the same form.
    """

    code: str
    name: str
    of: str
    means: str
    why: str
    do: str


@cache
def explanations() -> Mapping[str, Explanation]:
    """Return all explanations by their codes, numbers first."""
    entries = yaml.safe_load(_FILE.read_text(encoding="utf-8"))
    return {str(each["code"]): Explanation(**{**each, "code": str(each["code"])}) for each in entries}

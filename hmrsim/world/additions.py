"""Robots and items that the command line adds: ``NAME@X,Y[:TYPE]`` and ``NAME@X,Y[:KG]``."""

from __future__ import annotations

import re
from typing import Any

from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document
from hmrsim.world.merging import Source

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?"
_ADDITION = re.compile(rf"(?P<name>[^@]+)@(?P<x>{_NUMBER}),(?P<y>{_NUMBER})(?::(?P<rest>.+))?", re.ASCII)


def robot(text: str) -> Source:
    """Return what ``--robot`` adds.

    Raises:
        WorldError: *text* is not as expected.
    """
    name, fields, kind = _parse(text, "--robot", "NAME@X,Y or NAME@X,Y:TYPE")
    if kind is not None:
        fields["type"] = kind
    return Source(f"--robot {text}", Document({"robots": {name: fields}}))


def item(text: str) -> Source:
    """Return what ``--item`` adds.

    Raises:
        WorldError: *text* is not as expected.
    """
    expected = "NAME@X,Y or NAME@X,Y:KG"
    name, fields, weight = _parse(text, "--item", expected)
    if weight is not None:
        if not re.fullmatch(_NUMBER, weight, re.ASCII):
            raise _error("--item", text, expected)
        fields["weight"] = float(weight)
    return Source(f"--item {text}", Document({"items": {name: fields}}))


def _parse(text: str, option: str, expected: str) -> tuple[str, dict[str, Any], str | None]:
    match = _ADDITION.fullmatch(text)
    if match is None:
        raise _error(option, text, expected)
    return match["name"], {"at": [float(match["x"]), float(match["y"])]}, match["rest"]


def _error(option: str, text: str, expected: str) -> WorldError:
    return WorldError([Problem(f"{option} {text}", "", f"expected {expected}")])

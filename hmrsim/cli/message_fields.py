"""One field of a message, as ``ros2 topic echo --field`` names it."""

from __future__ import annotations

import re
from typing import Any, Final

from hmrsim.cli.exits import UnknownName, WrongUse
from hmrsim.diagnostics import instead

_STEP: Final = re.compile(r"(?P<name>\w+)|\[(?P<index>-?\d+)\]")
_FIELD: Final = re.compile(r"\w+(\[-?\d+\])*(\.\w+(\[-?\d+\])*)*")


def field_path(text: str) -> tuple[str | int, ...]:
    """Return the steps to a field: names of fields, and indices in lists.

    Raises:
        WrongUse: The text is not like ``pose.pose.position`` or ``status_list[-1].status``.
    """
    if not _FIELD.fullmatch(text):
        raise WrongUse(f"--field: {text!r} is not a field; expected one such as pose.pose.position or poses[0].header")
    return tuple(int(step["index"]) if step["index"] is not None else step["name"] for step in _STEP.finditer(text))


def field_of(message: Any, path: tuple[str | int, ...]) -> Any:
    """Return the value of a field in the plain values of a message.

    Raises:
        UnknownName: There is none.
    """
    value, passed = message, ""
    for step in path:
        if isinstance(step, int):
            if not isinstance(value, list):
                raise UnknownName(f"field {passed!r} is not a list")
            if not -len(value) <= step < len(value):
                raise UnknownName(f"field {passed!r} has {len(value)} entries, and none at [{step}]")
            value, passed = value[step], f"{passed}[{step}]"
            continue
        if not isinstance(value, dict) or step not in value:
            names = list(value) if isinstance(value, dict) else []
            where = f"field {passed!r} has" if passed else "the message has"
            raise UnknownName(f"{where} no field {step!r}{instead(step, names)}")
        value, passed = value[step], f"{passed}.{step}".removeprefix(".")
    return value

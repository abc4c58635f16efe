"""A goal as typed on a command line: YAML on one line, checked against the action's goal message."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, get_args

from pydantic import ValidationError

from hmrsim.cli.exits import WrongUse
from hmrsim.world import yaml_text
from hmrsim.world.finding import dotted, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic import BaseModel
    from pydantic_core import ErrorDetails

    from hmrsim.interfaces.message import Message

_WANTED: Final = {
    "float_type": "expected a number",
    "finite_number": "expected a finite number",
    "int_type": "expected a whole number",
    "int_from_float": "expected a whole number",
    "string_type": "expected text (in quotes, if it looks like a number)",
    "bool_type": "expected true or false",
    "list_type": "expected a list",
    "model_type": "expected a mapping",
    "invalid_key": "expected a field's name",
}


def read_yaml(text: str, noun: str = "goal") -> object:
    """Return the plain values that a goal's text stands for, in the YAML of world files: ``1e3`` is a number.

    Args:
        text: As typed.
        noun: What it is, for errors.

    Raises:
        WrongUse: It is no YAML, or a key is there twice.
    """
    try:
        data, _, findings = yaml_text.read(text)
    except yaml_text.Unreadable as error:
        raise WrongUse(f"{noun}: {error}; expected a mapping such as '{{target_name: medicine}}'") from None
    if findings:
        raise WrongUse("\n".join(f"{noun}: {dotted(finding.path)}: {finding.message}" for finding in findings))
    return data


def read_goal(data: object, kind: type[Message]) -> Message:
    """Return the goal that plain values stand for; integers will do for floats.

    Raises:
        WrongUse: They are not of this *kind*; one line a mistake.
    """
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        lines = [_line(details, kind) for details in error.errors(include_url=False)]
        raise WrongUse("\n".join(lines)) from None


def _line(details: ErrorDetails, kind: type[Message]) -> str:
    path = details["loc"]
    where = ": ".join(("goal", *([".".join(str(step) for step in path)] if path else [])))
    if details["type"] == "extra_forbidden":
        return f"{where}: unknown field; there are: {', '.join(_fields(kind, path[:-1])) or 'none'}"
    wanted = _WANTED.get(details["type"]) or details["msg"][:1].lower() + details["msg"][1:]
    return f"{where}: {wanted}, got {shown(details['input'])}"


def _fields(kind: type[BaseModel], path: Sequence[str | int]) -> list[str]:
    """Return the names of the fields of the message at *path*."""
    here: Any = kind
    for step in path:
        here = here.model_fields[step].annotation if isinstance(step, str) else get_args(here)[0]
    return list(here.model_fields)

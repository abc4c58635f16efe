"""A goal as typed on a command line: YAML on one line, checked against the action's goal message."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, get_args

from pydantic import ValidationError

from hmrsim.cli.exits import WrongUse
from hmrsim.diagnostics import dotted, shown
from hmrsim.documents import yaml_text

if TYPE_CHECKING:
    from pydantic import BaseModel

    from hmrsim.diagnostics import Path
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.errors import RequestError

# By pydantic's texts, which the simulator's error replies have, too.
_WANTED: Final = {
    "Field required": "required field is missing",
    "Input should be a valid number": "expected a number",
    "Input should be a finite number": "expected a finite number",
    "Input should be a valid integer": "expected an integer",
    "Input should be a valid integer, got a number with a fractional part": "expected an integer",
    "Input should be a valid string": "expected a string (quote it if it looks like a number)",
    "Input should be a valid boolean": "expected true or false",
    "Input should be a valid list": "expected a list",
    "Input should be a valid array": "expected a list",
    "Input should be an object": "expected a mapping",
    "Keys should be strings": "expected a field name",
}
_MAPPING: Final = "Input should be a valid dictionary"
_MISSING: Final = "Field required"
_UNKNOWN: Final = "Extra inputs are not permitted"


def read_yaml(text: str, noun: str = "goal") -> object:
    """Return the plain values that a goal's text stands for, in the YAML of world files: ``1e3`` is a number.

    Raises:
        WrongUse: It is not YAML, or has a key twice.
    """
    try:
        data, _, findings = yaml_text.read_yaml(text)
    except yaml_text.Unreadable as error:
        raise WrongUse(f"{noun}: {error}; expected a mapping such as '{{target_name: coffee}}'") from None
    if findings:
        raise WrongUse("\n".join(f"{noun}: {dotted(finding.path)}: {finding.message}" for finding in findings))
    return data


def read_goal(data: object, kind: type[Message]) -> Message:
    """Return the goal that plain values stand for; integers will do for floats.

    Raises:
        WrongUse: They are not of this *kind*; one line per error.
    """
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        mistakes = [(details["loc"], details["msg"], details["input"]) for details in error.errors(include_url=False)]
        raise WrongUse("\n".join(mistake("goal", *found, kind) for found in mistakes)) from None


def mistake(noun: str, path: Path, message: str, value: object, kind: type[BaseModel] | None = None) -> str:
    """Return one line about an error that pydantic found, here or in the simulator."""
    where = ": ".join(part for part in (noun, dotted(path)) if part)
    if message == _UNKNOWN and value is None and ":" in str(path[-1]):
        return f"{where}: put a space after the colon, as in '{str(path[-1]).replace(':', ': ', 1)}'"
    if message == _UNKNOWN:
        there = "remove it" if kind is None else f"known fields: {', '.join(_fields(kind, path[:-1])) or 'none'}"
        return f"{where}: unknown field; {there}"
    wanted = "expected a mapping" if message.startswith(_MAPPING) else _WANTED.get(message)
    text = wanted or message[:1].lower() + message[1:]
    if message == _MISSING or repr(value) in text:
        return f"{where}: {text}"
    return f"{where}: {text}, got {shown(value)}"


def mistakes_in_reply(
    noun: str, error: RequestError, data: object = None, kind: type[BaseModel] | None = None
) -> WrongUse:
    """Return the error of a simulator's error reply, one line per problem.

    Args:
        noun: The part with the errors; it is not repeated where a field begins with it.
        error: The reply.
        data: The plain values that were sent, where they are at hand: a reply has lists and mappings as text only.
        kind: The expected type.
    """
    lines = []
    for item in error.details:
        field, message = str(item.get("field", "")), str(item.get("message", ""))
        path = tuple(int(step) if step.isdecimal() else step for step in field.split(".")) if field else ()
        value = _at(data, path, item.get("value"))
        lines.append(
            mistake(noun, path[path[:1] == (noun,) :], message, value, kind) if field else f"{noun}: {message}"
        )
    return WrongUse("\n".join(lines) or f"{noun}: {error}")


def _at(data: Any, path: Path, default: object) -> object:
    """Return the value at *path*."""
    try:
        for step in path:
            data = data[step]
    except (LookupError, TypeError):
        return default
    return data


def _fields(kind: type[BaseModel], path: Path) -> list[str]:
    """Return the names of the fields of the message at *path*; none if the simulator's has another form than ours."""
    here: Any = kind
    try:
        for step in path:
            here = here.model_fields[step].annotation if isinstance(step, str) else get_args(here)[0]
        return list(here.model_fields)
    except (LookupError, AttributeError):
        return []

"""Goals on the command line: parsing YAML, error messages, examples, and short forms of messages."""

from __future__ import annotations

import re
from contextlib import suppress
from itertools import chain
from shlex import quote
from typing import TYPE_CHECKING, Any, Final, get_args

from pydantic import ValidationError

from hmrsim.cli.connection import value_of
from hmrsim.cli.options import WrongUse
from hmrsim.diagnostics import dotted, instead, shown
from hmrsim.documents import yaml_text
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Duration, Time
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.message import Message
from hmrsim_zenoh.client.places import with_names

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic import BaseModel

    from hmrsim.actions import AnyAction
    from hmrsim.diagnostics import Path
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.errors import RequestError


# The keys are pydantic's texts, which are also in the simulator's error replies.
_EXPECTED: Final = {
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
_TYPE: Final = re.compile(r"\w+(/\w+)+")
_EXPECTED_MAPPING: Final = "expected a mapping"
_POSES: Final = (list(PoseStamped.model_fields), list(Pose.model_fields))
"""The fields of messages that may be given as the name of a place or as coordinates."""

_MAPPING: Final = "Input should be a valid dictionary"
_MISSING: Final = "Field required"
_UNKNOWN: Final = "Extra inputs are not permitted"


def type_and_text(ros_type: str | None, text: str | None, owner: str, noun: str) -> tuple[str | None, str | None]:
    """Return a ROS type and the text after it; if only one is given, its form tells which it is.

    *owner* is what has the type, such as ``an action``, and *noun* what the text is, such as ``goal``.

    Raises:
        WrongUse: The shell has split the text at its spaces.
    """
    if ros_type is None or _TYPE.fullmatch(ros_type):
        return ros_type, text
    if text is not None:
        whole = quote(f"{ros_type} {text}")
        raise WrongUse(f"{ros_type!r} is not {owner}'s type; if it is part of the {noun}, quote the {noun}: {whole}")
    return None, ros_type


def read_yaml(text: str, noun: str = "goal") -> object:
    """Parse a goal or request, in the YAML of world files: ``1e3`` is a number.

    Raises:
        WrongUse: The text is not YAML, or has a duplicate key.
    """
    try:
        data, _, findings = yaml_text.read_yaml(text)
    except yaml_text.Unreadable as error:
        raise WrongUse(f"{noun}: {error}; expected a mapping such as '{{target_name: coffee}}'") from None
    if findings:
        raise WrongUse("\n".join(f"{noun}: {dotted(finding.path)}: {finding.message}" for finding in findings))
    return data


def read_goal(data: object, kind: type[Message]) -> Message:
    """Return plain values as a goal message; integers are accepted as floats.

    Raises:
        WrongUse: The values don't fit the message; the text has one line per error.
    """
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        details = [(each["loc"], each["msg"], each["input"]) for each in error.errors(include_url=False)]
        raise WrongUse("\n".join(_error_line("goal", *each, kind) for each in details)) from None


def _error_line(noun: str, path: Path, message: str, value: object, kind: type[BaseModel] | None = None) -> str:
    """Return one line about a validation error, found here or by the simulator."""
    where = ": ".join(part for part in (noun, dotted(path)) if part)
    if message == _UNKNOWN and value is None and ":" in str(path[-1]):
        return f"{where}: put a space after the colon, as in '{str(path[-1]).replace(':', ': ', 1)}'"
    if message == _UNKNOWN:
        known = [] if kind is None else _fields(kind, path[:-1])
        remedy = "; remove it" if kind is None else instead(str(path[-1]), known, verb="known fields:")
        return f"{where}: unknown field{remedy}"
    expected = _EXPECTED_MAPPING if message.startswith(_MAPPING) else _EXPECTED.get(message)
    if expected == _EXPECTED_MAPPING and kind is not None and _fields(kind, path) in _POSES:
        expected = "expected the name of a place, [x, y], [x, y, yaw] or a mapping"
    text = expected or message[:1].lower() + message[1:]
    if message == _MISSING or repr(value) in text:
        return f"{where}: {text}"
    return f"{where}: {text}, got {shown(value)}"


def errors_of_reply(
    noun: str, error: RequestError, data: object = None, kind: type[BaseModel] | None = None
) -> WrongUse:
    """Return the error for a simulator's error reply, one line per problem.

    Args:
        noun: The noun for the request, such as ``goal``; it is not repeated if a field begins with it.
        error: The reply.
        data: The plain values that were sent, if known: a reply has lists and mappings only as text.
        kind: The expected message.
    """
    lines = []
    for item in error.details:
        field, message = str(item.get("field", "")), str(item.get("message", ""))
        path = tuple(int(step) if step.isdecimal() else step for step in field.split(".")) if field else ()
        value = _at(data, path, item.get("value"))
        lines.append(
            _error_line(noun, path[path[:1] == (noun,) :], message, value, kind) if field else f"{noun}: {message}"
        )
    return WrongUse("\n".join(lines) or f"{noun}: {error}")


def _at(data: Any, path: Path, default: object) -> object:
    """Return the value at *path*, or *default*."""
    try:
        for step in path:
            data = data[step]
    except (LookupError, TypeError):
        return default
    return data


def _fields(kind: type[BaseModel], path: Path) -> list[str]:
    """Return the field names of the message at *path*; none if the simulator's message differs from ours."""
    here: Any = kind
    try:
        for step in path:
            here = here.model_fields[step].annotation if isinstance(step, str) else get_args(here)[0]
        return list(here.model_fields)
    except (LookupError, AttributeError):
        return []


def example_of(client: Client, action: AnyAction, robot: str) -> Mapping[str, Any] | None:
    """Return an example of a goal in plain values, with names of the running world if the simulator tells them.

    Returns:
        None if the action has no example.
    """
    if not action.example:
        return action.example
    # A simulator of another version may describe its world otherwise.
    with suppress(HmrsimError, LookupError, TypeError, ValueError):
        places, choices = _names_in(client, robot)
        example: dict[str, Any] = with_names(dict(action.example), action.goal, iter(places))
        for field, given in (action.inputs or {}).items():
            if field in example and (names := choices.get(given.choices)):
                example[field] = names[0]
        return example
    return action.example


def _names_in(client: Client, robot: str) -> tuple[list[str], dict[str, list[str]]]:
    """Return the names of places to drive to, and those for each kind of choices in `hmrsim.actions._inputs.Input`."""
    scene = value_of(client, "scene")
    docks = [one["name"] for one in scene["fixtures"] if one["kind"] == "dock"]
    items = [one["name"] for one in scene["items"]]
    held = [one["name"] for one in scene["items"] if one["carrier"] == robot]
    places = [name for name in client.places.load() if name not in docks]
    return places, {"docks": docks, "items": items, "held": list(chain(held, items))}


_MEANINGFUL_AT_ZERO: Final = (Duration, Time, Point, Pose)
"""Messages that are meaningful even if all their fields are zero."""


def without_defaults(message: Message) -> dict[str, Any]:
    """Return the plain values of a message without fields that have default values.

    Numbers and *error_code* are always included, since 0 may be of interest.
    """
    fields = {name: getattr(message, name) for name in type(message).model_fields}
    return {name: _value(value) for name, value in fields.items() if name == "error_code" or _is_shown(value)}


def _is_shown(value: object) -> bool:
    if isinstance(value, Message):
        return isinstance(value, _MEANINGFUL_AT_ZERO) or value != type(value)()
    return not isinstance(value, (str, list)) or bool(value)


def _value(value: object) -> object:
    if isinstance(value, Message):
        return without_defaults(value)
    if isinstance(value, list):
        return [_value(part) for part in value]
    return value


def one_line(message: Message) -> str:
    """Return the fields of a message on one line: durations in seconds, poses as points, lists as their lengths."""
    fields = {name: getattr(message, name) for name in type(message).model_fields}
    return ", ".join(f"{name} {_short(value)}" for name, value in fields.items() if _is_shown(value))


def _short(value: object) -> str:
    match value:
        case float():
            return f"{value:.2f}"
        case Duration() | Time():
            return f"{value.sec + value.nanosec / NANOSECONDS:.1f} s"
        case PoseStamped(pose=Pose(position=point)) | Pose(position=point):
            return f"({point.x:.2f}, {point.y:.2f})"
        case Message():
            return f"{{{one_line(value)}}}"
        case list():
            return f"[{len(value)}]"
    return str(value)

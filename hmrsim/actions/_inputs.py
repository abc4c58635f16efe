"""The inputs of users: fields of a goal in forms, and arguments of script orders."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, get_args, get_origin

from hmrsim.diagnostics import instead
from hmrsim.geometry import MAX_COORDINATE
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion

if TYPE_CHECKING:
    from pydantic import BaseModel
    from pydantic.fields import FieldInfo

    from hmrsim.world.model import World


_TYPES: Final = {bool: "boolean", int: "integer", float: "number", str: "string"}
_FORMATS: Final = {"geometry_msgs/msg/PoseStamped": "pose", "builtin_interfaces/msg/Duration": "duration"}
_BOUNDS: Final = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}


@dataclass(frozen=True)
class Input:
    """One field of a form.

    Attributes:
        unit: ``m`` and ``m/s`` become the world's unit of length.
        default: Its initial value; None for the message's default, or empty where it is required.
        choices: Which entities are proposed: ``items``, ``held`` (items that the robot holds) or ``docks``.
        advanced: Whether most users keep its default.
    """

    title: str
    unit: str = ""
    default: float | str | bool | None = None
    minimum: float | None = None
    required: bool = False
    choices: str = ""
    advanced: bool = False


def goal_schema(goal: type[BaseModel], inputs: Mapping[str, Input] | None) -> dict[str, Any]:
    """Return the JSON Schema of the part of a goal that a form shows, nested as the message is.

    Beside JSON Schema's own words there are ``unit``, ``choices`` and ``advanced``, and the formats ``pose``
    (geometry_msgs/msg/PoseStamped) and ``duration`` (builtin_interfaces/msg/Duration).

    *inputs* are the fields to show, by their dotted path in the message; None for all that can be shown.
    """
    if inputs is None:
        inputs = {name: Input(title_of(name)) for name, field in goal.model_fields.items() if _typed(field)}
    root: dict[str, Any] = {"type": "object", "properties": {}}
    for path, given in inputs.items():
        *parents, name = path.split(".")
        part, kind = root, goal
        for parent in parents:
            kind = kind.model_fields[parent].annotation  # type: ignore[assignment]  # a message, as the path says
            part = part["properties"].setdefault(parent, {"type": "object", "properties": {}})
        field = kind.model_fields[name]
        part["properties"][name] = {"title": given.title, **_typed(field), **dict(_keywords(given, field))}
        if given.required:
            part.setdefault("required", []).append(name)
    return root


def title_of(name: str) -> str:
    """Return the default label of a field or an action: its name in words."""
    return name.replace("_", " ").capitalize()


def _typed(field: FieldInfo) -> dict[str, Any]:
    """Return the type and bounds of a field; empty if no form can show it."""
    kind: Any = field.annotation
    if get_origin(kind) is list:
        one = _format(get_args(kind)[0])
        return {"type": "array", "items": {"type": "object", "format": one}} if one == "pose" else {}
    if kind in _TYPES:
        bounds = {
            word: getattr(part, name)
            for part in field.metadata
            for name, word in _BOUNDS.items()
            if hasattr(part, name)
        }
        return {"type": _TYPES[kind], **bounds}
    one = _format(kind)
    return {"type": "object", "format": one} if one else {}


def _format(kind: Any) -> str:
    return _FORMATS.get(getattr(kind, "ros_type", ""), "")


def _keywords(given: Input, field: FieldInfo) -> Iterator[tuple[str, Any]]:
    default = given.default
    if default is None and isinstance(field.default, (bool, int, float, str)) and not given.required:
        default = field.default
    if default is not None:
        yield "default", default
    if given.minimum is not None:
        yield "minimum", given.minimum
    yield from ((word, value) for word in ("unit", "choices", "advanced") if (value := getattr(given, word)))


def numbers(words: list[str]) -> list[float]:
    """Return words as numbers.

    Raises:
        ValueError: One is not a number, or not finite.
    """
    values = []
    for word in words:
        try:
            value = float(word)
        except ValueError:
            raise ValueError(f"{word!r} is not a number") from None
        if not math.isfinite(value):
            raise ValueError(f"{word!r} is not a finite number")
        values.append(value)
    return values


def pose(x: float, y: float, yaw: float = 0.0) -> PoseStamped:
    """Return a pose in the plane as a ROS message; the frame is the default one."""
    facing = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return PoseStamped(pose=Pose(position=Point(x=x, y=y), orientation=facing))


def place(text: str, world: World) -> tuple[float, float]:
    """Return the point that a text names: a waypoint, place or dock, or x and y.

    Raises:
        ValueError: There is nothing of that name, and it isn't two numbers.
    """
    try:
        return world.point(text)
    except KeyError:
        pass
    words = text.replace(",", " ").split()
    try:
        x, y = numbers(words)
    except ValueError:
        known = [*world.waypoints, *world.places, *world.docks]
        raise ValueError(f"no waypoint, place or dock {text!r}{instead(text, known)}") from None
    check_reachable(x, y)
    return x, y


def places(text: str, world: World) -> list[PoseStamped]:
    """Return the poses that a text names, places or points with semicolons between them.

    Raises:
        ValueError: One of them isn't there, or there is none.
    """
    return [pose(*place(word.strip(), world)) for word in text.split(";")]


def check_reachable(x: float, y: float) -> None:
    """Check that a map can have this point.

    Raises:
        ValueError: It is beyond all coordinates.
    """
    if max(abs(x), abs(y)) > MAX_COORDINATE:
        raise ValueError(f"({x:g}, {y:g}) is outside any map: coordinates end at {MAX_COORDINATE:g}")

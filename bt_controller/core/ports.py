"""The kinds of ports of XML trees' nodes, and their text format in files.

A value in a file is text, and so is a text that `Script` or ``--set`` writes on the blackboard: a port parses it as its
kind. The output of another node is a value already.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, Protocol, Self, TypeVar

from py_trees.common import Status
from py_trees.ports import PortInformation

from hmrsim.diagnostics import shortened, shown
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from hmrsim.interfaces.nav2_msgs import Route, TrackingFeedback
from hmrsim.interfaces.nav_msgs import Path
from hmrsim.interfaces.std_msgs import Header
from hmrsim_zenoh.client.places import pose_at

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

T = TypeVar("T")


class Places(Protocol):
    """Knows the named places of the world."""

    def pose(self, name: str) -> PoseStamped:
        """Return the pose of a place.

        Raises:
            ValueError: There is no such place; the text lists the places.
        """


class Given(str):
    """A text of the user on the blackboard, with its key: error messages refer to it as ``--set KEY=TEXT``."""

    __slots__ = ("key",)

    key: str

    def __new__(cls, text: str, key: str = "") -> Self:
        """Return the text."""
        given = super().__new__(cls, text)
        given.key = key
        return given


@dataclass(frozen=True)
class Kind(Generic[T]):
    """The kind of a port's values.

    Attributes:
        name: The type's name in BehaviorTree.CPP or ROS.
        type: Its Python type; `object` for anything.
        parse: Parses a text; raises ValueError with the expected format. Without places, any name is accepted as a
            place.
        served: The texts that have an effect in this simulator; empty for any.
    """

    name: str
    type: Any
    parse: Callable[[str, Places | None], T]
    served: tuple[str, ...] = ()

    def read(self, text: str, places: Places | None) -> T:
        """Return the value of a text; without places, any name is accepted as a place.

        Raises:
            ValueError: The text is invalid; the error names the expected format.
        """
        try:
            return self.parse(text, places)
        except ValueError as error:
            option = f"--set {text.key}={shortened(text)}: " if isinstance(text, Given) else ""
            raise ValueError(f"{option}{error}") from None

    def doubt(self, text: str) -> str | None:
        """Return a warning about a valid text that has no effect in this simulator."""
        if not self.served or text in self.served:
            return None
        return f"no robot serves {shown(text)}; there are {', '.join(filter(None, self.served))}"

    def holds(self, value: object) -> bool:
        """Return whether a value is of this kind without parsing."""
        if self.type is float:
            return isinstance(value, (int, float)) and not isinstance(value, bool)
        if self.type is int:
            return isinstance(value, int) and not isinstance(value, bool)
        return isinstance(value, self.type)


@dataclass(frozen=True)
class Port(PortInformation):
    """A port of a node; made by `input_port` and `output_port`."""

    kind: Kind[Any] = None  # type: ignore[assignment]  # fields of the base class have defaults


def input_port(kind: Kind[Any], description: str = "", *, default: Any = None, required: bool | None = None) -> Port:
    """Return an input port; required unless it has a default or *required* is False."""
    needed = default is None if required is None else required
    return Port(_declared(kind), required=needed, description=description, default_value=default, kind=kind)


def output_port(kind: Kind[Any], description: str = "") -> Port:
    """Return an output port; a tree need not use it."""
    return Port(_declared(kind), required=False, description=description, kind=kind)


def _declared(kind: Kind[Any]) -> Any:
    """Return the type for py_trees: the text in a file remains text until the port parses it."""
    return str | kind.type


def _text(text: str, _places: Places | None) -> str:
    return text


def _real(text: str, _places: Places | None) -> float:
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{shown(text)} is not a number") from None
    if math.isnan(value):
        raise ValueError(f"{shown(text)} is not a number")
    return value


def _whole(text: str, _places: Places | None) -> int:
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"{shown(text)} is not a whole number") from None


N = TypeVar("N", int, float)


def _limited(parse: Callable[[str, Places | None], N], holds: Callable[[N], bool], what: str) -> Callable[..., N]:
    """Return a parser of numbers for which a condition holds."""

    def limited(text: str, places: Places | None = None) -> N:
        value = parse(text, places)
        if not holds(value):
            raise ValueError(f"{shown(text)} is not {what}")
        return value

    return limited


_finite: Final = _limited(_real, math.isfinite, "a finite number")


def _truth(text: str, _places: Places | None) -> bool:
    truths = {"true": True, "1": True, "false": False, "0": False}
    if text.lower() not in truths:
        raise ValueError(f"{shown(text)} is neither true nor false")
    return truths[text.lower()]


def _status(text: str, _places: Places | None) -> Status:
    if text.strip() not in _STATUSES:
        raise ValueError(f"{text!r} is not a status; expected SUCCESS, FAILURE, RUNNING or SKIPPED")
    return _STATUSES[text.strip()]


def _whole_numbers(text: str, places: Places | None) -> list[int]:
    """Return whole numbers separated by ``;``."""
    return [_whole(part, places) for part in text.split(";") if part.strip()]


def _pose(text: str, places: Places | None) -> PoseStamped:
    """Return ``x;y``, ``x;y;yaw`` (meters or pixels, radians), ``sec;frame;x;y;z;qx;qy;qz;qw`` or a place's pose."""
    parts = [*map(str.strip, text.split(";"))]
    if len(parts) == 1:
        if places is not None:
            return places.pose(text)
        if not text.strip():
            raise ValueError("'' is not a pose; expected x;y, x;y;yaw or the name of a place")
        return PoseStamped()
    try:
        match parts:
            case [x, y]:
                return pose_at(_finite(x), _finite(y))
            case [x, y, yaw]:
                return pose_at(_finite(x), _finite(y), _finite(yaw))
            case [_, frame, x, y, z, *turned] if len(turned) == _QUATERNION:
                at = Point(x=_finite(x), y=_finite(y), z=_finite(z))
                qx, qy, qz, qw = map(_finite, turned)
                pose = Pose(position=at, orientation=Quaternion(x=qx, y=qy, z=qz, w=qw))
                return PoseStamped(header=Header(frame_id=frame), pose=pose)
    except ValueError:
        pass
    raise ValueError(f"{shown(text)} is not a pose; expected x;y, x;y;yaw, Nav2's nine fields or the name of a place")


def _poses(text: str, places: Places | None) -> list[PoseStamped]:
    """Return poses separated by ``|``."""
    return [_pose(part, places) for part in text.split("|")]


def message_kind(message: type[Message]) -> Kind[Any]:
    """Return the kind of a message that has no text format, so that only another node can write it."""
    name = message.ros_type.replace("/msg/", "/")

    def refuse(text: str, _places: Places | None) -> Message:
        raise ValueError(f"{shown(text)} is not a {name}; expected a key of the blackboard")

    return Kind(name, message, refuse)


def _path(text: str, places: Places | None) -> Path:
    return Path(poses=_poses(text, places))


_QUATERNION: Final = 4

_STATUSES: Final = {
    "SUCCESS": Status.SUCCESS,
    "FAILURE": Status.FAILURE,
    "RUNNING": Status.RUNNING,
    "SKIPPED": Status.INVALID,
}
"""Statuses, named as in BehaviorTree.CPP."""
MAX_WAYPOINT_ID: Final = (1 << 16) - 1
"""The largest id in Nav2's messages."""
_MAX_UNSIGNED: Final = (1 << 32) - 1
"""The largest unsigned number of BehaviorTree.CPP."""

STRING: Final = Kind("string", str, _text)
DOUBLE: Final = Kind("double", float, _real)
FINITE: Final = Kind("double", float, _finite)
"""A length, a speed, a duration."""
POSITIVE: Final = Kind("double", float, _limited(_real, lambda number: number > 0.0, "a number greater than 0"))
SHARE: Final = Kind("double", float, _limited(_real, lambda number: 0.0 <= number <= 1.0, "a number from 0 to 1"))
INT: Final = Kind("int", int, _whole)
UNSIGNED: Final = Kind(
    "unsigned int",
    int,
    _limited(_whole, lambda number: 0 <= number <= _MAX_UNSIGNED, f"a whole number from 0 to {_MAX_UNSIGNED}"),
)
WAYPOINT_ID: Final = Kind(
    "unsigned int",
    int,
    _limited(
        _whole, lambda number: 0 <= number <= MAX_WAYPOINT_ID, f"the id of a waypoint, from 0 to {MAX_WAYPOINT_ID}"
    ),
)
CHILDREN: Final = Kind("int", int, _whole)
"""A number of children; negative numbers count from the end."""
INTS: Final = Kind("int[]", list, _whole_numbers)
BOOL: Final = Kind("bool", bool, _truth)
STATUS: Final = Kind("NodeStatus", Status, _status)
POSE: Final = Kind("geometry_msgs/PoseStamped", PoseStamped, _pose)
POSES: Final = Kind("geometry_msgs/PoseStamped[]", list, _poses)
PATH: Final = Kind("nav_msgs/Path", Path, _path)
DURATION: Final = message_kind(Duration)
ROUTE: Final = message_kind(Route)
TRACKING: Final = message_kind(TrackingFeedback)
PLANNER: Final = Kind("string", str, _text, served=("", "GridBased", "graph"))
CONTROLLER: Final = Kind("string", str, _text, served=("", "FollowPath"))
SMOOTHER: Final = Kind("string", str, _text, served=("", "simple_smoother", "route_smoother"))
ANY: Final[Kind[Any]] = Kind("any", object, _text)

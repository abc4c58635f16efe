"""The named places of a world, and poses given by name.

Wherever a goal has a pose, it may be the name of a waypoint, place or dock, or a list or tuple: x, y and optional yaw.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Final, TypeAlias, get_args

from hmrsim.diagnostics import dotted, instead, shortened, shown
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion
from hmrsim.interfaces.message import defaults, is_message
from hmrsim.interfaces.std_msgs import Header

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path
    from hmrsim.interfaces.message import Message
    from hmrsim.interfaces.simulation_interfaces import GetNamedPoses

Target = str | tuple[float, float] | tuple[float, float, float] | PoseStamped
"""A destination: the name of a waypoint, place or dock; x, y and optionally yaw, in the world's unit of length and
radians; or a pose."""

_Change: TypeAlias = "Callable[[Any, type[Message], Path], Any]"

_COORDINATES: Final = (2, 3)

_HEADER: Final = Header()

_EXPECTED: Final = "expected the name of a place, finite numbers (x, y) or (x, y, yaw), or a PoseStamped"


class NamedPlaces:
    """The waypoints, places and docks of a world by name, queried from the simulator upon first use.

    Args:
        ask: Calls the service ``get_named_poses`` for all places, and returns its response.
    """

    def __init__(self, ask: Callable[[], GetNamedPoses.Response]) -> None:
        self._ask = ask
        self._poses: Mapping[str, Pose] | None = None
        self._stamped: dict[str, PoseStamped] = {}

    def pose(self, target: Target, argument: str = "target") -> PoseStamped:
        """Return the pose of a target; errors name the *argument* that has it.

        Raises:
            ValueError: There is no place of this name.
            TypeError: It is no target.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError: The simulator does not answer.
        """
        if isinstance(target, PoseStamped):
            return target
        if not isinstance(target, str):
            try:
                return pose_at(*target)
            except (TypeError, ValueError):
                raise TypeError(f"{argument}: {_EXPECTED}, got {shortened(repr(target))}") from None
        stamped = self._stamped.get(target)
        if stamped is None:
            poses = self.load()
            if target not in poses:
                raise ValueError(f"no place {shown(target)}{instead(target, sorted(poses))}")
            # Its parts are valid.
            stamped = self._stamped[target] = PoseStamped.model_construct({"pose"}, header=_HEADER, pose=poses[target])
        return stamped

    def load(self) -> Mapping[str, Pose]:
        """Return the poses by name, and query them first if necessary.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError: The simulator does not answer.
        """
        if self._poses is None:
            self._poses = {named.name: named.pose for named in self._ask().poses}
        return self._poses


def pose_at(x: float, y: float, yaw: float = 0.0) -> PoseStamped:
    """Return a pose on the map; *x* and *y* in the world's unit of length, *yaw* in radians."""
    orientation = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return PoseStamped(pose=Pose(position=Point(x=float(x), y=float(y)), orientation=orientation))


def with_poses(data: Any, kind: type[Message], pose: Callable[[str], PoseStamped]) -> Any:
    """Return the plain values of a goal with names of places, and lists or tuples of x, y and yaw, replaced by poses.

    Args:
        data: The goal, which need not be valid.
        kind: Its message type.
        pose: Returns the pose of a place; raises `ValueError` for an unknown name.

    Raises:
        ValueError: A place does not exist; one line per error.
    """
    errors: list[str] = []

    def pose_of(value: Any, field: type[Message], path: Path) -> Any:
        if not isinstance(value, str) and not _are_coordinates(value):
            return value
        try:
            stamped = pose(value) if isinstance(value, str) else pose_at(*value)
        except ValueError as error:
            errors.append(f"goal: {dotted(path)}: {error}")
            return value
        return (stamped if field is PoseStamped else stamped.pose).model_dump(mode="json")

    values = _map_poses(data, kind, pose_of)
    if errors:
        raise ValueError("\n".join(errors))
    return values


def _are_coordinates(value: Any) -> bool:
    """Return whether a value is a list or tuple of x, y and optionally yaw: finite numbers."""
    if not isinstance(value, (list, tuple)) or len(value) not in _COORDINATES:
        return False
    return all(type(part) in (int, float) and abs(part) <= sys.float_info.max for part in value)


def with_names(data: Any, kind: type[Message], names: Iterator[str]) -> Any:
    """Return the plain values of a goal with each of its poses replaced by the next of some *names*."""
    return _map_poses(data, kind, lambda value, _kind, _path: next(names, value))


def _map_poses(data: Any, kind: type[Message], change: _Change, path: Path = ()) -> Any:
    if kind is Pose or kind is PoseStamped:
        return change(data, kind, path)
    if not isinstance(data, Mapping) or data is defaults(kind):
        return data
    values, fields = dict(data), _fields_with_poses(kind)
    for name in [name for name in values if name in fields]:
        value, (of, is_list) = values[name], fields[name]
        if not is_list:
            values[name] = _map_poses(value, of, change, (*path, name))
        elif isinstance(value, (list, tuple)):
            values[name] = [_map_poses(each, of, change, (*path, name, at)) for at, each in enumerate(value)]
    return values


@cache
def _fields_with_poses(kind: type[Message]) -> dict[str, tuple[type[Message], bool]]:
    """Return the fields that are or contain poses: the type of their messages, and whether they are lists."""
    found = {}
    for name, field in kind.model_fields.items():
        items = get_args(field.annotation)
        of: Any = items[0] if items else field.annotation
        if is_message(of) and (of in (Pose, PoseStamped) or _fields_with_poses(of)):
            found[name] = of, bool(items)
    return found

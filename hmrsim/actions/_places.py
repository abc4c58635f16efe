"""Arguments of script orders: places and numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.geometry import MAX_COORDINATE
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, Quaternion

if TYPE_CHECKING:
    from hmrsim.world.model import World


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

"""Checks of the poses where robots and items can be placed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.geometry import SAME_PLACE
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.services._entities import BadPose

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.navigation.graph import WaypointGraph
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import Base


def check(graph: WaypointGraph, point: Point, *, robot: bool) -> None:
    """Check that a robot, or else an item, can be at a point: items may lie inside of obstacles, such as shelves.

    Raises:
        BadPose: It can't.
    """
    try:
        graph.check_start(point)
    except NoRoute as error:
        if robot or error.code != ComputePathToPose.Result.START_OCCUPIED:
            raise BadPose(str(error).removeprefix("start ")) from None


def check_room(simulator: Simulator, point: Point, base: Base, name: str = "") -> None:
    """Check that no other robot's footprint overlaps that of a robot with this base.

    Raises:
        BadPose: One is.
    """
    own = base.radius or 0.0
    for other in () if base.flies else simulator.robots.values():
        room = max(SAME_PLACE, own + other.radius)
        if other.is_within(room, point) and other.name != name and not other.flies:
            x, y = point
            raise BadPose(f"({x:g}, {y:g}) is {other.distance_to(point):.3g} from {other.name}; keep {room:g} away")
    full = None if base.flies else simulator.roster.admission.full_at(point, own, name)
    if full is not None:
        raise BadPose(f"({point[0]:g}, {point[1]:g}) {full}, where there is no room for one more robot")

"""Where robots and items can be put."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.errors import NoRoute
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.services._entities import BadPose

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.graph import WaypointGraph


def check(graph: WaypointGraph, point: Point, *, robot: bool) -> None:
    """Do nothing if a robot, or else an item, can be at a point: items may lie inside of obstacles, such as shelves.

    Raises:
        BadPose: It can't.
    """
    try:
        graph.check_start(point)
    except NoRoute as error:
        if robot or error.code != ComputePathToPose.Result.START_OCCUPIED:
            raise BadPose(str(error).removeprefix("start ")) from None

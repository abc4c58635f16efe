"""Path planning along the lanes without driving: planner names, and paths as messages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.actions import Flaw
from hmrsim.geometry import Pose
from hmrsim.interfaces.nav_msgs import Path

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from hmrsim.geometry import Point
    from hmrsim.navigation.route import Route
    from hmrsim.robots.robot import Robot

_PLANNERS = ("", "graph", "GridBased")
"""The names of the only planner: empty, its name in world files, and the default of Nav2's behavior trees."""


def planner_flaw(planner_id: str, code: int) -> Flaw | None:
    """Return the flaw of an unknown planner, with the error *code* for that; None if the planner is known."""
    if planner_id in _PLANNERS:
        return None
    return Flaw(f"no planner {planner_id!r}; there is one, called {', '.join(filter(None, _PLANNERS))}", code)


def poses_along(route: Route, start: Point, yaw: float) -> Iterator[Pose]:
    """Yield the pose at the start of each leg, facing along it, then the end (*start* without legs) with a *yaw*."""
    yield from (leg.first for leg in route.legs)
    end = route.legs[-1].end if route.legs else start
    yield Pose(*end, yaw)


def path_values(robot: Robot, poses: Sequence[Pose]) -> dict[str, Any]:
    """Return the plain values of a path through one or more poses, stamped with the current time."""
    stamped = [robot.stamped(pose) for pose in poses]
    return {"header": stamped[0]["header"], "poses": stamped}


def path_message(robot: Robot, poses: Sequence[Pose]) -> Path:
    """Return a path through one or more poses, stamped with the current time."""
    return Path.model_validate(path_values(robot, poses))

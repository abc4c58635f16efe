"""Planning paths along the lanes without driving them: the planners' names, and paths as messages."""

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
"""Names of the one planner that there is: none, that of world files, and the one that Nav2's own trees ask for."""


def planner_flaw(planner_id: str, code: int) -> Flaw | None:
    """Return why no robot has a planner, with the *code* for that; None when it has."""
    if planner_id in _PLANNERS:
        return None
    return Flaw(f"no planner {planner_id!r}; there is one, called {', '.join(filter(None, _PLANNERS))}", code)


def poses_along(route: Route, start: Point, yaw: float) -> Iterator[Pose]:
    """Yield where each leg of a route begins, facing along it, and its end with a *yaw*, or *start* without legs."""
    yield from (leg.first for leg in route.legs)
    end = route.legs[-1].end if route.legs else start
    yield Pose(*end, yaw)


def path_values(robot: Robot, poses: Sequence[Pose]) -> dict[str, Any]:
    """Return the plain values of a path of now through poses, of which there is one at least."""
    stamped = [robot.stamped(pose) for pose in poses]
    return {"header": stamped[0]["header"], "poses": stamped}


def path_message(robot: Robot, poses: Sequence[Pose]) -> Path:
    """Return a path of now through poses, of which there is one at least."""
    return Path.model_validate(path_values(robot, poses))

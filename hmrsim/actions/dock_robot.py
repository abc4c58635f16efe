"""Drive into a dock, and charge there if it is a charger."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import Action, Codes, Order, Report
from hmrsim.actions._inputs import Input, pose
from hmrsim.actions._navigation import drive, no_planner, plan, point_of
from hmrsim.diagnostics import known_name, listed
from hmrsim.errors import GoalAborted
from hmrsim.geometry import SAME_PLACE
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, values_of
from hmrsim.interfaces.nav2_msgs import DockRobot
from hmrsim.protocol.goal import Cause

if TYPE_CHECKING:
    from hmrsim.navigation.route import Route
    from hmrsim.robots.docking import DockBay
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World

_OUT_OF_ORDER: Final = "dock_out_of_order"
"""The cause of goals that end because their dock is out of order; it is the name of the fault."""

_RESULT, _STAGE = DockRobot.Result, DockRobot.Feedback


class _Docking:
    """The progress of a docking goal, which is its feedback."""

    def __init__(self, robot: Robot, report: Report[DockRobot.Feedback]) -> None:
        self._robot, self._report = robot, report
        self._began = robot.now
        self._stage = _STAGE.NONE
        report.sample(self._feedback)

    def enter(self, stage: int) -> None:
        """Begin a stage, and publish it at once."""
        self._stage = stage
        self._report.send(self._feedback())

    def _feedback(self) -> dict[str, Any]:
        time = values_of((self._robot.now - self._began) * NANOSECONDS)
        return {"state": self._stage, "docking_time": time, "num_retries": 0}


def _process(
    robot: Robot, goal: DockRobot.Goal, report: Report[DockRobot.Feedback]
) -> Generator[Any, Any, DockRobot.Result]:
    docking, began = _Docking(robot, report), robot.now
    dock = _find(robot, goal)
    if dock.spec.charges and robot.energy is None:
        raise GoalAborted(_RESULT.FAILED_TO_CHARGE, f"{robot.name} has no battery that {dock.name!r} could charge")
    if robot.dock is not dock:
        with dock.reserve(robot) as turn:
            try:
                late = GoalAborted(_RESULT.FAILED_TO_STAGE, f"it takes longer than {goal.max_staging_time:g} s")
                with robot.within(goal.max_staging_time, late):
                    yield from robot.wait_for(turn)
                    if goal.navigate_to_staging_pose:
                        docking.enter(_STAGE.NAV_TO_STAGING_POSE)
                        way = yield from plan(robot, pose(*dock.staging))
                        if 0.0 < goal.max_staging_time <= robot.now - began:
                            # Time advances while an external planner plans, without a check of the timeout.
                            raise late
                        yield from drive(robot, way, None)
            except GoalAborted as why:
                raise GoalAborted(
                    _RESULT.FAILED_TO_STAGE, f"can't line up for {dock.name!r}: {why}", why.cause
                ) from None
            docking.enter(_STAGE.INITIAL_PERCEPTION)
            _check_order(dock, _RESULT.FAILED_TO_DETECT_DOCK)
            docking.enter(_STAGE.CONTROLLING)
            yield from _drive_in(robot, dock)
            if takes := robot.draw(dock.spec.docking_time, f"docking_time/{dock.name}"):
                yield from robot.hold(takes)
            _check_order(dock, _RESULT.FAILED_TO_CONTROL)
            dock.take_in(robot)
    if dock.spec.charges:
        docking.enter(_STAGE.WAIT_FOR_CHARGE)
        _check_order(dock, _RESULT.FAILED_TO_CHARGE)
    return DockRobot.Result()


def _check_order(dock: DockBay, code: int) -> None:
    """Check that a dock is in order, which a robot notices only at some stages.

    Raises:
        GoalAborted: The dock is out of order.
    """
    if dock.out_of_order:
        raise GoalAborted(code, f"{dock.name!r} is out of order", _OUT_OF_ORDER)


def _drive_in(robot: Robot, dock: DockBay) -> Generator[Any, Any, None]:
    """Drive a robot straight into its dock.

    Raises:
        GoalAborted: An obstacle or another robot is in the way.
    """
    point, text = dock.pose.point, f"can't drive into {dock.name!r}"
    way, blocked = (robot.plan_to(point), "") if robot.flies else robot.straight_through([point])
    if blocked:
        raise robot.out_of_place(_RESULT.FAILED_TO_CONTROL, f"{text}: {blocked}", Cause.BLOCKED)
    try:
        yield from robot.drive(_shared(way), dock.spec.yaw)
    except GoalAborted as why:
        raise GoalAborted(_RESULT.FAILED_TO_CONTROL, f"{text}: {why}", why.cause) from None


def _shared(route: Route) -> Route:
    """Return the same route with an end that the robot may share with others that are docked there."""
    *before, last = route.legs or (None,)
    return route if last is None or last.slots else replace(route, legs=(*before, replace(last, shares_end=True)))


def _find(robot: Robot, goal: DockRobot.Goal) -> DockBay:
    """Return the dock of a goal, given by its id or its pose.

    Raises:
        GoalAborted: There is no such dock, or the robot can't dock there.
    """
    if goal.use_dock_id:
        dock = robot.docks.get(goal.dock_id)
        if dock is None:
            names = listed(sorted(robot.docks))
            raise GoalAborted(_RESULT.DOCK_NOT_IN_DB, f"no dock {goal.dock_id!r}; there are: {names}")
    else:
        dock = _nearest(robot, goal)
    if goal.dock_type not in ("", dock.spec.type):
        raise GoalAborted(_RESULT.DOCK_NOT_VALID, f"{dock.name!r} is a {dock.spec.type}, not a {goal.dock_type}")
    if not dock.serves(robot):
        owners = ", ".join(dock.spec.reserved_for or ())
        raise GoalAborted(_RESULT.DOCK_NOT_VALID, f"{dock.name!r} is reserved for {owners}")
    return dock


def _nearest(robot: Robot, goal: DockRobot.Goal) -> DockBay:
    """Return the dock at the pose of a goal.

    Raises:
        GoalAborted: There is no dock at that pose.
    """
    x, y = point = point_of(goal.dock_pose)
    docks = sorted(robot.docks.values(), key=lambda dock: (dock.away(point), dock.name))
    if docks and docks[0].away(point) <= SAME_PLACE:
        return docks[0]
    nearest = f"; the nearest is {docks[0].name!r}, {docks[0].away(point):g} away" if docks else ""
    raise GoalAborted(_RESULT.FAILED_TO_DETECT_DOCK, f"no dock at ({x:g}, {y:g}){nearest}")


def _ordered(text: str, world: World) -> DockRobot.Goal:
    return DockRobot.Goal(dock_id=known_name("dock", text, world.docks))


ACTION = Action(
    name="dock_robot",
    goal=DockRobot.Goal,
    result=DockRobot.Result,
    feedback=DockRobot.Feedback,
    process=_process,
    failure=lambda code, message: DockRobot.Result(success=False, error_code=code, error_msg=message),
    codes=Codes.of_nav2(_RESULT),
    frames=lambda goal: () if goal.use_dock_id else (goal.dock_pose.header.frame_id,),
    not_ready=no_planner,
    order=Order("Dock", "DOCK", _ordered),
    inputs={
        "dock_id": Input("Dock", required=True, choices="docks"),
        "navigate_to_staging_pose": Input("Navigate to the staging pose first", default=True, advanced=True),
        "max_staging_time": Input("Longest time to the staging pose", "s", minimum=0.0, advanced=True),
    },
    example={"dock_id": "charger"},
)

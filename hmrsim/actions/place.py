"""Put down the item that the gripper holds."""

from __future__ import annotations

from collections.abc import Generator
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Order, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._moveit import CODES, item_ordered
from hmrsim.components.claw import Claw
from hmrsim.errors import GoalAborted
from hmrsim.geometry import distance
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, Place, PlaceLocation

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.items import Item
    from hmrsim.robots.robot import Robot


def _process(robot: Robot, goal: Place.Goal, report: Report[Place.Feedback]) -> Generator[Any, Any, Place.Result]:
    report.send(_busy("PLANNING"))
    claw = robot.component(Claw)
    item = _held(claw, goal.attached_object_name)
    point, location = _where(robot, claw, goal)
    report.send(_busy("MONITOR"))
    yield from robot.hold(robot.draw(claw.settings.handling_time, "handling_time"))
    # It may have been taken out of the claw meanwhile.
    _held(claw, item.name)
    claw.release()
    robot.put(item, point)
    report.send(_busy("IDLE"))
    # Copies: both are large, and all but this is the same each time.
    return _done().model_copy(update={"place_location": location})


@cache
def _busy(state: str) -> Place.Feedback:
    return Place.Feedback(state=state)


@cache
def _done() -> Place.Result:
    return Place.Result(error_code=MoveItErrorCodes(val=MoveItErrorCodes.SUCCESS))


@cache
def _anywhere() -> PlaceLocation:
    return PlaceLocation()


def _held(claw: Claw, name: str) -> Item:
    """Return the item that the claw holds, if *name* is its name or is empty.

    Raises:
        GoalAborted: The claw holds nothing, or something else.
    """
    if claw.item is None:
        raise GoalAborted(MoveItErrorCodes.INVALID_OBJECT_NAME, f"the claw holds nothing, so not {name!r} either")
    if name not in ("", claw.item.name):
        raise GoalAborted(MoveItErrorCodes.INVALID_OBJECT_NAME, f"the claw holds {claw.item.name!r}, not {name!r}")
    return claw.item


def _where(robot: Robot, claw: Claw, goal: Place.Goal) -> tuple[Point, PlaceLocation]:
    """Return the first location within reach; the robot's center where none was asked for.

    Raises:
        GoalAborted: None of those asked for is within reach; or none was asked for, and traffic has moved the robot
            from where its last goal succeeded.
    """
    center = robot.pose().point
    if not goal.place_locations:
        if robot.moved_aside and robot.last_goal_succeeded:
            raise robot.out_of_place(MoveItErrorCodes.PLANNING_FAILED, "the robot is not where it was sent")
        return center, _anywhere().model_copy(update={"place_pose": robot.pose_stamped()})
    reach = claw.reach(robot.units)
    for location in goal.place_locations:
        position = location.place_pose.pose.position
        if distance(center, (position.x, position.y)) <= reach:
            return (position.x, position.y), location
    text = f"none of {len(goal.place_locations)} place locations is within reach, which is {reach:g} {robot.units}"
    raise robot.out_of_place(MoveItErrorCodes.PLANNING_FAILED, text)


ACTION = Action(
    name="place",
    goal=Place.Goal,
    result=Place.Result,
    feedback=Place.Feedback,
    process=_process,
    failure=lambda code, message: Place.Result(error_code=MoveItErrorCodes(val=code, message=message)),
    codes=CODES,
    component="claw",
    frames=lambda goal: (location.place_pose.header.frame_id for location in goal.place_locations),
    order=Order("Drop", "ITEM", lambda text, world: Place.Goal(attached_object_name=item_ordered(text, world))),
    inputs={"attached_object_name": Input("Item", required=True, choices="held")},
    example={"attached_object_name": "parcel"},
    example_after="pickup",
)

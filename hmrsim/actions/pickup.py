"""Pick up an item with the gripper."""

from __future__ import annotations

from collections.abc import Generator
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.actions import Action, Order, Report
from hmrsim.actions._inputs import Input
from hmrsim.actions._moveit import CODES, item_ordered
from hmrsim.components.claw import Claw
from hmrsim.diagnostics import listed
from hmrsim.errors import GoalAborted
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, Pickup

if TYPE_CHECKING:
    from hmrsim.items import Item
    from hmrsim.robots.robot import Robot


def _process(robot: Robot, goal: Pickup.Goal, report: Report[Pickup.Feedback]) -> Generator[Any, Any, Pickup.Result]:
    report.send(_busy("PLANNING"))
    claw = robot.component(Claw)
    _find(robot, claw, goal.target_name)
    report.send(_busy("MONITOR"))
    yield from robot.hold(robot.draw(claw.settings.handling_time, "handling_time"))
    # Meanwhile the item may have moved or gone.
    item = _find(robot, claw, goal.target_name)
    # Draw for every fault, without a short circuit: their random numbers must not depend on each other.
    if sum(misses() for misses in claw.misses):
        raise GoalAborted(MoveItErrorCodes.CONTROL_FAILED, f"the claw has missed {item.name!r}")
    robot.pick(item)
    claw.grasp(item)
    report.send(_busy("IDLE"))
    if not goal.possible_grasps:
        return _done()
    return Pickup.Result(error_code=_done().error_code, grasp=goal.possible_grasps[0])


@cache
def _busy(state: str) -> Pickup.Feedback:
    return Pickup.Feedback(state=state)


@cache
def _done() -> Pickup.Result:
    """Return the result of a success without a grasp, cached because it is large."""
    return Pickup.Result(error_code=MoveItErrorCodes(val=MoveItErrorCodes.SUCCESS))


def _find(robot: Robot, claw: Claw, name: str) -> Item:
    """Return the item of this name if the claw can take it.

    Raises:
        GoalAborted: The claw can't take it; the code tells why.
    """
    item = robot.items.get(name)
    if item is None:
        names = listed(sorted(robot.items))
        raise GoalAborted(MoveItErrorCodes.INVALID_OBJECT_NAME, f"no item {name!r}; there are: {names}")
    if claw.item is not None:
        raise GoalAborted(MoveItErrorCodes.INVALID_ROBOT_STATE, f"the claw holds {claw.item.name!r} already")
    if item.carrier is not None:
        raise GoalAborted(
            MoveItErrorCodes.MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE,
            f"{name!r} is carried by {item.carrier.name} already",
        )
    away, reach = robot.distance_to(item.position), claw.reach(robot.units)
    if away > reach:
        text = f"{name!r} is out of reach: {away:.3f} {robot.units} away, reach {reach:g}"
        raise robot.out_of_place(MoveItErrorCodes.PLANNING_FAILED, text)
    if claw.settings.max_weight is not None and item.weight > claw.settings.max_weight:
        raise GoalAborted(
            MoveItErrorCodes.CONTROL_FAILED,
            f"{name!r} is too heavy: {item.weight:g} kg, the claw lifts {claw.settings.max_weight:g} kg",
        )
    return item


ACTION = Action(
    name="pickup",
    goal=Pickup.Goal,
    result=Pickup.Result,
    feedback=Pickup.Feedback,
    process=_process,
    failure=lambda code, message: Pickup.Result(error_code=MoveItErrorCodes(val=code, message=message)),
    codes=CODES,
    component="claw",
    order=Order("Grab", "ITEM", lambda text, world: Pickup.Goal(target_name=item_ordered(text, world))),
    title="Pick up",
    inputs={"target_name": Input("Item", required=True, choices="items")},
    example={"target_name": "parcel"},
)

"""Conditions in words, which stay the same from one run to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events import EventPattern
from hmrsim.properties.model.conditions import (
    AllOf,
    AnyOf,
    BatteryCondition,
    DoorCondition,
    FaultCondition,
    ItemCondition,
    ItemsCondition,
    LaneCondition,
    Not,
    OrderCondition,
    RobotCondition,
)
from hmrsim.properties.model.part import EACH

if TYPE_CHECKING:
    from pydantic import BaseModel


def describe(condition: BaseModel) -> str:
    """Return a condition as text, such as ``eve is at lab``."""
    match condition:
        case AllOf() | AnyOf() | Not():
            return _combined(condition)
        case EventPattern():
            return condition.describe()
        case ItemCondition():
            return _item(condition)
        case RobotCondition():
            said = [f"at {condition.at}"] if condition.at else []
            return f"{_name(condition.robot)} is {' and '.join([*said, *([condition.is_] if condition.is_ else [])])}"
    return _thing(condition)


def _thing(condition: BaseModel) -> str:
    match condition:
        case BatteryCondition(battery=robot, below=below, above=above):
            limit = f"above {above:.0%}" if above is not None else f"below {below:.0%}"
            return f"the battery of {_name(robot)} is {limit}"
        case DoorCondition(door=name, is_=state) | OrderCondition(order=name, is_=state):
            return f"{'door' if isinstance(condition, DoorCondition) else 'order'} {name} is {state}"
        case FaultCondition(fault=kind, robot=robot):
            return f"{_name(robot)} has a fault {kind}" if robot else f"there is a fault {kind}"
        case ItemsCondition():
            return "all items are where they are without faults"
        case LaneCondition(lane=(start, end), is_=state):
            return f"lane {start}-{end} is {state}"
    raise TypeError(condition)


def _combined(condition: AllOf | AnyOf | Not) -> str:
    match condition:
        case AllOf(all=parts):
            return " and ".join(map(_part, parts))
        case AnyOf(any=parts):
            return " or ".join(map(_part, parts))
        case Not(not_=part):
            return f"not {_part(part)}"


def _part(condition: BaseModel) -> str:
    text = describe(condition)
    return f"({text})" if isinstance(condition, (AllOf, AnyOf)) else text


def _item(condition: ItemCondition) -> str:
    said = [f"is at {condition.at}"] if condition.at else []
    if condition.carried_by is not None:
        said.append(f"is carried by {_name(condition.carried_by)}")
    elif condition.carried is not None:
        said.append("is carried" if condition.carried else "is not carried")
    return f"{condition.item} {' and '.join(said)}"


def _name(robot: str) -> str:
    return "each robot" if robot == EACH else robot

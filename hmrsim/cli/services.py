"""The services of a running simulation, by the names that ROS gives them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hmrsim.cli.names import actions
from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.wire.keys import Verb

if TYPE_CHECKING:
    from hmrsim.cli.names import Info

_ALWAYS: Final = {"info": "hmrsim/WorldInfo", "route_graph": "hmrsim/RouteGraph"}
_OF_ACTIONS: Final = {
    Verb.SEND_GOAL: "{action}_SendGoal",
    Verb.CANCEL_GOAL: "action_msgs/srv/CancelGoal",
    Verb.GET_RESULT: "{action}_GetResult",
    Verb.EXECUTE: "hmrsim/Execute",
}


@dataclass(frozen=True)
class Service:
    """A service.

    Attributes:
        name: As in ROS, such as ``/_world/info`` or ``/wall_e/wait/_action/send_goal``.
        ros_type: The type of its requests and replies; empty when it is not known.
        hidden: Whether it is a part of an action, which ROS 2 does not list unless asked.
    """

    name: str
    ros_type: str
    hidden: bool = False


def services(info: Info) -> Iterator[Service]:
    """Yield all services: those of the world, then those of actions under all their names."""
    told = {one["name"]: one.get("type", "") for one in info.get("services", ())}
    for name, ros_type in ({f"{WORLD}/{name}": kind for name, kind in _ALWAYS.items()} | told).items():
        yield Service(f"/{name.removeprefix('/')}", ros_type)
    for action in actions(info):
        for verb, pattern in _OF_ACTIONS.items():
            ros_type = pattern.format(action=action.ros_type) if action.ros_type else ""
            yield Service(f"{action.name}/_action/{verb.value}", ros_type, hidden=True)

"""What our robots' actions, topics and services are called in ROS, and which node has them: Nav2's names."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.detections import sensors_of
from hmrsim_zenoh.keys import WORLD
from hmrsim_zenoh.ros2.keys import Node

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.services import AnyService
    from hmrsim.simulator import Simulator

NODES: Final = MappingProxyType(
    {
        "bt_navigator": ("navigate_to_pose", "navigate_through_poses"),
        "planner_server": ("compute_path_to_pose",),
        "controller_server": ("follow_path",),
        "behavior_server": ("wait", "spin", "back_up", "drive_on_heading"),
        "waypoint_follower": ("follow_waypoints",),
        "docking_server": ("dock_robot", "undock_robot"),
        "move_group": ("pickup", "place"),
    }
)
"""The actions of each node of a robot; `OTHER_NODE` has all others, and the topics but those of `LOCALIZATION`."""

OTHER_NODE: Final = "base_driver"
LOCALIZATION: Final = "amcl"
"""Has ``amcl_pose``."""
WORLD_NODE: Final = Node("/", "hmrsim")
"""Has what is the world's: the clock, transforms, the services of simulation_interfaces."""

FURTHER_NAMES: Final = MappingProxyType({"back_up": ("backup",)})
"""What Nav2 calls an action beside the name of its type."""

LIFECYCLE_SERVICE: Final = "get_state"
"""What each node of Nav2 can be asked: whether it is active."""

_WITHOUT_LIFECYCLE: Final = frozenset({"move_group", OTHER_NODE})

_ROS_SERVICES: Final = "simulation_interfaces/"
"""What the types of those of the world's services begin with that ROS has."""

_NODE_OF: Final = MappingProxyType({action: node for node, actions in NODES.items() for action in actions})


def node_of(robot: str, action: str) -> Node:
    """Return the node that serves an action."""
    return WORLD_NODE if robot == WORLD else Node(f"/{robot}", _NODE_OF.get(action, OTHER_NODE))


def ros_services(services: Mapping[str, AnyService]) -> dict[str, AnyService]:
    """Return those of the world's services that ROS has, by their names there, such as ``/spawn_entity``."""
    return {f"/{name}": one for name, one in services.items() if one.ros_type.startswith(_ROS_SERVICES)}


def names_of(simulator: Simulator) -> Names:
    """Return what a simulation serves now."""
    actions_of, robots = simulator.dispatcher.servers.actions_of, simulator.robots
    return Names(
        {name: actions_of(name) for name in (*robots, WORLD)},
        simulator.world.remap,
        powered=frozenset(name for name, robot in robots.items() if robot.energy),
        seeing=frozenset(name for name, robot in robots.items() if sensors_of(robot)),
    )


@dataclass(frozen=True)
class Names:
    """ROS's names of what is served.

    Attributes:
        serves: The actions of each robot, and under `WORLD` the world's.
        aliases: Further names of actions, ``a/b`` to ``robot/action``.
        powered: The robots that have a battery.
        seeing: The robots that have sensors.
    """

    serves: Mapping[str, list[str]]
    aliases: Mapping[str, str] = field(default_factory=dict)
    powered: frozenset[str] = frozenset()
    seeing: frozenset[str] = frozenset()

    @cached_property
    def actions(self) -> dict[str, tuple[str, str]]:
        """Robot and action by each name that they have, such as ``/wall_e/navigate_to_pose``."""
        found: dict[str, tuple[str, str]] = {}
        for robot, actions in self.serves.items():
            for action in actions:
                for name in (action, *FURTHER_NAMES.get(action, ())):
                    found[f"/{name}" if robot == WORLD else f"/{robot}/{name}"] = (robot, action)
        for alias, target in self.aliases.items():
            robot, _, action = target.partition("/")
            if action in self.serves.get(robot, ()):
                found.setdefault(f"/{alias}", (robot, action))
        return found

    @cached_property
    def of_actions(self) -> dict[tuple[str, str], list[str]]:
        """The names of each action of each robot, the first of them its own."""
        found: dict[tuple[str, str], list[str]] = {}
        for name, target in self.actions.items():
            found.setdefault(target, []).append(name)
        return found

    @cached_property
    def lifecycle(self) -> dict[str, Node]:
        """The nodes that are active, as Nav2's are, by the service that says so: ``/wall_e/amcl/get_state``."""
        nodes = [
            node
            for robot, actions in self.serves.items()
            if robot != WORLD
            for node in dict.fromkeys(
                [*(node_of(robot, action) for action in actions), Node(f"/{robot}", LOCALIZATION)]
            )
            if node.name not in _WITHOUT_LIFECYCLE
        ]
        return {f"{node.full_name}/{LIFECYCLE_SERVICE}": node for node in nodes}

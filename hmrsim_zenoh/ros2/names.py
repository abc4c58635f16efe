"""The ROS names of the robots' nodes, actions and services, which are Nav2's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.interfaces.lifecycle_msgs import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from hmrsim.interfaces.nav2_msgs import (
    ClearCostmapAroundRobot,
    ClearCostmapExceptRegion,
    ClearEntireCostmap,
    GetCostmap,
    IsPathValid,
    ManageLifecycleNodes,
    ReloadDockDatabase,
    SetRouteGraph,
)
from hmrsim.interfaces.nav_msgs import GetMap
from hmrsim.interfaces.rcl_interfaces import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from hmrsim.interfaces.std_srvs import Trigger
from hmrsim.interfaces.type_description_interfaces import GetTypeDescription
from hmrsim.protocol.goal import WORLD
from hmrsim.simulation.detections import sensors_of
from hmrsim_zenoh.ros2.keys import Node

if TYPE_CHECKING:
    from hmrsim.services import Service
    from hmrsim.simulation.simulator import Simulator

_ROBOTS: Final = 10_000
"""The number of robots whose names are cached, as one robot may join thousands of others whose names do not change."""
cached_per_robot: Final = lru_cache(_ROBOTS)


NODES: Final = MappingProxyType(
    {
        "bt_navigator": ("navigate_to_pose", "navigate_through_poses"),
        "planner_server": ("compute_path_to_pose", "compute_path_through_poses"),
        "route_server": ("compute_route", "compute_and_track_route"),
        "smoother_server": ("smooth_path",),
        "controller_server": ("follow_path",),
        "behavior_server": ("wait", "spin", "back_up", "drive_on_heading"),
        "waypoint_follower": ("follow_waypoints",),
        "docking_server": ("dock_robot", "undock_robot"),
        "move_group": ("pickup", "place"),
    }
)
"""The actions of each node of a robot; `OTHER_NODE` has the other actions, and all topics except `LOCALIZATION`'s."""

OTHER_NODE: Final = "base_driver"
LOCALIZATION: Final = "amcl"
"""The node that publishes ``amcl_pose``."""
WORLD_NODE: Final = Node("/", "hmrsim")
"""The world's node: the clock, transforms and the services of simulation_interfaces."""

MAP_SERVER: Final = Node("/", "map_server")
"""The node that publishes the map."""

FURTHER_NAMES: Final = MappingProxyType({"back_up": ("backup",)})
"""Further names of an action in Nav2, beside that of its type."""

LIFECYCLE_SERVICE: Final = "get_state"
"""The lifecycle service of each Nav2 node, which reports whether the node is active."""

_WITHOUT_LIFECYCLE: Final = frozenset({"move_group", OTHER_NODE})

_ROS_SERVICES: Final = "simulation_interfaces/"
"""The package of those services of the world that ROS has, too."""

_NODE_OF: Final = MappingProxyType({action: node for node, actions in NODES.items() for action in actions})


def has_lifecycle(node: Node) -> bool:
    """Return whether a node has the services of lifecycle nodes, as Nav2's do."""
    return bool(node.robot) and node.name not in _WITHOUT_LIFECYCLE


def node_of(robot: str, action: str) -> Node:
    """Return the node that serves an action."""
    return WORLD_NODE if robot == WORLD else Node(f"/{robot}", _NODE_OF.get(action, OTHER_NODE))


def ros_services(services: Mapping[str, Service]) -> dict[str, Service]:
    """Return the world's services that ROS has, too, by their ROS names, such as ``/spawn_entity``."""
    return {f"/{name}": one for name, one in services.items() if one.ros_type.startswith(_ROS_SERVICES)}


def names_of(simulator: Simulator) -> Names:
    """Return the ROS names that a simulation serves now."""
    actions_of, robots = simulator.dispatcher.servers.actions_of, simulator.robots
    return Names(
        {name: actions_of(name) for name in (*robots, WORLD)},
        simulator.world.remap,
        powered=frozenset(name for name, robot in robots.items() if robot.energy),
        seeing=frozenset(name for name, robot in robots.items() if sensors_of(robot)),
    )


@dataclass(frozen=True)
class Names:
    """The ROS names that a simulator serves.

    Attributes:
        serves: The actions of each robot and, as `WORLD`, of the world.
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
        """Robot and action by each of their names, such as ``/wall_e/navigate_to_pose``."""
        result: dict[str, tuple[str, str]] = {}
        for robot, actions in self.serves.items():
            result.update(named_actions(robot, tuple(actions)))
        for alias, target in self.aliases.items():
            robot, _, action = target.partition("/")
            if action in self.serves.get(robot, ()):
                result.setdefault(f"/{alias}", (robot, action))
        return result

    def called(self, robot: str, action: str) -> tuple[str, ...]:
        """Return the names of an action of a robot: its own names first, then the aliases."""
        return tuple(self._called.get((robot, action), ()))

    @cached_property
    def _called(self) -> dict[tuple[str, str], list[str]]:
        result: dict[tuple[str, str], list[str]] = {}
        for name, action in self.actions.items():
            result.setdefault(action, []).append(name)
        return result

    @cached_property
    def all_nodes(self) -> dict[str, Node]:
        """All nodes by their full names, such as ``/wall_e/amcl``."""
        of_robots = (node for nodes in self.nodes.values() for node in nodes)
        return {node.full_name: node for node in (WORLD_NODE, MAP_SERVER, *of_robots)}

    @cached_property
    def own_services(self) -> dict[str, Node]:
        """The nodes by the full names of the services that only they have."""
        return {name: node for node in self.all_nodes.values() for name in own_services(node)}

    @cached_property
    def nodes(self) -> dict[str, tuple[Node, ...]]:
        """The nodes of each robot."""
        return {robot: nodes_of(robot, tuple(actions)) for robot, actions in self.serves.items() if robot != WORLD}


@cached_per_robot
def named_actions(robot: str, actions: tuple[str, ...]) -> Mapping[str, tuple[str, str]]:
    """Return robot and action by each ROS name of a robot's actions, without aliases."""
    begin = "/" if robot == WORLD else f"/{robot}/"
    return {
        f"{begin}{name}": (robot, action) for action in actions for name in (action, *FURTHER_NAMES.get(action, ()))
    }


@cached_per_robot
def lifecycle_of(robot: str, actions: tuple[str, ...]) -> Mapping[str, Node]:
    """Return the nodes of a robot with these actions by their lifecycle services."""
    nodes = [node for node in nodes_of(robot, actions) if has_lifecycle(node)]
    return {f"{node.full_name}/{LIFECYCLE_SERVICE}": node for node in nodes}


@cached_per_robot
def nodes_of(robot: str, actions: tuple[str, ...]) -> tuple[Node, ...]:
    """Return the nodes of a robot with these actions."""
    names = dict.fromkeys([*(_NODE_OF.get(action, OTHER_NODE) for action in actions), LOCALIZATION, OTHER_NODE])
    return tuple(Node(f"/{robot}", name) for name in names)


GET_TYPE_DESCRIPTION: Final = "get_type_description"
"""The service of a node that describes the types of its endpoints."""

_OF_ALL_NODES: Final = MappingProxyType(
    {
        GET_TYPE_DESCRIPTION: GetTypeDescription,
        "describe_parameters": DescribeParameters,
        "get_parameter_types": GetParameterTypes,
        "get_parameters": GetParameters,
        "list_parameters": ListParameters,
        "set_parameters": SetParameters,
        "set_parameters_atomically": SetParametersAtomically,
    }
)
"""The services of all nodes; a client of parameters waits for all that concern parameters."""

LIFECYCLE_SERVICES: Final = MappingProxyType(
    {
        LIFECYCLE_SERVICE: GetState,
        "change_state": ChangeState,
        "get_available_states": GetAvailableStates,
        "get_available_transitions": GetAvailableTransitions,
        "get_transition_graph": GetAvailableTransitions,
    }
)
"""The further services of lifecycle nodes, as Nav2's are."""

_OF_COSTMAP: Final = {
    "get_costmap": GetCostmap,
    "clear_entirely": ClearEntireCostmap,
    "clear_except": ClearCostmapExceptRegion,
    "clear_around": ClearCostmapAroundRobot,
}


def _of_costmap(name: str) -> dict[str, Any]:
    """Return the services of a costmap, most of which end with its name, as in Nav2."""
    return {f"{name}/{verb}{f'_{name}' * (verb != 'get_costmap')}": service for verb, service in _OF_COSTMAP.items()}


def _of_manager(name: str) -> dict[str, Any]:
    return {
        f"{name}/manage_nodes": ManageLifecycleNodes,
        f"{name}/is_active": Trigger,
    }


_OWN_SERVICES: Final[Mapping[str, Mapping[str, Any]]] = MappingProxyType(
    {
        MAP_SERVER.name: {"map_server/map": GetMap},
        # Costmaps and managers as nodes of their own would cost each robot six services for parameters each.
        "bt_navigator": _of_manager("lifecycle_manager_navigation"),
        LOCALIZATION: _of_manager("lifecycle_manager_localization"),
        "planner_server": {"is_path_valid": IsPathValid, **_of_costmap("global_costmap")},
        "controller_server": _of_costmap("local_costmap"),
        "route_server": {"route_server/set_route_graph": SetRouteGraph},
        "docking_server": {"docking_server/reload_database": ReloadDockDatabase},
    }
)
"""The services that only the node of a name has, by their names below the robot's."""


def own_services(node: Node) -> dict[str, Any]:
    """Return the services that only this node has, by their full names."""
    return {f"{node.namespace.rstrip('/')}/{name}": of for name, of in _OWN_SERVICES.get(node.name, {}).items()}


NODE_SERVICES: Final[Mapping[str, Any]] = MappingProxyType({**_OF_ALL_NODES, **LIFECYCLE_SERVICES})
"""The services below the names of nodes."""


def services_of(node: Node) -> dict[str, Any]:
    """Return the services of a node by their full names."""
    of_lifecycle = LIFECYCLE_SERVICES if has_lifecycle(node) else {}
    named = {f"{node.full_name}/{name}": service for name, service in (_OF_ALL_NODES | of_lifecycle).items()}
    return named | own_services(node)

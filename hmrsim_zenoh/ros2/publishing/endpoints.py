"""The simulator's endpoints on a wire: publishers and services with their types, declared in groups called parts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, cached_property, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from hmrsim.interfaces.action_msgs import GoalStatusArray
from hmrsim.interfaces.diagnostic_msgs import DiagnosticArray
from hmrsim.interfaces.geometry_msgs import PolygonStamped, PoseStamped, PoseWithCovarianceStamped, Twist
from hmrsim.interfaces.nav_msgs import OccupancyGrid, Odometry, Path
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.interfaces.sensor_msgs import BatteryState, LaserScan
from hmrsim.interfaces.std_msgs import String
from hmrsim.interfaces.tf2_msgs import TFMessage
from hmrsim.interfaces.vision_msgs import Detection3DArray
from hmrsim.interfaces.visualization_msgs import MarkerArray
from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.codec.types import MessageType, ServiceType, action_types, message_type, service_types
from hmrsim_zenoh.ros2.keys import DEFAULT_QOS, LATCHED_QOS, ROSOUT_QOS, SENSOR_QOS, TF_QOS, Endpoint, Kind, Node
from hmrsim_zenoh.ros2.names import (
    LIFECYCLE_SERVICE,
    LIFECYCLE_SERVICES,
    LOCALIZATION,
    MAP_SERVER,
    OTHER_NODE,
    WORLD_NODE,
    node_of,
    ros_services,
    services_of,
)

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.services import Service
    from hmrsim_zenoh.ros2.codec.types import ActionType
    from hmrsim_zenoh.ros2.keys import TypeHash
    from hmrsim_zenoh.ros2.wires import Wire

ODOM, BATTERY_STATE, DETECTIONS, AMCL_POSE = "odom", "battery_state", "detections", "amcl_pose"
CLOCK, TF = "clock", "tf"
MAP_TOPIC, TF_STATIC, MARKERS, THINGS = "map", "tf_static", "world/markers", "world/things"
PLAN, ROBOT_DESCRIPTION, FOOTPRINT, SCAN = "plan", "robot_description", "local_costmap/published_footprint", "scan"
ROSOUT, DIAGNOSTICS = "rosout", "diagnostics"
INITIAL_POSE, GOAL_POSE, CMD_VEL = "initialpose", "goal_pose", "cmd_vel"


class TopicKind(NamedTuple):
    """A topic that each robot has, or that the world has.

    Attributes:
        message: The type of its messages.
        node: The node of the robot that publishes or reads it.
        qos: The quality of service as tokens spell it.
        kind: Whether the simulator publishes or reads it.
    """

    message: type[Message]
    node: str = OTHER_NODE
    qos: str = DEFAULT_QOS
    kind: Kind = Kind.PUBLISHER


TOPICS: Final[Mapping[str, TopicKind]] = MappingProxyType(
    {
        ODOM: TopicKind(Odometry),
        BATTERY_STATE: TopicKind(BatteryState),
        DETECTIONS: TopicKind(Detection3DArray),
        AMCL_POSE: TopicKind(PoseWithCovarianceStamped, LOCALIZATION, LATCHED_QOS),
        CLOCK: TopicKind(Clock),
        TF: TopicKind(TFMessage, qos=TF_QOS),
        MAP_TOPIC: TopicKind(OccupancyGrid, qos=LATCHED_QOS),
        TF_STATIC: TopicKind(TFMessage, qos=LATCHED_QOS),
        MARKERS: TopicKind(MarkerArray, qos=LATCHED_QOS),
        THINGS: TopicKind(MarkerArray, qos=LATCHED_QOS),
        ROBOT_DESCRIPTION: TopicKind(String, qos=LATCHED_QOS),
        PLAN: TopicKind(Path),
        FOOTPRINT: TopicKind(PolygonStamped),
        SCAN: TopicKind(LaserScan, qos=SENSOR_QOS),
        ROSOUT: TopicKind(Log, qos=ROSOUT_QOS),
        DIAGNOSTICS: TopicKind(DiagnosticArray),
        INITIAL_POSE: TopicKind(PoseWithCovarianceStamped, LOCALIZATION, kind=Kind.SUBSCRIBER),
        GOAL_POSE: TopicKind(PoseStamped, kind=Kind.SUBSCRIBER),
        # A TwistStamped is read, too.
        CMD_VEL: TopicKind(Twist, kind=Kind.SUBSCRIBER),
    }
)
"""The topics by their names below the robot's; the messages are the same in all distributions."""

OF_WORLD: Final = (CLOCK, TF, MAP_TOPIC, TF_STATIC, MARKERS, THINGS, ROSOUT, DIAGNOSTICS)
FOR_VIEWERS: Final = (MAP_TOPIC, TF_STATIC, ROBOT_DESCRIPTION, PLAN, FOOTPRINT, SCAN, INITIAL_POSE, CMD_VEL)
"""The topics of a robot that are for RViz and Foxglove, declared after its actions."""

OF_ALL: Final = (ODOM, TF, AMCL_POSE)
"""The topics of each robot that are declared first."""

_KEPT: Final = 64
"""The number of parts whose types are cached."""

T = TypeVar("T", MessageType, ServiceType)


class Owned(NamedTuple):
    """An endpoint and its node."""

    node: Node
    endpoint: Endpoint


class Part(NamedTuple):
    """A group of endpoints that is declared and undeclared as a whole.

    Attributes:
        robot: The robot; `WORLD` for the world.
        actions: The ROS names of an action, each with the action.
        topics: Its topics.
        states: The ``get_state`` services, each with its node.
        nodes: Nodes to declare even without endpoints.
        served: Nodes whose services are declared, except for ``get_state``.
    """

    robot: str
    actions: tuple[tuple[str, str], ...] = ()
    topics: tuple[str, ...] = ()
    states: tuple[tuple[str, Node], ...] = ()
    nodes: tuple[Node, ...] = ()
    served: tuple[Node, ...] = ()


def topic_name(robot: str, topic: str) -> str:
    """Return the name of a robot's topic, or of the world's."""
    return f"/{topic}" if robot in ("", WORLD) else f"/{robot}/{topic}"


_OF_ROBOTS: Final = (*OF_ALL, BATTERY_STATE, DETECTIONS, *FOR_VIEWERS)
PUBLISHED: Final = (
    *(topic_name(WORLD, topic) for topic in OF_WORLD),
    *(topic_name("*", topic) for topic in _OF_ROBOTS if TOPICS[topic].kind is Kind.PUBLISHER),
)
"""The names of all topics that are published, with a wildcard for the robot."""


def _declared_services(node: Node) -> dict[str, Any]:
    """Return the services of a node, except for ``get_state``, which is declared with its topics."""
    return {name: of for name, of in services_of(node).items() if not name.endswith(f"/{LIFECYCLE_SERVICE}")}


class Endpoints:
    """All possible endpoints on one wire.

    Args:
        wire: How keys are spelled, and the distributions whose types are served.
    """

    def __init__(self, wire: Wire, actions: Mapping[str, AnyAction], services: Mapping[str, Service]) -> None:
        self._wire = wire
        self._actions = actions
        self._services = ros_services(services)
        self._roles = cache(self._find_roles)
        self.feedback_types = cache(lambda action: self._distinct(one.feedback for one in self._action_types(action)))
        self.message_type = cache(lambda topic: message_type(TOPICS[topic].message, wire.distros[0]))
        # A client's endpoints arrive in a row, and mostly belong to one part.
        self.types_of = lru_cache(_KEPT)(self._find_types_of)

    @cached_property
    def status_type(self) -> MessageType:
        """The type of status lists."""
        return message_type(GoalStatusArray, self._wire.distros[0])

    def of(self, part: Part) -> Iterator[Owned]:
        """Yield the endpoints of a part."""
        for name, action in part.actions:
            node = node_of(part.robot, action)
            for kind, role, type_, qos in self._roles(action):
                yield Owned(node, Endpoint(kind, f"{name}/_action/{role}", type_.dds_name, type_.hash, qos))
        for topic in part.topics:
            yield self.topic(part.robot, topic)
        for name, node in part.states:
            yield from self._service(node, name, LIFECYCLE_SERVICES[LIFECYCLE_SERVICE])
        for node in part.served:
            for name, service in _declared_services(node).items():
                yield from self._service(node, name, service)
        for name, of_world in self._services.items() if part.robot == WORLD else ():
            yield from self._service(WORLD_NODE, name, of_world.ros)

    def _find_types_of(self, part: Part) -> dict[str, set[TypeHash]]:
        """Return types and hashes of the endpoints of a part by their names; from any thread."""
        result: dict[str, set[TypeHash]] = {}
        for _, endpoint in self.of(part):
            result.setdefault(endpoint.name, set()).add((endpoint.type, endpoint.hash))
        return result

    def tokens(self, part: Part) -> int:
        """Return the number of tokens of a part, without those of nodes that other parts have, too."""
        endpoints = sum(len(self._roles(action)) for _, action in part.actions) + len(part.topics) + len(part.states)
        return endpoints + len(part.nodes) + sum(len(_declared_services(node)) for node in part.served)

    def topic(self, robot: str, topic: str) -> Owned:
        """Return the publisher or the subscriber of a topic, with its node."""
        type_, (_, node, qos, kind) = self.message_type(topic), TOPICS[topic]
        endpoint = Endpoint(kind, topic_name(robot, topic), type_.dds_name, type_.hash, qos)
        if robot == WORLD:
            return Owned(MAP_SERVER if topic == MAP_TOPIC else WORLD_NODE, endpoint)
        return Owned(Node(f"/{robot}", node), endpoint)

    def _service(self, node: Node, name: str, service: Any) -> Iterator[Owned]:
        for type_ in self._distinct(service_types(service, self._wire.distros)):
            yield Owned(node, Endpoint(Kind.SERVICE, name, type_.dds_name, type_.hash))

    def _distinct(self, types: Iterable[T]) -> list[T]:
        """Return the types without those that have the same key as an earlier one."""
        result: dict[str, T] = {}
        for one in types:
            result.setdefault(self._wire.key("/any", one.dds_name, one.hash), one)
        return list(result.values())

    def _action_types(self, name: str) -> tuple[ActionType, ...]:
        return action_types(self._actions[name], self._wire.distros)

    def _find_roles(self, action: str) -> list[tuple[Kind, str, MessageType | ServiceType, str]]:
        types = self._action_types(action)
        return [
            *(
                (Kind.SERVICE, role, one, DEFAULT_QOS)
                for role in ("send_goal", "cancel_goal", "get_result")
                for one in self._distinct(getattr(type_, role) for type_ in types)
            ),
            *((Kind.PUBLISHER, "feedback", one, DEFAULT_QOS) for one in self.feedback_types(action)),
            (Kind.PUBLISHER, "status", self.status_type, LATCHED_QOS),
        ]

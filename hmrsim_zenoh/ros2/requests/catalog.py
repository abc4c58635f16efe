"""The request handlers of one wire, by the names of their services."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeVar

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.codec.types import action_types, message_type, service_type
from hmrsim_zenoh.ros2.names import (
    GET_TYPE_DESCRIPTION,
    NODE_SERVICES,
    WORLD_NODE,
    node_of,
    ros_services,
    services_of,
)
from hmrsim_zenoh.ros2.publishing.endpoints import TOPICS
from hmrsim_zenoh.ros2.requests import lifecycle_services, parameter_services, type_descriptions, view_services
from hmrsim_zenoh.ros2.requests.handlers import (
    CancelGoalHandler,
    GetResultHandler,
    Layouts,
    NodeHandler,
    SendGoalHandler,
    WorldServiceHandler,
)

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.services import AnyService
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.codec.types import MessageType, ServiceType
    from hmrsim_zenoh.ros2.keys import Node
    from hmrsim_zenoh.ros2.names import Names
    from hmrsim_zenoh.ros2.requests.handlers import Handler

_T = TypeVar("_T")

_ACTION: Final = "/_action/"
MANAGE_NODES: Final = "manage_nodes"
"""The service of a lifecycle manager that changes the states of its nodes."""
_ACTION_HANDLERS: Final[Mapping[str, type[SendGoalHandler | CancelGoalHandler | GetResultHandler]]] = MappingProxyType(
    {"send_goal": SendGoalHandler, "cancel_goal": CancelGoalHandler, "get_result": GetResultHandler}
)
_RESPONSES: Final = {**parameter_services.RESPONSES, **lifecycle_services.RESPONSES, **view_services.RESPONSES}
_MAX_LOST: Final = 10_000
"""The largest number of lost names of each kind; the oldest are forgotten."""


class Catalog:
    """Finds handlers; each is built at its first request, as most services never get one.

    Args:
        distros: The distributions whose types are served.
        services: The world's services by name, of which those that ROS has are served.
        simulator: The simulation that the services of nodes read.
    """

    def __init__(
        self,
        names: Names,
        distros: tuple[str, ...],
        *,
        actions: Mapping[str, AnyAction],
        services: Mapping[str, AnyService],
        simulator: Simulator,
    ) -> None:
        self._simulator = simulator
        self._distros = distros
        self._actions = actions
        self._services = ros_services(services)
        self._layouts = cache(self._find_layouts)
        self._responses = {**_RESPONSES, GET_TYPE_DESCRIPTION: self._describe_type}
        self._names = names
        self._handlers: dict[str, Handler] = {}
        self._lost_actions: dict[str, tuple[str, str]] = {}
        self._lost_nodes: dict[str, Node] = {}
        self._lost_services: dict[str, Node] = {}

    def follow(self, names: Names) -> None:
        """Serve these names; earlier ones are kept as lost, so that their clients get a reply."""
        _remember_lost(self._lost_actions, self._names.actions, names.actions)
        _remember_lost(self._lost_nodes, self._names.all_nodes, names.all_nodes)
        _remember_lost(self._lost_services, self._names.own_services, names.own_services)
        self._names = names
        self._handlers.clear()

    def find(self, name: str) -> Handler | None:
        """Return the handler of a ROS service; None if there is none."""
        handler = self._handlers.get(name)
        if handler is None:
            handler = self._create(name)
            if handler is not None:
                self._handlers[name] = handler
        return handler

    def _create(self, name: str) -> Handler | None:
        if name in self._services:
            service = self._services[name]
            return WorldServiceHandler(
                name, self._of_service(service.ros_type, service.request, service.response), service
            )
        node_name, _, verb = name.rpartition("/")
        if verb in NODE_SERVICES:
            nodes = self._names.all_nodes
            return self._of_node(name, verb, nodes.get(node_name), self._lost_nodes.get(node_name))
        if verb in _RESPONSES or verb == MANAGE_NODES:
            return self._of_node(name, verb, self._names.own_services.get(name), self._lost_services.get(name))
        of, _, verb = name.rpartition(_ACTION)
        actions = self._names.actions
        target = actions.get(of) or self._lost_actions.get(of)
        if target is None or verb not in _ACTION_HANDLERS:
            return None
        robot, action = target
        return _ACTION_HANDLERS[verb](
            name, self._layouts(action, verb), robot, self._actions[action], lost=of not in actions
        )

    def _of_node(self, name: str, verb: str, there: Node | None, lost: Node | None) -> Handler | None:
        """Return the handler of a service of a node that is there, or was there."""
        node = there or lost
        service = services_of(node).get(name) if node else None
        if node is None or service is None:
            return None
        layouts = Layouts(tuple(service.in_distro(distro) for distro in self._distros))
        if verb in self._responses:
            response, respond = service.response, self._responses[verb]
            return NodeHandler(name, layouts, node, self._simulator, response, respond, lost=there is None)
        if verb == MANAGE_NODES:
            nodes = lifecycle_services.managed(self._names.nodes.get(node.robot, ()), node)
            actions = {one: self._actions_of(one) for one in nodes}
            return lifecycle_services.ManageNodesHandler(
                name, layouts, node, self._simulator, actions, lost=there is None
            )
        actions_of_node = self._actions_of(node)
        return lifecycle_services.ChangeStateHandler(
            name, layouts, node, self._simulator, actions_of_node, lost=there is None
        )

    def _actions_of(self, node: Node) -> tuple[str, ...]:
        """Return the actions that a node serves."""
        robot = node.robot or WORLD
        return tuple(action for action in self._names.serves.get(robot, ()) if node_of(robot, action) == node)

    def _describe_type(self, _simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Mapping[str, Any]:
        return type_descriptions.describe(self._types_of(node), request)

    def _types_of(self, node: Node) -> Iterator[MessageType | ServiceType]:
        """Yield the types of the endpoints of a node."""
        for topic in TOPICS.values():
            if topic.node == node.name or not node.robot:
                yield message_type(topic.message, self._distros[0])
        for action in self._actions_of(node):
            for type_ in action_types(self._actions[action], self._distros):
                yield from (type_.send_goal, type_.cancel_goal, type_.get_result, type_.feedback, type_.status)
        for service in services_of(node).values():
            yield from (service.in_distro(distro) for distro in self._distros)
        for of_world in self._services.values() if node == WORLD_NODE else ():
            yield from self._of_service(of_world.ros_type, of_world.request, of_world.response).types

    def _of_service(self, ros_type: str, request: type, response: type) -> Layouts:
        return Layouts(tuple(service_type(ros_type, request, response, distro) for distro in self._distros))

    def _find_layouts(self, action: str, verb: str) -> Layouts:
        types = action_types(self._actions[action], self._distros)
        return Layouts(tuple(getattr(one, verb) for one in types), self._distros)


def _remember_lost(lost: dict[str, _T], before: Mapping[str, _T], now: Mapping[str, _T]) -> None:
    """Remember the names that are no longer served."""
    lost |= {name: of for name, of in before.items() if name not in now}
    for name in list(lost)[: max(0, len(lost) - _MAX_LOST)]:
        del lost[name]

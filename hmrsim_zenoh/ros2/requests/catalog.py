"""The request handlers of one wire, by the names of their services."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.type_description_interfaces import GetTypeDescription
from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.codec.types import action_types, message_type, service_types
from hmrsim_zenoh.ros2.names import (
    GET_TYPE_DESCRIPTION,
    NODE_SERVICES,
    WORLD_NODE,
    node_of,
    ros_services,
    services_of,
)
from hmrsim_zenoh.ros2.publishing.endpoints import TOPICS
from hmrsim_zenoh.ros2.requests import lifecycle_services, parameter_services, view_services
from hmrsim_zenoh.ros2.requests.handlers import (
    CancelGoalHandler,
    GetResultHandler,
    Layouts,
    ReadingHandler,
    SendGoalHandler,
    WorldServiceHandler,
)
from hmrsim_zenoh.ros2.requests.lifecycle_services import ChangeStateHandler, ManageNodesHandler, managed

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.services import Service
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


class _Known(Generic[_T]):
    """The names that are served, and those that were served before."""

    def __init__(self) -> None:
        self._served: Mapping[str, _T] = {}
        self._lost: dict[str, _T] = {}

    def follow(self, served: Mapping[str, _T]) -> None:
        """Serve these names, and remember those that are no longer among them."""
        self._lost |= {name: of for name, of in self._served.items() if name not in served}
        for name in list(self._lost)[: max(0, len(self._lost) - _MAX_LOST)]:
            del self._lost[name]
        self._served = served

    def find(self, name: str) -> tuple[_T | None, bool]:
        """Return what a name stands for, None if that is unknown, and whether it is lost."""
        lost = name not in self._served
        return (self._lost if lost else self._served).get(name), lost


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
        services: Mapping[str, Service],
        simulator: Simulator,
    ) -> None:
        self._simulator = simulator
        self._distros = distros
        self._actions = actions
        self._services = ros_services(services)
        self._layouts = cache(self._find_layouts)
        self._responses = {**_RESPONSES, GET_TYPE_DESCRIPTION: self._describe_type}
        self._handlers: dict[str, Handler]
        self._known_actions: _Known[tuple[str, str]] = _Known()
        self._known_nodes: _Known[Node] = _Known()
        self._known_services: _Known[Node] = _Known()
        self.follow(names)

    def follow(self, names: Names) -> None:
        """Serve these names; earlier ones are kept as lost, so that their clients get a reply."""
        self._names = names
        self._known_actions.follow(names.actions)
        self._known_nodes.follow(names.all_nodes)
        self._known_services.follow(names.own_services)
        self._handlers = {}

    def find(self, name: str) -> Handler | None:
        """Return the handler of a ROS service; None if there is none; from any thread."""
        # If the names change during this call, later calls must not find its handler.
        handlers = self._handlers
        handler = handlers.get(name)
        if handler is None:
            handler = self._create(name)
            if handler is not None:
                handlers[name] = handler
        return handler

    def _create(self, name: str) -> Handler | None:
        if name in self._services:
            service = self._services[name]
            return WorldServiceHandler(name, self._layouts_of(service.ros), service)
        node_name, _, verb = name.rpartition("/")
        if verb in NODE_SERVICES:
            return self._of_node(name, verb, self._known_nodes.find(node_name))
        if verb in _RESPONSES or verb == MANAGE_NODES:
            return self._of_node(name, verb, self._known_services.find(name))
        of, _, verb = name.rpartition(_ACTION)
        target, lost = self._known_actions.find(of)
        if target is None or verb not in _ACTION_HANDLERS:
            return None
        robot, action = target
        return _ACTION_HANDLERS[verb](name, self._layouts(action, verb), robot, self._actions[action], lost=lost)

    def _of_node(self, name: str, verb: str, known: tuple[Node | None, bool]) -> Handler | None:
        """Return the handler of a service of a node that is there, or was there."""
        node, lost = known
        service = services_of(node).get(name) if node else None
        if node is None or service is None:
            return None
        about = name, self._layouts_of(service), node, self._simulator, service.Response
        if verb in self._responses:
            return ReadingHandler(*about, self._responses[verb], lost=lost)
        if verb == MANAGE_NODES:
            managed_nodes = managed(self._names.nodes.get(node.robot, ()), node)
            return ManageNodesHandler(*about, {one: self._actions_of(one) for one in managed_nodes}, lost=lost)
        return ChangeStateHandler(*about, {node: self._actions_of(node)}, lost=lost)

    def _actions_of(self, node: Node) -> tuple[str, ...]:
        robot = node.robot or WORLD
        return tuple(action for action in self._names.serves.get(robot, ()) if node_of(robot, action) == node)

    def _describe_type(self, _simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the description of the type of an endpoint, which the request selects by its hash, as rcl does.

        It has no defaults of fields, and the response has no sources: the types derive from our models.
        """
        found = next((one for one in self._types_of(node) if one.hash == request["type_hash"]), None)
        if found is None:
            return unbuilt(GetTypeDescription.Response, failure_reason="Type not currently in use by this node")
        whole = found.structure.describe()
        for described in (whole["type_description"], *whole["referenced_type_descriptions"]):
            described["fields"] = [{**field, "default_value": ""} for field in described["fields"]]
        return unbuilt(GetTypeDescription.Response, successful=True, type_description=whole)

    def _types_of(self, node: Node) -> Iterator[MessageType | ServiceType]:
        """Yield the types of the endpoints of a node."""
        for topic in TOPICS.values():
            if topic.node == node.name or not node.robot:
                yield message_type(topic.message, self._distros[0])
        for action in self._actions_of(node):
            for type_ in action_types(self._actions[action], self._distros):
                yield from (type_.send_goal, type_.cancel_goal, type_.get_result, type_.feedback, type_.status)
        of_world = [service.ros for service in self._services.values()] if node == WORLD_NODE else []
        for service in (*services_of(node).values(), *of_world):
            yield from self._layouts_of(service).types

    def _layouts_of(self, ros: Any) -> Layouts:
        return Layouts(service_types(ros, self._distros))

    def _find_layouts(self, action: str, verb: str) -> Layouts:
        types = action_types(self._actions[action], self._distros)
        return Layouts(tuple(getattr(one, verb) for one in types), self._distros)

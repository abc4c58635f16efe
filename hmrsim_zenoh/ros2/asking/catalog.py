"""All that ROS clients can ask of us on one wire, by its name."""

from __future__ import annotations

from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.lifecycle_msgs import GetState
from hmrsim_zenoh.ros2.asking.offers import Cancels, Goals, Layouts, OfWorld, Results, States
from hmrsim_zenoh.ros2.codec.types import ActionType, action_type, service_type
from hmrsim_zenoh.ros2.names import ros_services

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.actions import AnyAction
    from hmrsim.services import AnyService
    from hmrsim_zenoh.ros2.asking.offers import Offer
    from hmrsim_zenoh.ros2.names import Names

_ACTION: Final = "/_action/"
_OF_ACTIONS: Final[Mapping[str, type[Goals | Cancels | Results]]] = MappingProxyType(
    {"send_goal": Goals, "cancel_goal": Cancels, "get_result": Results}
)


class Catalog:
    """Finds offers; each is made when it is first asked for, as most are never.

    Args:
        names: What is served.
        distros: The distributions whose types are spoken.
        actions: All actions by name.
        services: The world's services by name; those that ROS has are on offer.
    """

    def __init__(
        self,
        names: Names,
        distros: tuple[str, ...],
        *,
        actions: Mapping[str, AnyAction],
        services: Mapping[str, AnyService],
    ) -> None:
        self._distros = distros
        self._actions = actions
        self._services = ros_services(services)
        self._types = cache(self._made_types)
        self._layouts = cache(self._made_layouts)
        self.follow(names)

    def follow(self, names: Names) -> None:
        """Offer what is served now."""
        self._names = names
        self._found: dict[str, Offer] = {}

    def find(self, name: str) -> Offer | None:
        """Return what is on offer under one of ROS's names; None if nothing is."""
        offer = self._found.get(name)
        if offer is None:
            offer = self._made(name)
            if offer is not None:
                self._found[name] = offer
        return offer

    def _made(self, name: str) -> Offer | None:
        if name in self._services:
            service = self._services[name]
            return OfWorld(name, self._of_service(service.ros_type, service.request, service.response), service)
        if name in self._names.lifecycle:
            return States(name, self._of_service("lifecycle_msgs/srv/GetState", GetState.Request, GetState.Response))
        of, _, verb = name.rpartition(_ACTION)
        if of not in self._names.actions or verb not in _OF_ACTIONS:
            return None
        robot, action = self._names.actions[of]
        return _OF_ACTIONS[verb](name, self._layouts(action, verb), robot, self._actions[action])

    def _of_service(self, ros_type: str, request: type, response: type) -> Layouts:
        return Layouts(tuple(service_type(ros_type, request, response, distro) for distro in self._distros))

    def _made_layouts(self, action: str, verb: str) -> Layouts:
        return Layouts(tuple(getattr(one, verb) for one in self._types(action)))

    def _made_types(self, name: str) -> tuple[ActionType, ...]:
        action = self._actions[name]
        kinds = (action.ros_type, action.goal, action.result, action.feedback)
        return tuple(action_type(*kinds, distro) for distro in self._distros)

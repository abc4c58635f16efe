"""The services that each ROS node has by itself: those of its parameters, and of its lifecycle if it has one."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.interfaces.lifecycle_msgs import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from hmrsim.interfaces.rcl_interfaces import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from hmrsim_zenoh.ros2.codec.types import service_type
from hmrsim_zenoh.ros2.names import LIFECYCLE_SERVICE, has_lifecycle

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.ros2.codec.types import ServiceType
    from hmrsim_zenoh.ros2.keys import Node


class NodeService(NamedTuple):
    """The type of a service."""

    ros_type: str
    request: type[Message]
    response: type[Message]

    def in_distro(self, distro: str) -> ServiceType:
        """Return the type in a distribution."""
        return service_type(self.ros_type, self.request, self.response, distro)


def _service(package: str, service: Any) -> NodeService:
    return NodeService(f"{package}/srv/{service.__name__}", service.Request, service.Response)


PARAMETER_SERVICES: Final = MappingProxyType(
    {
        "describe_parameters": _service("rcl_interfaces", DescribeParameters),
        "get_parameter_types": _service("rcl_interfaces", GetParameterTypes),
        "get_parameters": _service("rcl_interfaces", GetParameters),
        "list_parameters": _service("rcl_interfaces", ListParameters),
        "set_parameters": _service("rcl_interfaces", SetParameters),
        "set_parameters_atomically": _service("rcl_interfaces", SetParametersAtomically),
    }
)
"""The services of all nodes; a client of parameters waits for all of them."""

LIFECYCLE_SERVICES: Final = MappingProxyType(
    {
        LIFECYCLE_SERVICE: _service("lifecycle_msgs", GetState),
        "change_state": _service("lifecycle_msgs", ChangeState),
        "get_available_states": _service("lifecycle_msgs", GetAvailableStates),
        "get_available_transitions": _service("lifecycle_msgs", GetAvailableTransitions),
        "get_transition_graph": _service("lifecycle_msgs", GetAvailableTransitions),
    }
)
"""The services of Nav2's nodes beside."""

NODE_SERVICES: Final = MappingProxyType({**PARAMETER_SERVICES, **LIFECYCLE_SERVICES})


def services_of(node: Node) -> dict[str, NodeService]:
    """Return the services of a node, except for `LIFECYCLE_SERVICE`, which is declared with its topics."""
    of_lifecycle = LIFECYCLE_SERVICES if has_lifecycle(node) else {}
    return {name: service for name, service in (PARAMETER_SERVICES | of_lifecycle).items() if name != LIFECYCLE_SERVICE}

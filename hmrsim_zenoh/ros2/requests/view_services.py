"""The services by which viewers and Nav2's nodes read the world."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim_zenoh.ros2.publishing.views import occupancy_grid

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.keys import Node

    Response = Message | Mapping[str, Any]


def get_map(simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Response:
    """Return the map."""
    return {"map": occupancy_grid(simulator)}


RESPONSES: Final[Mapping[str, Callable[[Simulator, Node, Mapping[str, Any]], Response]]] = MappingProxyType(
    {"map": get_map}
)
"""The function that responds to each service."""

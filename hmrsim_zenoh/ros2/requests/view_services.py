"""The services of Nav2's nodes that read the world, or would change what it does not have."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.nav2_msgs import ClearEntireCostmap
from hmrsim_zenoh.ros2.publishing.views import costmap, occupancy_grid

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.keys import Node

    Response = Message | Mapping[str, Any]


def get_map(simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Response:
    """Return the map."""
    return {"map": occupancy_grid(simulator)}


def get_costmap(simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Response:
    """Return the walls as a costmap."""
    return {"map": costmap(simulator)}


def clear_costmap(_simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Response:
    """Return that the costmap is clear: it has nothing but walls."""
    return unbuilt(ClearEntireCostmap.Response, success=True)


def is_path_valid(simulator: Simulator, _node: Node, request: Mapping[str, Any]) -> Response:
    """Return which poses of a path are in an obstacle, or behind one from the pose before; no path is invalid."""
    at = [(one["pose"]["position"]["x"], one["pose"]["position"]["y"]) for one in request["path"]["poses"]]
    free = [not simulator.graph.reach(here, there)[1] for here, there in zip([*at[:1], *at], at, strict=False)]
    invalid = [number for number, clear in enumerate(free) if not clear]
    return {"success": True, "is_valid": bool(at) and not invalid, "invalid_pose_indices": invalid}


def fails(_simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Response:
    """Return that the request failed: route graph and docks are those of the world."""
    return {"success": False}


RESPONSES: Final[Mapping[str, Callable[[Simulator, Node, Mapping[str, Any]], Response]]] = MappingProxyType(
    {
        "map": get_map,
        "get_costmap": get_costmap,
        **{
            f"clear_{kind}_{name}": clear_costmap
            for name in ("global_costmap", "local_costmap")
            for kind in ("entirely", "except", "around")
        },
        "is_path_valid": is_path_valid,
        "set_route_graph": fails,
        "reload_database": fails,
    }
)
"""The function that responds to each service."""

"""The missions of the hospital's fleet: who fetches what, and where to.

::

    bt-controller run bt_controller.hospital:mission --robot wall_e eve burn_e m_o
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from py_trees.composites import Selector, Sequence

from bt_controller.action_leaf import ActionLeaf
from bt_controller.behaviours.nav_to_pose import NavToPoseActionClient, pose_goal
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import Wait

if TYPE_CHECKING:
    from collections.abc import Mapping

    from py_trees.behaviour import Behaviour

PLACES: Final[Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "pharmacy": (6.0, 18.0),
        "lab": (15.0, 18.0),
        "kitchen": (6.0, 5.0),
        "laundry": (15.0, 5.0),
        "ward_a": (22.6, 17.5),
        "ward_b": (34.6, 17.5),
        "ward_c": (30.6, 6.5),
        "nurse_station": (27.0, 12.8),
    }
)
"""As in ``maps/hospital.yaml``, in metres: a controller knows the house it works in."""


def mission(robot: str) -> Behaviour:
    """Return the tree of one robot of the fleet; one that has no errand of its own makes a round."""
    match robot:
        case "wall_e":
            steps = [_deliver("medicine", "pharmacy", "ward_a"), _go("nurse_station")]
        case "eve":
            steps = [_deliver("blood_samples", "ward_a", "lab"), _go("nurse_station")]
        case "burn_e":
            steps = [_deliver("linen", "laundry", "ward_c")]
        case _:
            steps = [_go("nurse_station"), _clean()]
    return Sequence(f"Mission of {robot}", memory=True, children=steps)


def _deliver(item: str, source: str, target: str) -> Behaviour:
    """Return the errand of bringing an item from one place to another."""
    fetch = Sequence(f"Fetch {item}", memory=True, children=[_go(source), _pick_up(item)])
    bring = Sequence(f"Bring {item}", memory=True, children=[_go(target), _place(item)])
    return Sequence(f"Deliver {item}", memory=True, children=[fetch, bring])


def _go(place: str) -> Behaviour:
    return NavToPoseActionClient(f"Go to {place}", pose_goal(*PLACES[place]))


def _pick_up(item: str) -> Behaviour:
    """Return a pickup that is tried once more: somebody else may have been in the way."""
    goal = Pickup.Goal(target_name=item)
    first, second = (_leaf(name, "pickup", goal) for name in (f"Pick up {item}", f"Pick up {item} again"))
    return Selector(f"Get {item}", memory=True, children=[first, second])


def _place(item: str) -> Behaviour:
    return _leaf(f"Place {item}", "place", Place.Goal(attached_object_name=item))


def _clean() -> Behaviour:
    return _leaf("Clean", "wait", Wait.Goal(time=Duration(sec=15)))


def _leaf(name: str, action: str, goal: Any) -> Behaviour:
    leaf: ActionLeaf[Any, Any, Any] = ActionLeaf(name, action, goal)
    return leaf

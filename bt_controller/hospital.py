"""The missions of the hospital's fleet: who fetches what, and where to.

::

    bt-controller run bt_controller.hospital:mission --robot wall_e eve burn_e m_o nan_e d_fib auto vaq_m
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from py_trees.composites import Selector, Sequence

from bt_controller.action_leaf import ActionLeaf
from bt_controller.behaviours.nav_to_pose import NavToPoseActionClient, pose_goal
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import DockRobot, Wait

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
        "ward_a_window": (27.4, 17.5),
        "ward_b": (34.6, 17.5),
        "ward_b_window": (39.4, 17.5),
        "ward_c": (30.6, 6.5),
        "ward_d": (38.6, 6.5),
        "nurse_station": (27.0, 12.8),
        "lab_floor": (17.0, 16.0),
        "corridor_east": (34.0, 11.0),
    }
)
"""As in ``maps/hospital.yaml``, in metres: a controller knows the house it works in."""


def mission(robot: str) -> Behaviour:
    """Return the tree of one robot of the fleet; one that has no errand of its own makes a round."""
    match robot:
        case "wall_e":
            steps = [_deliver("medicine", "pharmacy", "ward_a"), _go("nurse_station")]
        case "eve":
            steps = [_deliver("blood_samples", "ward_a", "lab"), _charge("charger_2")]
        case "burn_e":
            steps = [_deliver("linen", "laundry", "ward_c")]
        case "nan_e":
            steps = [_deliver("meal", "kitchen", "ward_d")]
        case "d_fib":
            steps = [_deliver("defibrillator", "nurse_station", "ward_b"), _stay("Treat the patient", 20)]
        case "auto":
            steps = [_visit("ward_a_window"), _visit("ward_b_window")]
        case "m_o":
            steps = [_go("corridor_east"), _stay("Mop the corridor", 20), _charge("charger_4")]
        case "vaq_m":
            steps = [_go("lab_floor"), _stay("Disinfect the lab", 30), _charge("charger_8")]
        case _:
            steps = [_go("nurse_station"), _stay("Clean", 15)]
    return Sequence(f"Mission of {robot}", memory=True, children=steps)


def _deliver(item: str, source: str, target: str) -> Behaviour:
    """Return the errand of bringing an item from one place to another."""
    fetch = Sequence(f"Fetch {item}", memory=True, children=[_go(source), _pick_up(item)])
    bring = Sequence(f"Bring {item}", memory=True, children=[_go(target), _place(item)])
    return Sequence(f"Deliver {item}", memory=True, children=[fetch, bring])


def _visit(place: str) -> Behaviour:
    """Return the errand of letting a doctor far away talk with a patient."""
    return Sequence(f"Visit {place}", memory=True, children=[_go(place), _stay(f"Talk at {place}", 10)])


def _go(place: str) -> Behaviour:
    return NavToPoseActionClient(f"Go to {place}", pose_goal(*PLACES[place]))


def _charge(dock: str) -> Behaviour:
    return _leaf(f"Charge at {dock}", "dock_robot", DockRobot.Goal(dock_id=dock))


def _pick_up(item: str) -> Behaviour:
    """Return a pickup that is tried once more: somebody else may have been in the way."""
    goal = Pickup.Goal(target_name=item)
    first, second = (_leaf(name, "pickup", goal) for name in (f"Pick up {item}", f"Pick up {item} again"))
    return Selector(f"Get {item}", memory=True, children=[first, second])


def _place(item: str) -> Behaviour:
    return _leaf(f"Place {item}", "place", Place.Goal(attached_object_name=item))


def _stay(name: str, seconds: int) -> Behaviour:
    """Return a piece of work that is done where the robot stands."""
    return _leaf(name, "wait", Wait.Goal(time=Duration(sec=seconds)))


def _leaf(name: str, action: str, goal: Any) -> Behaviour:
    leaf: ActionLeaf[Any, Any, Any] = ActionLeaf(name, action, goal)
    return leaf

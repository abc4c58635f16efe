"""The missions of the hospital's fleet: which robot brings which item, and where to.

::

    bt-controller run bt_controller.examples.hospital:mission --robot wall_e eve burn_e m_o nan_e d_fib auto vaq_m
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from py_trees.composites import Selector, Sequence

from bt_controller.behaviours.robot_actions import Dock, GoTo, Pickup, Place, Wait

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


def mission(robot: str) -> Behaviour:
    """Return the tree of one robot of the fleet; a robot without an errand patrols."""
    match robot:
        case "wall_e":
            steps = [_deliver("medicine", "pharmacy", "ward_a"), GoTo("nurse_station")]
        case "eve":
            steps = [_deliver("blood_samples", "ward_a", "lab"), Dock("charger_2")]
        case "burn_e":
            steps = [_deliver("linen", "laundry", "ward_c")]
        case "nan_e":
            steps = [_deliver("meal", "kitchen", "ward_d")]
        case "d_fib":
            steps = [_deliver("defibrillator", "nurse_station", "ward_b"), Wait(20, name="Treat the patient")]
        case "auto":
            steps = [_visit("ward_a_window"), _visit("ward_b_window")]
        case "m_o":
            steps = [GoTo("corridor_east"), Wait(20, name="Mop the corridor"), Dock("charger_4")]
        case "vaq_m":
            steps = [GoTo("lab_floor"), Wait(30, name="Disinfect the lab"), Dock("charger_8")]
        case _:
            steps = [GoTo("nurse_station"), Wait(15, name="Clean")]
    return Sequence(f"Mission of {robot}", memory=True, children=steps)


def _deliver(item: str, source: str, target: str) -> Behaviour:
    """Return the errand of bringing an item from one place to another."""
    fetch = Sequence(f"Fetch {item}", memory=True, children=[GoTo(source), _pick_up(item)])
    bring = Sequence(f"Bring {item}", memory=True, children=[GoTo(target), Place(item)])
    return Sequence(f"Deliver {item}", memory=True, children=[fetch, bring])


def _visit(place: str) -> Behaviour:
    """Return the errand of letting a doctor far away talk with a patient."""
    return Sequence(f"Visit {place}", memory=True, children=[GoTo(place), Wait(10, name=f"Talk at {place}")])


def _pick_up(item: str) -> Behaviour:
    """Return a pickup with one retry: another robot may have been in the way."""
    again = Pickup(item, name=f"Pick up {item} again")
    return Selector(f"Get {item}", memory=True, children=[Pickup(item), again])

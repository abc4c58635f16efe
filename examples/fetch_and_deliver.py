"""Fetch and deliver as a behavior tree: four steps, one after the other.

Start ``hmrsim run scenario1 --clock lockstep`` first, then run
``bt-controller run examples.fetch_and_deliver:deliver --robot wall_e``.
"""

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from bt_controller import GoTo, Pickup, Place


def deliver() -> Behaviour:
    """Return the tree that brings the medicine to the patient."""
    steps = [GoTo("medicine_room"), Pickup("medicine"), GoTo("patient_room"), Place("medicine")]
    return Sequence("Deliver the medicine", memory=True, children=steps)

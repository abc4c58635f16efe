"""A long round with a small battery: the guard interrupts it, has the robot charged, and lets it go on.

Start ``hmrsim run examples/battery_guard.yaml --clock lockstep`` first, then run
``bt-controller run examples.battery_guard:round_trip --robot wall_e``.
"""

from py_trees.behaviour import Behaviour
from py_trees.composites import Sequence

from bt_controller import BatteryGuard, Dock, GoTo


def round_trip() -> Behaviour:
    """Return the tree that visits all wards, however often the battery has to be charged in between."""
    wards = Sequence("Visit the wards", memory=True, children=[GoTo("ward_a"), GoTo("ward_b"), GoTo("office")])
    return BatteryGuard("Guard", mission=wards, charge=Dock("charger"), below=0.3, until=0.9)

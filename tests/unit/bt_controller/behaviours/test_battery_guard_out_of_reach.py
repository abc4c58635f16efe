"""A guarded mission of a robot whose messages are lost while it is to charge."""

from __future__ import annotations

from py_trees.composites import Sequence

from bt_controller.behaviours.battery_guard import BatteryGuard
from bt_controller.behaviours.robot_actions import Dock, GoTo

WORLD = {
    "waypoints": {"home": [0, 0], "ward": [20, 0]},
    "lanes": [["home", "ward"]],
    "docks": {"charger": {"at": [0, 1], "type": "charger", "power": 50}},
    "robots": {"wall_e": {"at": "home", "components": {"battery": {"capacity": 500}}}},
    "faults": [
        {"type": "battery_drop", "robot": "wall_e", "share": 0.2, "at": 5},
        {"type": "messages_lost", "robot": "wall_e", "when": {"event": "stopped"}, "duration": 20},
    ],
}


def guarded():
    """Return a drive that is interrupted to charge."""
    errand = Sequence("Errand", memory=True, children=[GoTo("ward")])
    return BatteryGuard("Guard", errand, Dock("charger"), below=0.3, until=0.9)


def test_a_robot_that_is_out_of_reach_charges_when_it_is_back(simulation):
    """Its goal was canceled at 5 s, nothing is known of it until 25 s, and it is sent to its charger then."""
    run = simulation(WORLD, tree=guarded)
    run.to_the_end()
    dock = run.goals(action="dock_robot")

    run.check_succeeded()
    assert [25.0] == [goal.accepted for goal in dock]

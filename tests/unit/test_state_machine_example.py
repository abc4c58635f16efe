"""The state machine of the examples, in worlds in which something goes wrong."""

from __future__ import annotations

from examples.state_machine import run
from hmrsim.testing import simulation


def states(changes):
    """Return the states of the machine in a changed world."""
    with simulation("scenario1", changes=changes) as made:
        return [state for _now, state in run(made.open_client("state_machine"), "wall_e", "to_the_medicine")]


def test_a_goal_that_is_rejected_is_a_failure_and_no_crash():
    """The robot has broken down when the machine picks the medicine up."""
    arrived = {"goal": "succeeded", "robot": "wall_e", "action": "navigate_to_pose"}

    found = states({"faults": [{"type": "breakdown", "robot": "wall_e", "when": arrived, "duration": 5.0}]})

    assert found == ["to_the_medicine", "picking_up", "picking_up_again", "failed"]


def test_a_pickup_that_can_t_succeed_is_given_up():
    """The medicine is out of reach, also when the robot tries again."""
    found = states({"items.medicine.at": [100, 180]})

    assert found == ["to_the_medicine", "picking_up", "picking_up_again", "failed"]

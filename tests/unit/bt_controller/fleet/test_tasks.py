"""The tasks of a fleet, and the times at which they appear."""

from __future__ import annotations

import pytest

from bt_controller.fleet.allocation import Task, arrivals

TASKS = tuple(Task(item, "a", "b") for item in ("tea", "milk", "rice"))


def test_the_same_seed_draws_the_same():
    """Another one draws something else."""
    first, again, other = (arrivals(TASKS, seed=seed, mean_gap=60.0) for seed in (1, 1, 2))

    assert first == again
    assert first != other


def test_every_task_turns_up_once_and_in_order_of_time():
    """This holds for every seed."""
    found = arrivals(TASKS, seed=5, mean_gap=60.0)

    assert ["milk", "rice", "tea"] == sorted(arrival.task.item for arrival in found)
    assert sorted(arrival.after for arrival in found) == [arrival.after for arrival in found]


def test_the_gaps_are_as_long_as_is_wanted_on_average():
    """A thousand of them are."""
    tasks = [Task(str(number), "a", "b") for number in range(1000)]

    assert arrivals(tasks, seed=1, mean_gap=60.0)[-1].after == pytest.approx(60_000, rel=0.1)


@pytest.mark.parametrize(
    ("types", "robot_type", "actions", "suits"),
    [
        ((), "nurse", ("navigate_to_pose", "pickup", "place", "wait"), True),
        ((), "nurse", ("navigate_to_pose", "pickup"), False),
        (("nurse", "porter"), "porter", ("navigate_to_pose", "pickup", "place"), True),
        (("nurse", "porter"), "cleaner", ("navigate_to_pose", "pickup", "place"), False),
    ],
)
def test_a_task_suits_robots_of_its_types_with_its_actions(types, robot_type, actions, suits):
    """Both are required; a task without types suits all types."""
    assert suits is Task("tea", "a", "b", types).suits(robot_type, actions)

"""The tasks of a fleet, their queue, and their allocation."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_controller.fleet.allocation import Assignment, PendingTask, Robot, Task, arrivals, nearest

MIN_CHARGE = 0.2
CAN = ("navigate_to_pose", "pickup", "place")
NAMES = ("ann", "bob", "cyd", "dan", "eve")
AT = st.tuples(st.integers(-9, 9).map(float), st.integers(-9, 9).map(float))

ROBOTS = st.lists(
    st.builds(
        Robot,
        name=st.sampled_from(NAMES),
        type=st.sampled_from(("nurse", "porter", "cleaner")),
        actions=st.sampled_from((CAN, CAN[:1])),
        at=AT,
        charge=st.sampled_from((0.0, 0.19, 0.2, 1.0)),
        idle=st.booleans(),
    ),
    max_size=5,
    unique_by=lambda robot: robot.name,
)
WAITING = st.lists(
    st.builds(
        PendingTask,
        task=st.builds(
            Task,
            item=st.integers(1, 99).map(str),
            source=st.just("a"),
            target=st.just("b"),
            types=st.sampled_from(((), ("nurse",), ("nurse", "porter"))),
        ),
        at=AT,
        failed=st.frozensets(st.sampled_from(NAMES)),
    ),
    max_size=6,
    unique_by=lambda waiting: waiting.task.item,
)


@given(WAITING, ROBOTS)
def test_no_task_and_no_robot_is_given_twice(waiting, robots):
    found = nearest(waiting, robots, least=MIN_CHARGE)

    assert len(found) == len({each.task.item for each in found})
    assert len(found) == len({each.robot for each in found})


@given(WAITING, ROBOTS)
def test_no_robot_gets_what_it_can_not_do(waiting, robots):
    by_name = {robot.name: robot for robot in robots}
    chosen = [(each.task, by_name[each.robot]) for each in nearest(waiting, robots, least=MIN_CHARGE)]

    assert [] == [pair for pair in chosen if not pair[0].suits(pair[1].type, pair[1].actions)]
    assert [] == [robot for _, robot in chosen if not robot.idle or robot.charge < MIN_CHARGE]


@given(WAITING, ROBOTS)
def test_no_task_waits_while_a_free_robot_could_do_it(waiting, robots):
    found = nearest(waiting, robots, least=MIN_CHARGE)
    left = [each for each in waiting if each.task not in {one.task for one in found}]
    free = [
        robot
        for robot in robots
        if robot.idle and robot.charge >= MIN_CHARGE and robot.name not in {x.robot for x in found}
    ]

    assert [] == [(each, robot) for each in left for robot in free if robot.suits(each.task)]


@given(WAITING, ROBOTS)
def test_the_order_in_which_robots_are_listed_does_not_matter(waiting, robots):
    assert nearest(waiting, robots, least=MIN_CHARGE) == nearest(waiting, robots[::-1], least=MIN_CHARGE)


def robot(name, x):
    """Return a robot that can do everything."""
    return Robot(name, "nurse", CAN, (x, 0.0))


TEA = PendingTask(Task("tea", "a", "b"), (0.0, 0.0))
MILK = PendingTask(Task("milk", "a", "b"), (5.0, 0.0))


def test_the_nearest_gets_it():
    found = nearest([TEA, MILK], [robot("ann", 4.0), robot("bob", 3.0)], least=MIN_CHARGE)

    assert [Assignment(TEA.task, "bob", 3.0), Assignment(MILK.task, "ann", 1.0)] == found


def test_a_robot_that_has_failed_comes_last():
    tea = PendingTask(TEA.task, TEA.at, failed=frozenset({"bob"}))

    assert ["ann"] == [each.robot for each in nearest([tea], [robot("bob", 1.0), robot("ann", 9.0)], least=MIN_CHARGE)]
    assert ["bob"] == [each.robot for each in nearest([tea], [robot("bob", 1.0)], least=MIN_CHARGE)]


TASKS = tuple(Task(item, "a", "b") for item in ("tea", "milk", "rice"))


def test_the_same_seed_draws_the_same():
    first, again, other = (arrivals(TASKS, seed=seed, mean_gap=60.0) for seed in (1, 1, 2))

    assert first == again
    assert first != other


def test_every_task_turns_up_once_and_in_order_of_time():
    found = arrivals(TASKS, seed=5, mean_gap=60.0)

    assert ["milk", "rice", "tea"] == sorted(arrival.task.item for arrival in found)
    assert sorted(arrival.after for arrival in found) == [arrival.after for arrival in found]


def test_the_gaps_are_as_long_as_is_wanted_on_average():
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
    assert suits is Task("tea", "a", "b", types).suits(robot_type, actions)

"""The books of a fleet."""

from __future__ import annotations

import pytest

from bt_controller.fleet.allocation import PendingTask, Robot, Task, TaskQueue

CAN = ("navigate_to_pose", "pickup", "place")


def waiting(item, since=0.0, types=()):
    return PendingTask(Task(item, "a", "b", types), (0.0, 0.0), since=since)


def robot(name, robot_type="nurse"):
    return Robot(name, robot_type, CAN, (1.0, 0.0))


@pytest.fixture
def task_queue():
    """Return a task queue at which ann has the tea, and the milk waits."""
    task_queue = TaskQueue(waiting=[waiting("tea", 1.0), waiting("milk", 2.0)])
    task_queue.hand_out([robot("ann")])
    return task_queue


def items(tasks):
    return [each.task.item for each in tasks]


def test_a_robot_with_a_task_gets_no_other(task_queue):
    assert ([], ["milk"]) == (task_queue.hand_out([robot("ann")]), items(task_queue.waiting))


def test_what_is_done_is_in_the_books(task_queue):
    task_queue.finish("ann")

    assert ["milk"] == items(task_queue.hand_out([robot("ann")]))
    assert ["tea"] == [task.item for task in task_queue.done]


def test_another_robot_takes_over_from_one_that_failed(task_queue):
    task_queue.fail("ann")

    assert ["tea", "milk"] == items(task_queue.waiting)
    assert [("tea", "bob")] == [(each.task.item, each.robot) for each in task_queue.hand_out([robot("bob")])]


def test_what_a_robot_holds_stays_with_it(task_queue):
    task_queue.given["ann"].holds = True
    task_queue.fail("ann")

    assert (["milk"], "tea") == (items(task_queue.waiting), task_queue.given["ann"].task.item)


def test_a_robot_that_holds_a_given_up_item_gets_nothing(task_queue):
    """The gripper of this robot is full."""
    task_queue.give_up("ann", "ann holds it")

    assert [] == task_queue.hand_out([robot("ann")])
    assert {"tea": "ann holds it"} == task_queue.lost


def test_a_task_that_no_robot_can_do_is_given_up(task_queue):
    task_queue.waiting.append(waiting("rice", 3.0, types=("cook",)))

    assert ["rice"] == task_queue.give_up_waiting([robot("ann")], before=0.0)
    assert (["milk"], {"rice": "no robot can do it"}) == (items(task_queue.waiting), task_queue.lost)


def test_what_has_waited_for_too_long_is_given_up(task_queue):
    task_queue.fail("ann")

    assert ["tea"] == task_queue.give_up_waiting([robot("ann")], before=1.0)
    assert {"tea": "it waited too long; ann failed"} == task_queue.lost

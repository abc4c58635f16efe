"""The books of a fleet."""

from __future__ import annotations

import pytest

from bt_controller.fleet.allocation import Robot, Waiting
from bt_controller.fleet.task_queue import Desk
from bt_controller.fleet.tasks import Task

CAN = ("navigate_to_pose", "pickup", "place")


def waiting(item, since=0.0, types=()):
    """Return a task that waits."""
    return Waiting(Task(item, "a", "b", types), (0.0, 0.0), since=since)


def robot(name, robot_type="nurse"):
    """Return an idle robot."""
    return Robot(name, robot_type, CAN, (1.0, 0.0))


@pytest.fixture
def desk():
    """Return a desk at which ann has the tea, and the milk waits."""
    desk = Desk(waiting=[waiting("tea", 1.0), waiting("milk", 2.0)])
    desk.hand_out([robot("ann")])
    return desk


def items(tasks):
    """Return the items of some tasks."""
    return [each.task.item for each in tasks]


def test_who_has_a_task_gets_no_other(desk):
    """However idle it looks."""
    assert ([], ["milk"]) == (desk.hand_out([robot("ann")]), items(desk.waiting))


def test_what_is_done_is_in_the_books(desk):
    """And the robot gets the next."""
    desk.finish("ann")

    assert ["milk"] == items(desk.hand_out([robot("ann")]))
    assert ["tea"] == [task.item for task in desk.done]


def test_another_takes_over_from_who_failed(desk):
    """Before what turned up later."""
    desk.fail("ann")

    assert ["tea", "milk"] == items(desk.waiting)
    assert [("tea", "bob")] == [(each.task.item, each.robot) for each in desk.hand_out([robot("bob")])]


def test_what_a_robot_holds_stays_with_it(desk):
    """Nobody else can fetch it."""
    desk.given["ann"].holds = True
    desk.fail("ann")

    assert (["milk"], "tea") == (items(desk.waiting), desk.given["ann"].task.item)


def test_who_holds_what_was_given_up_gets_nothing(desk):
    """Its claw is full."""
    desk.give_up("ann", "ann holds it")

    assert [] == desk.hand_out([robot("ann")])
    assert {"tea": "ann holds it"} == desk.lost


def test_what_nobody_can_do_is_given_up(desk):
    """At once; the rest waits on."""
    desk.waiting.append(waiting("rice", 3.0, types=("cook",)))

    assert ["rice"] == desk.give_up_waiting([robot("ann")], before=0.0)
    assert (["milk"], {"rice": "nobody can do it"}) == (items(desk.waiting), desk.lost)


def test_what_has_waited_for_too_long_is_given_up(desk):
    """The books say who failed at it."""
    desk.fail("ann")

    assert ["tea"] == desk.give_up_waiting([robot("ann")], before=1.0)
    assert {"tea": "it has waited for too long; ann failed"} == desk.lost

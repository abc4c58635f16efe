"""The reaction of a fleet to a robot that gets stuck, in a real simulator in lockstep."""

from __future__ import annotations

from py_trees.common import ParallelPolicy
from py_trees.composites import Parallel

from bt_controller.fleet.allocation import Task
from bt_controller.fleet.fleet_manager import FleetManager
from bt_controller.fleet.workers import Worker
from bt_controller.loading.trees import Plan
from bt_controller.running.clocks import Mailbox, clock_for
from bt_controller.running.mission import missions_for
from bt_controller.running.runner import Runner
from hmrsim_zenoh.client.client import Client
from tests.served_world import served_world

WORLD = {
    "waypoints": {"west": [0, 0], "shelf": [5, 0], "table": [15, 0], "east": [20, 0]},
    "lanes": [["west", "shelf"], ["shelf", "table"], ["table", "east"]],
    "docks": {"home": {"at": "west"}, "garage": {"at": "east"}},
    "items": {"tea": {"at": [5, 0.5]}, "milk": {"at": [5, -0.5]}},
    "robots": {"ann": {"type": "fetcher", "at": "home"}, "bob": {"type": "fetcher", "at": "garage"}},
}
TEA = Task("tea", "shelf", "table")
"""Ann is nearer: she is at the shelf at about 5 s, and at the table 10 s later."""


class Day:
    """A finished run of the crew.

    Attributes:
        status: How the tree ended.
        news: The messages of the fleet_manager, by time.
        fleet_manager: The fleet_manager.
    """

    def __init__(self, tasks, faults, robots=("ann", "bob"), **settings):
        self.news = []
        world, mailbox = {**WORLD, "faults": faults}, Mailbox()
        with served_world(world, clock="lockstep") as options, Client(options, name="fleet") as client:
            plan = Plan("test", lambda names: self._tree(names, tasks, settings), False, False, takes_robots=True)
            clock = clock_for(client, mailbox, feedback=False, grace=1.0)
            missions = missions_for(list(robots), plan)
            outcome = Runner(client, missions, clock, mailbox, show=self._note).run()
        self.status = outcome.statuses["fleet"]

    def _tree(self, robots, tasks, settings):
        self.fleet_manager = FleetManager(robots, tasks, seed=1, mean_gap=0.1, **settings)
        workers = [Worker(robot, self.fleet_manager) for robot in robots]
        policy = ParallelPolicy.SuccessOnAll(synchronise=True)
        return Parallel("Fleet", policy=policy, children=[self.fleet_manager, *workers])

    def _note(self, _mission, now):
        message = self.fleet_manager.feedback_message
        if not self.news or self.news[-1][1] != message:
            self.news.append((now, message))

    def when(self, text):
        return next(time for time, message in self.news if text in message)


def breakdown(at, duration=None):
    """Return the fault that breaks ann down."""
    lasts = {} if duration is None else {"duration": duration}
    return [{"type": "breakdown", "name": "flat", "robot": "ann", "at": at, **lasts}]


def test_another_robot_takes_over_at_the_instant_of_a_breakdown():
    day = Day([TEA], breakdown(3.0))

    assert 3.0 == day.when("ann can't fetch tea: aborted: ann has broken down at ")
    assert 3.0 == day.when("bob gets tea")
    assert day.when("bob has brought tea to table") < 40.0


def test_a_repaired_robot_delivers_the_item_in_its_gripper():
    day = Day([TEA], breakdown(10.0, duration=50.0))

    assert 10.0 == day.when("ann can't bring tea")
    assert 60.0 < day.when("ann has brought tea to table") < 100.0


def test_a_task_is_given_up_when_its_item_is_held_too_long():
    day = Day([TEA], breakdown(10.0), patience=200.0)

    assert {"tea": "ann holds it and is out of order"} == day.fleet_manager.task_queue.lost
    assert 200.0 < day.when("tea is given up") < 201.0


def test_a_free_robot_gets_the_longest_waiting_task_at_once():
    day = Day([TEA, Task("milk", "shelf", "table")], [], robots=("ann",))
    first, second = day.fleet_manager.task_queue.done

    assert day.when(f"ann has brought {first.item} to table") == day.when(f"ann gets {second.item}")

"""The counts of a tree that is ticked."""

from __future__ import annotations

import pytest
from py_trees.behaviours import Failure, Running, StatusQueue, Success
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter, Retry

from bt_controller.behaviours.robot_actions import Wait
from bt_controller.core.node import Decoration
from bt_controller.core.subtrees import suspend
from bt_controller.coverage import TreeCoverage
from bt_controller.loading.trees import Plan, load
from bt_controller.running.mission import Mission
from bt_controller.running.runner import run_tree
from hmrsim.protocol.goal import GoalStatus
from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation
from hmrsim_zenoh.errors import RequestTimeout, SimulatorGone

S, F, R = Status.SUCCESS, Status.FAILURE, Status.RUNNING


class OnlyWhile(Decoration):
    """Is skipped as soon as a condition does not hold."""

    def __init__(self, holds, child):
        super().__init__("OnlyWhile", child)
        self._holds = holds

    def advance(self):
        """Tick the child and return its status."""
        if not self._holds():
            return Status.INVALID
        return (yield from self.tick_child())


class Stage:
    """A tree that is ticked and watched.

    Attributes:
        goals: The tickets of its goals.
    """

    def __init__(self, client, function, robot="wall_e"):
        self.coverage = TreeCoverage()
        plan = Plan("test", function, takes_robot=False, confirmed=False)
        self.mission = Mission(robot, plan, coverage=self.coverage)
        for node in self.mission.root.iterate():
            node.setup(client=client, robot=robot)
        self.goals = client.goals

    def tick(self, times=1):
        for _ in range(times):
            self.mission.tick(0.0)

    def counts(self, path):
        """Return what was counted of a node."""
        counts = next(node.counts for node in self.coverage.nodes("test") if node.path == path)
        return {outcome: count for outcome, count in counts.items() if count}


@pytest.fixture
def stage(client):
    """Return what watches a tree."""
    return lambda function: Stage(client, function)


def queue(name, *statuses):
    """Return a leaf that returns these statuses, one a tick."""
    return StatusQueue(name, queue=list(statuses), eventually=statuses[-1])


def sequence(name, *children):
    return Sequence(name, memory=True, children=children)


def selector(name, *children, memory=True):
    return Selector(name, memory=memory, children=children)


TREES = {
    "each tick of a node counts": (lambda: queue("A", R, R, S), 3, "A", {"RUNNING": 2, "SUCCESS": 1}),
    "a node that was not ticked is known": (lambda: sequence("Root", Failure("A"), Success("B")), 1, "Root/B", {}),
    "a node that is halted while it runs was canceled": (
        lambda: selector("Root", queue("A", F, R), Running("B"), memory=False),
        2,
        "Root/B",
        {"RUNNING": 1, "CANCELED": 1},
    ),
    "a failure after which another child succeeds is recovered": (
        lambda: selector("Root", Failure("A"), Success("B")),
        1,
        "Root/A",
        {"FAILURE": 1, "RECOVERED": 1},
    ),
    "a failure further below is recovered with its sequence": (
        lambda: selector("Root", sequence("Steps", Success("A"), Failure("B")), Success("C")),
        1,
        "Root/Steps/B",
        {"FAILURE": 1, "RECOVERED": 1},
    ),
    "a failure after which all fails is not recovered": (
        lambda: selector("Root", Failure("A"), Failure("B")),
        1,
        "Root/A",
        {"FAILURE": 1},
    ),
    "a step that succeeds when it is tried again is recovered": (
        lambda: Retry("Root", sequence("Steps", Success("A"), queue("B", F, S)), 2),
        2,
        "Root/Steps/B",
        {"FAILURE": 1, "SUCCESS": 1, "RECOVERED": 1},
    ),
    "a failure that an inverter wants is not recovered": (
        lambda: selector("Root", Inverter("Not", Failure("A")), Success("B")),
        1,
        "Root/Not/A",
        {"FAILURE": 1},
    ),
    "a halt forgets failures": (
        lambda: selector(
            "Root", queue("Better", F, R, F), selector("Tried", queue("A", F, S), Running("B")), memory=False
        ),
        3,
        "Root/Tried/A",
        {"FAILURE": 1, "SUCCESS": 1},
    ),
}


@pytest.mark.parametrize(("tree", "ticks", "path", "counts"), TREES.values(), ids=TREES)
def test_a_node_has_counts(stage, tree, ticks, path, counts):
    seen = stage(tree)
    seen.tick(ticks)

    assert counts == seen.counts(path)


def test_what_stops_with_the_run_was_not_canceled(stage):
    """The tree did not halt it."""
    seen = stage(lambda: Running("A"))
    seen.tick()
    seen.mission.interrupt()

    assert {"RUNNING": 1} == seen.counts("A")


PREEMPTED = "preempted by goal 2"


@pytest.mark.parametrize(
    ("end", "counts"),
    [
        (lambda goal: goal.abort(701, "too long"), {"FAILURE": 1, "ABORTED/701": 1}),
        (
            lambda goal: goal.end(GoalStatus.ABORTED, goal.action.failure(700, PREEMPTED), "preempted"),
            {"FAILURE": 1, "PREEMPTED": 1},
        ),
        (lambda goal: goal.reject("bad", "not now"), {"FAILURE": 1, "REJECTED": 1}),
        (lambda goal: goal.fail(RequestTimeout("no answer")), {"FAILURE": 1, "LOST": 1}),
        (lambda goal: goal.fail(SimulatorGone("the simulator is gone")), {}),
        (lambda goal: goal.end_canceled(), {"FAILURE": 1, "CANCELED": 1}),
    ],
    ids=[
        "aborted",
        "preempted",
        "rejected",
        "of unknown end",
        "ended with its simulator",
        "canceled by another client",
    ],
)
def test_the_end_of_a_goal_is_counted(stage, end, counts):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    end(seen.goals[0])
    seen.tick()

    assert {"RUNNING": 1, **counts} == seen.counts("A")


def test_a_node_that_skips_itself_was_not_canceled(stage):
    """When its condition turns false, only the child below it is halted."""
    holds = iter([True, False])
    seen = stage(lambda: OnlyWhile(lambda: next(holds), Running("A")))
    seen.tick(2)

    assert {"RUNNING": 1, "SKIPPED": 1} == seen.counts("OnlyWhile")
    assert {"RUNNING": 1, "CANCELED": 1} == seen.counts("OnlyWhile/A")


def test_a_suspended_goal_was_canceled_once(stage):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    seen.goals[0].accept()
    suspend(seen.mission.root)
    seen.goals[0].end_canceled()
    seen.tick()

    assert {"RUNNING": 2, "CANCELED": 1} == seen.counts("A")


def test_the_trees_of_several_robots_are_counted_together():
    coverage = TreeCoverage()
    for robot in ("wall_e", "eve"):
        plan = Plan("test", lambda name: Success(f"Errand of {name}"), takes_robot=True, confirmed=False)
        Mission(robot, plan, coverage=coverage).tick(0.0)

    assert {"test/Errand of {robot}:SUCCESS"} == coverage.keys()


def test_a_tree_that_grows_is_counted_as_a_whole(stage):
    seen = stage(lambda: Parallel("Root", ParallelPolicy.SuccessOnAll(), children=[Running("A")]))
    seen.tick()
    seen.mission.root.add_child(Running("B"))
    seen.tick()

    assert ({"RUNNING": 2}, {"RUNNING": 1}) == (seen.counts("Root/A"), seen.counts("Root/B"))


TREE = "bt_controller.examples.hospital:mission"


def covered(**options):
    """Return what the hospital's mission has covered."""
    coverage = TreeCoverage()
    with simulation("hospital", **options) as run:
        run_tree(run.client, load(TREE), ["wall_e"], coverage=coverage)
    return {key.removeprefix(f"{TREE}/Mission of {{robot}}") for key in coverage.keys()}  # noqa: SIM118 - no mapping


def test_a_fault_shows_what_a_run_without_it_does_not():
    fault = {"type": "claw_misses", "robot": "wall_e", "at": 0, "duration": 60}
    more = covered(changes={"faults": [fault]}) - covered()
    steps = "/Deliver medicine/Fetch medicine/Get medicine"

    assert {f"{steps}/Pick up medicine:ABORTED/-4", f"{steps}/Pick up medicine again:RUNNING"} < more


def test_the_end_of_the_simulation_is_no_failure():
    """The trees did not fail: they had no time left."""
    keys = covered(settings=RunSettings(duration=5.0))

    assert {key.rpartition(":")[2] for key in keys} == {"RUNNING"}

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
        """Tick the recorded tree once."""
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


def test_each_tick_of_a_node_counts(stage):
    seen = stage(lambda: queue("A", Status.RUNNING, Status.RUNNING, Status.SUCCESS))
    seen.tick(3)

    assert {"RUNNING": 2, "SUCCESS": 1} == seen.counts("A")


def test_a_node_that_was_not_ticked_is_known(stage):
    seen = stage(lambda: Sequence("Root", memory=True, children=[Failure("A"), Success("B")]))
    seen.tick()

    assert {} == seen.counts("Root/B")


def test_a_node_that_is_halted_while_it_runs_was_canceled(stage):
    better = queue("A", Status.FAILURE, Status.RUNNING)
    seen = stage(lambda: Selector("Root", memory=False, children=[better, Running("B")]))
    seen.tick(2)

    assert {"RUNNING": 1, "CANCELED": 1} == seen.counts("Root/B")


def test_what_stops_with_the_run_was_not_canceled(stage):
    """The tree did not halt it."""
    seen = stage(lambda: Running("A"))
    seen.tick()
    seen.mission.interrupt()

    assert {"RUNNING": 1} == seen.counts("A")


def test_a_failure_after_which_another_child_succeeds_is_recovered(stage):
    seen = stage(lambda: Selector("Root", memory=True, children=[Failure("A"), Success("B")]))
    seen.tick()

    assert {"FAILURE": 1, "RECOVERED": 1} == seen.counts("Root/A")


def test_a_failure_further_below_is_recovered_too(stage):
    """Its sequence fails with it, and the selector makes up for both."""

    def tree():
        steps = Sequence("Steps", memory=True, children=[Success("A"), Failure("B")])
        return Selector("Root", memory=True, children=[steps, Success("C")])

    seen = stage(tree)
    seen.tick()

    assert {"FAILURE": 1, "RECOVERED": 1} == seen.counts("Root/Steps/B")


def test_a_failure_after_which_all_fails_is_not_recovered(stage):
    seen = stage(lambda: Selector("Root", memory=True, children=[Failure("A"), Failure("B")]))
    seen.tick()

    assert {"FAILURE": 1} == seen.counts("Root/A")


def test_a_step_that_succeeds_when_it_is_tried_again_is_recovered(stage):
    """The first attempt's failure counts until the decorator has ended."""

    def tree():
        steps = Sequence("Steps", memory=True, children=[Success("A"), queue("B", Status.FAILURE, Status.SUCCESS)])
        return Retry("Root", steps, 2)

    seen = stage(tree)
    seen.tick(2)

    assert {"FAILURE": 1, "SUCCESS": 1, "RECOVERED": 1} == seen.counts("Root/Steps/B")


def test_a_failure_that_is_an_answer_is_not_recovered(stage):
    """An inverter wants its child to fail."""
    seen = stage(
        lambda: Selector("Root", memory=True, children=[Inverter("Not", Failure("A")), Success("B")]),
    )
    seen.tick()

    assert {"FAILURE": 1} == seen.counts("Root/Not/A")


def test_a_halt_forgets_failures(stage):
    def tree():
        tried = Selector("Tried", memory=True, children=[queue("A", Status.FAILURE, Status.SUCCESS), Running("B")])
        better = queue("Better", Status.FAILURE, Status.RUNNING, Status.FAILURE)
        return Selector("Root", memory=False, children=[better, tried])

    seen = stage(tree)
    seen.tick(3)

    assert {"FAILURE": 1, "SUCCESS": 1} == seen.counts("Root/Tried/A")


def test_the_error_code_of_an_aborted_goal_is_counted(stage):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    seen.goals[0].accept()
    seen.goals[0].abort(701, "too long")
    seen.tick()

    assert {"RUNNING": 1, "FAILURE": 1, "ABORTED/701": 1} == seen.counts("A")


def test_a_preempted_goal_is_told_from_other_aborted_ones(stage):
    """The simulator says so by the goal's cause."""
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    goal = seen.goals[0]
    goal.end(GoalStatus.ABORTED, goal.action.failure(700, "preempted by goal 2"), "preempted")
    seen.tick()

    assert {"RUNNING": 1, "FAILURE": 1, "PREEMPTED": 1} == seen.counts("A")


def test_a_rejected_goal_is_counted(stage):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    seen.goals[0].reject("bad", "not now")
    seen.tick()

    assert {"RUNNING": 1, "FAILURE": 1, "REJECTED": 1} == seen.counts("A")


def test_a_goal_of_unknown_end_is_lost(stage):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    seen.goals[0].fail(RequestTimeout("no answer"))
    seen.tick()

    assert {"RUNNING": 1, "FAILURE": 1, "LOST": 1} == seen.counts("A")


def test_a_goal_that_ends_with_the_simulator_says_nothing(stage):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    seen.goals[0].fail(SimulatorGone("the simulator is gone"))
    seen.tick()

    assert {"RUNNING": 1} == seen.counts("A")


def test_a_node_that_skips_itself_was_not_canceled(stage):
    """When its condition turns false, only the child below it is halted."""
    holds = iter([True, False])
    seen = stage(lambda: OnlyWhile(lambda: next(holds), Running("A")))
    seen.tick(2)

    assert {"RUNNING": 1, "SKIPPED": 1} == seen.counts("OnlyWhile")
    assert {"RUNNING": 1, "CANCELED": 1} == seen.counts("OnlyWhile/A")


def test_a_goal_that_another_client_cancels_was_canceled(stage):
    seen = stage(lambda: Wait(1.0, name="A"))
    seen.tick()
    seen.goals[0].accept()
    seen.goals[0].end_canceled()
    seen.tick()

    assert {"RUNNING": 1, "FAILURE": 1, "CANCELED": 1} == seen.counts("A")


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

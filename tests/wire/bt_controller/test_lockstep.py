"""Trees that take part in a real simulator's time."""

from __future__ import annotations

import threading

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel, Sequence
from py_trees.decorators import Repeat, Timeout
from py_trees.timers import Timer

from bt_controller.behaviours.robot_actions import NavToPoseActionClient, pose_goal
from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.loading.trees import Plan
from bt_controller.running.clocks import STOP, Mailbox, clock_for
from bt_controller.running.mission import Mission
from bt_controller.running.runner import Runner
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.errors import Dropped, Idle
from tests.patience import PATIENCE
from tests.served_world import served_world


class Stage:
    """Runs trees against a simulator in lockstep.

    Attributes:
        ticks: The robot and the simulated time of each tick.
        messages: The messages of the root at these ticks.
        advances: How often time was granted.
        client: The connection.
    """

    def __init__(self, client):
        self.client = client
        self.mailbox = Mailbox()
        self.ticks = []
        self.messages = []

    def run(self, function, *robots, period=None):
        """Return the outcome of a tree for each robot."""
        plan = Plan("test", function, takes_robot=False, confirmed=False)
        missions = [Mission(robot, plan) for robot in robots]
        clock = clock_for(self.client, self.mailbox, feedback=period is not None, grace=0.1)
        self.runner = Runner(self.client, missions, clock, self.mailbox, show=self._show, period=period, grace=5.0)
        lockstep = self.client.lockstep
        outcome = self.runner.run()
        self.advances = lockstep._epoch
        return outcome

    def _show(self, mission, now):
        snapshot = mission.snapshot(now)
        self.ticks.append((snapshot.robot, snapshot.sim_time))
        self.messages.append(snapshot.nodes[0].message)


@pytest.fixture
def stage():
    """Return a stage, which runs trees."""
    with served_world(clock="lockstep") as options, Client(options, name="trees") as client:
        yield Stage(client)


def wait(seconds):
    return ActionLeaf(f"Wait {seconds}", "wait", Wait.Goal(time=Duration.from_seconds(seconds)))


def test_a_tree_is_ticked_when_its_goal_has_ended(stage):
    """A tree is ticked at no other instant, and each decision costs one round trip."""
    outcome = stage.run(lambda: Sequence("S", memory=True, children=[wait(2.5), wait(1000.0)]), "wall_e")

    assert outcome.statuses == {"wall_e": Status.SUCCESS}
    assert stage.ticks == [("wall_e", 0.0), ("wall_e", 2.5), ("wall_e", 1002.5)]
    assert stage.advances == 2


def test_the_goals_of_all_robots_go_along_with_one_advance(stage):
    """Three robots need one round trip."""
    stage.run(lambda: wait(3.0), "wall_e", "eve", "cart")

    assert stage.ticks == [(robot, time) for time in (0.0, 3.0) for robot in ("wall_e", "eve", "cart")]
    assert stage.advances == 1


def test_a_rejection_is_known_at_the_same_instant(stage):
    leaf = NavToPoseActionClient("Go", pose_goal(500.0, 500.0))
    outcome = stage.run(lambda: leaf, "wall_e")

    assert (outcome.succeeded, stage.ticks[-1]) == (False, ("wall_e", 0.0))
    assert "outside" in leaf.feedback_message


def test_a_timeout_cancels_its_goal_at_its_deadline(stage):
    outcome = stage.run(lambda: Timeout("T", wait(60.0), 5.0), "wall_e")

    assert (outcome.statuses, outcome.left) == ({"wall_e": Status.FAILURE}, ())
    assert stage.ticks == [("wall_e", 0.0), ("wall_e", 5.0)]


def test_each_periodic_tick_has_feedback_of_that_instant(stage):
    stage.run(lambda: wait(5.0), "wall_e", period=2.0)

    assert stage.ticks == [("wall_e", 0.0), ("wall_e", 2.0), ("wall_e", 4.0), ("wall_e", 5.0)]
    assert stage.messages[:3] == ["sent goal request", "feedback: time_left: 3.0 s", "feedback: time_left: 1.0 s"]


def test_a_behavior_can_read_the_time_from_the_client_of_its_setup(stage):
    seen = []

    class Watch(Behaviour):
        def setup(self, **kwargs):
            self.client = kwargs["client"]

        def update(self):
            seen.append(self.client.now)
            return Status.SUCCESS

    stage.run(lambda: Sequence("S", memory=True, children=[Timer("T", 7.0), Watch("W")]), "wall_e")

    assert seen == [7.0]


def test_a_wait_that_can_not_end_is_an_error_that_names_the_robots(stage):
    leaf = wait(1.0)
    leaf.initialise = lambda: setattr(leaf, "_handle", Never())
    with pytest.raises(Idle, match=r"nothing is scheduled .* the trees of wall_e wait for can't happen"):
        stage.run(lambda: leaf, "wall_e")


class Never:
    """A ticket of a goal that does not exist."""

    done = False
    feedback = None


def test_a_stop_cancels_the_goals_at_that_instant(stage):
    """The cancels go with one last advance, in which no time passes."""

    class Stop(Behaviour):
        def update(self):
            stage.mailbox.put(STOP)
            return Status.RUNNING

    policy = ParallelPolicy.SuccessOnAll()
    children = [wait(60.0), Sequence("S", memory=True, children=[Timer("T", 2.0), Stop("Stop")])]
    outcome = stage.run(lambda: Parallel("Both", policy=policy, children=children), "wall_e")

    assert (outcome.interrupted, outcome.left, stage.ticks[-1]) == (True, (), ("wall_e", 2.0))


def test_a_controller_that_thinks_for_too_long_gets_an_error():
    """The simulator continues without the trees, which end."""
    dropped = threading.Event()

    class Slow(Behaviour):
        def update(self):
            dropped.wait(PATIENCE)
            return Status.RUNNING

    with served_world(clock="lockstep", participant_timeout=0.1) as options, Client(options, name="trees") as client:
        client.subscribe("hmrsim/_world/events", lambda _key, body: b"dropped" in body and dropped.set())
        with pytest.raises(Dropped, match="'trees' was dropped at"):
            Stage(client).run(lambda: Slow("Slow"), "wall_e")


def test_feedback_reaches_the_leaf_whose_goal_it_is_about(stage):
    """Two leaves share an action, and the first one runs again after the second."""
    seen = []

    def leaf(name):
        goal = Wait.Goal(time=Duration.from_seconds(1.5))
        return ActionLeaf(name, "wait", goal, describe=lambda _feedback: seen.append(name) or name)

    steps = Sequence("S", memory=True, children=[leaf("A"), leaf("B")])
    stage.run(lambda: Repeat("R", steps, 2), "wall_e", period=1.0)

    assert ["A", "B", "A", "B"] == seen

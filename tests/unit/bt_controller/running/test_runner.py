"""When a runner ticks, and how it ends."""

from __future__ import annotations

import operator
from threading import Thread

import pytest
from py_trees.behaviour import Behaviour
from py_trees.behaviours import CheckBlackboardVariableValue, Failure, Running, SetBlackboardVariable, Success
from py_trees.common import Access, ComparisonExpression, ParallelPolicy, Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.timers import Timer

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.robots import NotServed
from bt_controller.examples import go_to_pose
from bt_controller.loading.trees import Plan
from bt_controller.running.clocks import STOP, Mailbox, clock_for
from bt_controller.running.mission import Mission, TreeCrashed
from bt_controller.running.runner import Runner
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim_zenoh.errors import SimulatorGone


class Stage:
    """Runs trees; after each tick comes the next step of a script."""

    def __init__(self, client):
        self.client = client
        self.mailbox = Mailbox()
        self.shown = []

    def run(self, function, *steps, robots=("wall_e",), confirmed=False, period=None, grace=0.0):
        """Return the outcome; a step is a function without arguments."""
        script = iter(steps)

        def show(mission, now):
            self.shown.append(mission.snapshot(now))
            next(script, lambda: None)()

        plan = Plan("test", function, takes_robot=False, confirmed=confirmed)
        missions = [Mission(robot, plan) for robot in robots]
        clock = clock_for(self.client, self.mailbox, feedback=period is not None, grace=grace)
        self.runner = Runner(self.client, missions, clock, self.mailbox, show=show, period=period, grace=grace)
        return self.runner.run()

    def goal(self, number=0):
        """Return the ticket of a goal, when it is there."""
        return self.client.goals[number]

    def stop(self):
        self.mailbox.put(STOP)


@pytest.fixture
def stage(client):
    """Return what runs a tree against a script."""
    return Stage(client)


def wait():
    return ActionLeaf("Wait", "wait", Wait.Goal())


def go():
    """Return a tree of one leaf that any robot serves."""
    return ActionLeaf("Go", "navigate_to_pose", NavigateToPose.Goal())


class Broken(Behaviour):
    """Raises an error at its first tick."""

    def update(self):
        raise KeyError("whoops")


class BreaksWhenStopped(Behaviour):
    """Runs, and raises an error when it is stopped."""

    def update(self):
        return Status.RUNNING

    def terminate(self, new_status):
        raise KeyError(new_status.name)


def test_the_stages_of_scenario_2(stage):
    """The robot goes to the text's goal, not to the listing's."""
    stage.run(
        go_to_pose,
        lambda: (stage.goal().accept(), stage.goal().feed(distance_remaining=468.8464660644531)),
        lambda: stage.goal().succeed(),
        confirmed=True,
    )

    position = stage.goal().goal.pose.pose.position
    assert (1, 450.0, 330.0) == (len(stage.client.goals), position.x, position.y)
    assert [[node.line() for node in snapshot.nodes] for snapshot in stage.shown] == [
        [
            "{-} GoToPoseSequence [*]",
            "    {o} GoToPoseFallback [*]",
            "        --> CheckArrived [✕] -- 'arrived' comparison failed [v: Status.RUNNING][e: Status.SUCCESS]",
            "        --> GoToPoseAction [*] -- sent goal request",
        ],
        [
            "{-} GoToPoseSequence [*]",
            "    {o} GoToPoseFallback [*]",
            "        --> CheckArrived [-]",
            "        --> GoToPoseAction [*] -- feedback: remaining: 468.8464660644531",
        ],
        [
            "{-} GoToPoseSequence [✓]",
            "    {o} GoToPoseFallback [✓]",
            "        --> CheckArrived [-]",
            "        --> GoToPoseAction [✓] -- successfully completed",
        ],
        [
            "{-} GoToPoseSequence [✓]",
            "    {o} GoToPoseFallback [✓]",
            "        --> CheckArrived [✓] -- 'arrived' comparison succeeded [v: Status.SUCCESS][e: Status.SUCCESS]",
            "        --> GoToPoseAction [-]",
        ],
    ]


class TestTicks:
    """When a tree is ticked."""

    def test_a_change_of_the_goal_is_a_tick(self, stage):
        outcome = stage.run(wait, lambda: stage.goal().succeed())

        assert [snapshot.tick for snapshot in stage.shown] == [1, 2]
        assert outcome.statuses == {"wall_e": Status.SUCCESS}

    def test_changes_that_are_not_announced_are_looked_for_each_period(self, stage):
        """The periods count from zero; one that was missed is not made up for."""
        stage.client.session.clock(9.5)
        stage.run(
            lambda: Running("Running"),
            lambda: (stage.client.session.clock(9.9), stage.client.session.clock(10.1)),
            lambda: (stage.client.session.clock(13.9), stage.client.session.clock(14.0)),
            stage.stop,
        )

        assert [snapshot.sim_time for snapshot in stage.shown] == [9.5, 10.1, 14.0]

    def test_a_tree_that_waits_for_its_goal_is_left_alone(self, stage):
        """Time that goes by is nothing to it, unless the user gave a period."""
        stage.run(wait, lambda: (stage.client.session.clock(50.0), stage.goal().succeed()))

        assert [snapshot.sim_time for snapshot in stage.shown] == [0.0, 50.0]

    def test_a_period_of_the_users_is_a_tick(self, stage):
        stage.run(
            wait,
            lambda: (stage.client.session.clock(1.9), stage.client.session.clock(2.0)),
            lambda: stage.client.session.clock(4.0),
            stage.stop,
            period=2.0,
        )

        assert [snapshot.sim_time for snapshot in stage.shown] == [0.0, 2.0, 4.0]

    def test_a_timer_ends_by_the_simulators_clock(self, stage):
        stage.client.session.clock(100.0)
        stage.run(
            lambda: Timer("Timer", 5.0),
            lambda: (stage.client.session.clock(104.9), stage.client.session.clock(105.0)),
        )

        assert [snapshot.sim_time for snapshot in stage.shown] == [100.0, 105.0]

    def test_all_trees_are_ticked_when_time_goes_back(self, stage, monkeypatch):
        """In a reset world, nothing is left of what the trees have waited for."""
        monkeypatch.setattr("bt_controller.running.clocks._STALE_CLOCK_SECONDS", 0.0)
        stage.client.session.clock(100.0)
        stage.run(wait, lambda: stage.client.session.clock(0.5), stage.stop)

        assert [snapshot.sim_time for snapshot in stage.shown] == [100.0, 0.5]

    def test_without_a_clock_goals_still_end(self, stage):
        """A real robot may publish no simulated time."""
        stage.client.session.latest.clear()
        outcome = stage.run(wait, lambda: stage.goal().succeed())

        assert [snapshot.sim_time for snapshot in stage.shown] == [None, None]
        assert outcome.succeeded

    def test_only_the_robot_with_news_is_ticked(self, stage):
        stage.run(
            go,
            lambda: None,
            lambda: stage.goal(1).feed(distance_remaining=1.0),
            stage.stop,
            robots=("wall_e", "eve"),
        )

        assert [(snapshot.robot, snapshot.tick) for snapshot in stage.shown] == [("wall_e", 1), ("eve", 1), ("eve", 2)]

    def test_a_tree_that_has_ended_is_not_ticked_again(self, stage):
        """A tick would begin it anew."""
        stage.run(lambda: Success("Success"))

        assert [snapshot.tick for snapshot in stage.shown] == [1]

    def test_a_confirmed_tree_that_fails_is_not_confirmed(self, stage):
        """Nothing is done, so nothing can be confirmed."""
        outcome = stage.run(lambda: Failure("Failure"), confirmed=True)

        assert (len(stage.shown), outcome.succeeded) == (1, False)

    def test_a_synchronised_parallel_does_not_send_a_finished_goal_again(self, stage):
        def both():
            leaves = [ActionLeaf(name, "wait", Wait.Goal()) for name in ("A", "B")]
            return Parallel("Both", policy=ParallelPolicy.SuccessOnAll(synchronise=True), children=leaves)

        stage.run(both, lambda: stage.goal(0).succeed(), lambda: stage.goal(1).succeed())

        assert len(stage.client.goals) == 2


class TestEnds:
    """A run ends with its trees, by a signal or with the simulator."""

    def test_all_trees_have_to_succeed(self, stage):
        outcome = stage.run(
            go,
            lambda: stage.goal(0).succeed(),
            lambda: stage.goal(1).abort(208, "no way"),
            robots=("wall_e", "eve"),
        )

        assert outcome.statuses == {"wall_e": Status.SUCCESS, "eve": Status.FAILURE}
        assert outcome.succeeded is False

    def test_a_robot_that_is_not_there_is_an_error_even_for_a_tree_without_actions(self, stage):
        with pytest.raises(NotServed, match="no robot 'wally'; did you mean 'wall_e'"):
            stage.run(lambda: Success("Success"), robots=("wally",))

    def test_an_interrupt_cancels_the_goals_and_waits_for_their_end(self, stage):
        """The cancel is on its way before the session is closed."""

        def ctrl_c():
            stage.goal().when_canceled = stage.goal().end_canceled
            stage.stop()

        outcome = stage.run(wait, ctrl_c, grace=60.0)

        assert (outcome.interrupted, outcome.left, stage.goal().canceled) == (True, (), True)

    def test_a_second_interrupt_does_not_wait_for_the_goals_end(self, stage):
        """A simulator that does not answer can't hold us."""

        def ctrl_c():
            stage.goal().when_canceled = stage.stop
            stage.stop()

        outcome = stage.run(wait, ctrl_c, grace=60.0)

        assert (outcome.interrupted, outcome.left) == (True, ("wall_e",))

    def test_goals_are_canceled_while_a_behaviour_blocks(self, stage):
        seen = []

        class Busy(Behaviour):
            """Gives up on the runner from within a tick, in a thread as the signals' is."""

            def update(self):
                """Wait until another thread has given up on the runner."""
                stage.goal().when_canceled = stage.goal().end_canceled
                thread = Thread(target=lambda: seen.append(stage.runner.give_up()))
                thread.start()
                thread.join()
                return Status.FAILURE

        policy = ParallelPolicy.SuccessOnAll()
        stage.run(lambda: Parallel("Both", policy=policy, children=[wait(), Busy("Busy")]))

        assert [(True, ())] == [(outcome.interrupted, outcome.left) for outcome in seen]

    def test_a_simulator_that_dies_under_a_goal_ends_the_tree(self, stage):
        outcome = stage.run(wait, lambda: stage.goal().fail(SimulatorGone("the simulator is gone")))

        assert outcome.statuses == {"wall_e": Status.FAILURE}

    def test_a_simulator_that_dies_while_nothing_is_asked_of_it_ends_the_tree(self, stage):
        """The clock no longer advances, and nothing else would wake the tree."""
        stage.client.session.vanish()
        outcome = stage.run(lambda: Running("Running"), grace=0.0)

        assert (outcome.gone, outcome.succeeded) == (True, False)

    def test_a_client_that_is_closed_ends_the_tree_as_the_end_of_the_simulator_does(self, stage):
        outcome = stage.run(lambda: Running("Running"), stage.client.close, grace=0.0)

        assert (outcome.gone, outcome.succeeded) == (True, False)

    def test_a_behaviour_that_raises_ends_the_run_and_cancels_the_goals(self, stage):
        def tree():
            policy = ParallelPolicy.SuccessOnAll()
            children = [Sequence("Inner", memory=True, children=[wait()]), Broken("Broken")]
            return Parallel("Both", policy=policy, children=children)

        with pytest.raises(
            TreeCrashed, match=r"the tree of 'wall_e' broke at 'Broken': KeyError: 'whoops' \(.*test_runner\.py:"
        ):
            stage.run(tree, grace=0.0)

        assert stage.goal().canceled is True

    def test_a_tree_that_is_ticked_again_and_again_at_an_instant_ends_the_run(self, stage, monkeypatch):
        monkeypatch.setattr("bt_controller.running.mission._MAX_AT_ONCE", 3)
        with pytest.raises(TreeCrashed, match=r"the tree of 'wall_e' was ticked 3 times at 0\.0 s, so that time can't"):
            stage.run(lambda: Running("Running"), *[lambda: stage.mailbox.put("wall_e")] * 5)

    def test_a_behaviour_that_raises_when_it_is_stopped_does_not_keep_goals_from_being_canceled(self, stage, caplog):
        def tree():
            policy = ParallelPolicy.SuccessOnAll()
            children = [BreaksWhenStopped("Bad"), Sequence("Good", memory=True, children=[wait()])]
            return Parallel("Both", policy=policy, children=children)

        stage.mailbox.put(STOP)
        outcome = stage.run(tree, grace=0.0)

        assert (True, True) == (outcome.interrupted, stage.goal().canceled)
        (line,) = caplog.messages
        assert line.startswith("the tree of 'wall_e' broke while it was stopped: KeyError: 'INVALID' (")


class TestEntries:
    """A tree may read its own entries."""

    def test_what_was_written_is_looked_at_at_once(self, stage):
        """Not a period later: the goal that was sent in the same tick is canceled at the same instant."""

        def tree():
            flag = ComparisonExpression("flag", 1, operator.eq)
            set_flag = SetBlackboardVariable("Set", "flag", 1, overwrite=True)
            act = Sequence("Act", memory=True, children=[set_flag, wait()])
            return Selector("Or", memory=False, children=[CheckBlackboardVariableValue("Flag?", flag), act])

        outcome = stage.run(tree)

        assert ({"wall_e": Status.SUCCESS}, True) == (outcome.statuses, stage.goal().canceled)

    def test_a_tree_that_writes_at_each_tick_does_not_hold_time_up(self, stage):
        """It is ticked ten times at an instant, and then each period."""
        ticks = []

        class Counts(Behaviour):
            """Writes how often it was ticked, and wants an end the tenth time."""

            def setup(self, **_kwargs):
                self.board = self.attach_blackboard_client()
                self.board.register_key("count", Access.WRITE)

            def update(self):
                ticks.append(len(ticks))
                self.board.set("count", len(ticks))
                if len(ticks) == 10:
                    stage.mailbox.put(STOP)
                return Status.RUNNING

        stage.run(lambda: Counts("Counts"))

        assert 10 == len(ticks)


class TestBlackboards:
    """Each robot has its own keys."""

    def test_two_robots_do_not_share_their_keys(self, stage):
        """That one has arrived does not mean that the other has."""
        stage.run(
            go_to_pose,
            lambda: None,
            lambda: stage.goal(0).succeed(),
            lambda: None,
            stage.stop,
            robots=("wall_e", "eve"),
            confirmed=True,
        )

        statuses = {snapshot.robot: snapshot.nodes[0].status for snapshot in stage.shown}
        assert statuses == {"wall_e": Status.SUCCESS, "eve": Status.RUNNING}
        assert len(stage.client.goals) == 2

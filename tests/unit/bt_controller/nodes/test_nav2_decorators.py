"""Nav2's decorators: what their documentation says, sentence by sentence."""

from __future__ import annotations

import math

import pytest

from bt_controller.core.node import PortError
from bt_controller.nodes.controls.nav2 import PipelineSequence
from bt_controller.nodes.controls.sequences import Parallel, ReactiveFallback
from bt_controller.nodes.decorators.gates import SingleTrigger
from bt_controller.nodes.decorators.nav2 import (
    DistanceController,
    GoalUpdatedController,
    GoalUpdater,
    PathLongerOnApproach,
    RateController,
    SpeedController,
)
from hmrsim_zenoh.client.places import pose_at


class TestRateController:
    """A child that is ticked so often."""

    def test_the_child_is_ticked_at_once_and_then_at_the_rate(self, node, told, tree):
        child = told("S")
        ticked = tree(node(RateController, child, hz="2.0"))

        assert "SRSRS" == ticked.ticks(0, 0.25, 0.5, 0.75, 1.0)
        assert 3 == child.ticks

    def test_the_default_is_ten_times_a_second(self, node, told, tree):
        assert "SRS" == tree(node(RateController, told("S"))).ticks(0, 0.0999, 0.1)

    def test_a_child_that_runs_is_ticked_each_time(self, node, told, tree):
        child = told("RRS")

        assert "RRSR" == tree(node(RateController, child, hz="1.0")).ticks(0, 0.1, 0.2, 0.3)
        assert (3, 1) == (child.ticks, child.begun)

    def test_the_time_counts_from_the_last_success(self, node, told, tree):
        ticked = tree(node(RateController, told("RS"), hz="1.0"))
        ticked.ticks(0, 0.5)

        assert 1.5 == ticked.due()

    def test_it_looks_again_when_the_time_comes(self, node, told, tree):
        ticked = tree(node(RateController, told("SR"), hz="1.0"))
        dues = []
        for now in (0.0, 0.5, 1.0):
            ticked.tick(now)
            dues.append(ticked.due(period=100.0))

        assert [1.0, 1.0, math.inf] == dues

    def test_halted_it_ticks_its_child_at_once(self, node, told, tree):
        child = told("SR")
        ticked = tree(node(RateController, child, hz="1.0"))
        ticked.ticks(0, 0.1)
        ticked.halt()
        ticked.tick(0.2)

        assert 2 == child.ticks

    def test_a_rate_that_is_none_is_an_error(self, node, told, tree):
        with pytest.raises(PortError, match=r"port 'hz': 0 is not a rate; expected a number greater than 0"):
            tree(node(RateController, told("S"), hz=0.0)).tick()

    def test_a_failure_is_its_own(self, node, told, tree):
        assert "F" == tree(node(RateController, told("F"))).tick()
        assert "-" == tree(node(RateController, told("-"))).tick()


class TestDistanceController:
    """A child that is ticked so far on the way."""

    def test_the_child_is_ticked_at_once_and_then_each_so_many_metres(self, node, told, tree, topics):
        child = told("S")
        ticked = tree(node(DistanceController, child, distance="2.0"), **topics.known)
        statuses = []
        for x in (0.0, 1.9, 2.0, 3.9, 4.1):
            topics.at(x, 0.0)
            statuses.append(ticked.tick())

        assert list("SRSRS") == statuses
        assert 3 == child.ticks

    def test_a_child_that_runs_is_ticked_each_time(self, node, told, tree, topics):
        ticked = tree(node(DistanceController, told("RRS")), **topics.known)

        assert "RR" == ticked.ticks(0, 1)
        assert math.inf == ticked.due()

    def test_the_robots_position_has_to_be_looked_at(self, node, told, tree, topics):
        ticked = tree(node(DistanceController, told("S")), **topics.known)
        ticked.ticks(0, 0.5)

        assert 1.0 == ticked.due()


class TestSpeedController:
    """A rate that goes with the speed."""

    @pytest.mark.parametrize(("speed", "period"), [(0.0, 10.0), (0.25, 1 / 0.55), (0.5, 1.0), (9.0, 1.0)])
    def test_the_faster_the_robot_the_more_often_the_child_is_ticked(self, node, told, tree, topics, speed, period):
        """0.1 Hz for a robot that stands, 1 Hz at 0.5 m/s and above, linear between that."""
        topics.at(0.0, 0.0, speed=speed)
        ticked = tree(node(SpeedController, told("S")), **topics.known)
        ticked.ticks(0, 1)

        assert pytest.approx(1.0 + period) == ticked.due(period=100.0)

    def test_one_speed_may_be_the_limit_between_two_rates(self, node, told, tree, topics):
        topics.at(0.0, 0.0, speed=0.4)
        ticked = tree(node(SpeedController, told("S"), min_speed="0.5", max_speed="0.5"), **topics.known)
        ticked.ticks(0, 1)

        assert 11.0 == ticked.due(period=100.0)

    def test_the_first_period_is_that_of_the_greatest_rate(self, node, told, tree, topics):
        assert "SRS" == tree(node(SpeedController, told("S")), **topics.known).ticks(0, 0.9, 1.0)

    def test_another_goal_has_the_child_ticked_at_once(self, node, told, tree, topics, board):
        board["/goal"] = pose_at(1.0, 1.0)
        ticked = tree(node(SpeedController, told("S")), **topics.known)
        ticked.ticks(0, 0.1)
        board["/goal"] = pose_at(2.0, 1.0)

        assert "S" == ticked.tick(0.2)

    def test_a_child_that_runs_is_ticked_each_time(self, node, told, tree, topics):
        assert "RRS" == tree(node(SpeedController, told("RRS")), **topics.known).ticks(0, 0.1, 0.2)


class TestGoalUpdatedController:
    """A child that is ticked for each goal."""

    def test_the_child_is_ticked_at_once_and_when_the_goal_changes(self, node, told, tree, board):
        child = told("S")
        board["/goal"] = pose_at(1.0, 1.0)
        ticked = tree(node(GoalUpdatedController, child))

        assert "SR" == ticked.ticks(0, 1)
        board["/goal"] = pose_at(2.0, 1.0)
        assert "SR" == ticked.ticks(2, 3)
        assert 2 == child.ticks

    def test_other_goals_count_too(self, node, told, tree, board):
        ticked = tree(node(GoalUpdatedController, told("S")))
        ticked.ticks(0, 1)
        board["/goals"] = [pose_at(1.0, 1.0)]

        assert "S" == ticked.tick(2)

    def test_a_child_that_runs_is_ticked_each_time(self, node, told, tree):
        assert "RRSR" == tree(node(GoalUpdatedController, told("RRS"))).ticks(0, 1, 2, 3)


class TestGoalUpdater:
    """Goals that are handed on."""

    def test_the_goals_go_through_at_each_tick(self, node, told, tree, board):
        updater = node(
            GoalUpdater, told("R"), input_goal="{a}", output_goal="{b}", input_goals="{c}", output_goals="{d}"
        )
        board["/a"], board["/c"] = pose_at(1.0, 2.0), [pose_at(3.0, 4.0)]
        tree(updater).tick()

        assert (pose_at(1.0, 2.0), [pose_at(3.0, 4.0)]) == (board["/b"], board["/d"])

    def test_it_is_what_its_child_is(self, node, told, tree):
        assert "RSF" == tree(node(GoalUpdater, told("RSF"))).ticks(0, 1, 2)


class TestSingleTrigger:
    """SingleTrigger ticks its child until it has ended once."""

    def test_the_child_is_ticked_until_it_has_ended_and_then_no_more(self, node, told, tree):
        child = told("RS")

        assert "RSFF" == tree(node(SingleTrigger, child)).ticks(0, 1, 2, 3)
        assert 2 == child.ticks

    def test_a_reset_gives_it_another_turn(self, node, told, tree):
        ticked = tree(node(SingleTrigger, told("S")))
        ticked.ticks(0, 1)
        ticked.halt()

        assert "S" == ticked.tick(2)

    def test_a_global_one_has_one_turn_even_after_a_reset(self, node, told, tree):
        ticked = tree(node(SingleTrigger, told("S"), is_global="true"))
        ticked.tick()
        ticked.halt()

        assert "F" == ticked.tick(1)

    def test_it_is_looked_at_below_a_control_that_resets_it(self, node, told, tree):
        """Each tick then gives the child another turn, which may end otherwise."""
        ticked = tree(node(ReactiveFallback, node(SingleTrigger, told("F")), told("R")))
        ticked.tick()

        assert 1.0 == ticked.due()


@pytest.mark.parametrize("control", [PipelineSequence, Parallel])
def test_a_controller_whose_child_is_skipped_is_looked_at(node, told, tree, topics, control):
    """It is ticked again each time, and the child may have something to do."""
    due = []
    for kind in (RateController, SpeedController):
        ticked = tree(node(control, node(kind, told("-")), told("R")), **topics.known)
        ticked.tick()
        due.append(ticked.due())

    assert [1.0, 1.0] == due


class TestPathLongerOnApproach:
    """A detour shortly before the goal."""

    @pytest.fixture
    def detour(self, node, told, tree, board, path):
        """Return the function that ticks it with one path after the other; the child's ticks come after that."""

        def run(*paths, **ports):
            child = told("F")
            ticked = tree(node(PathLongerOnApproach, child, path="{path}", **ports))
            statuses = []
            for points in paths:
                board["/path"] = path(*points)
                statuses.append(ticked.tick())
            return "".join(statuses), child.ticks

        return run

    def test_a_much_longer_path_to_a_goal_that_was_near_has_the_child_ticked(self, detour):
        """2 m, then 5 m: more than twice as long. The node is what the child is."""
        assert ("SF", 1) == detour([(0, 0), (2, 0)], [(0, 0), (1, 1.5), (1, 3), (2, 0)])

    @pytest.mark.parametrize(
        "second",
        [[(0, 0), (1, 1), (2, 0)], [(0, 0), (1, 4), (3, 0)], [(0, 0), (2, 0)]],
        ids=["not much longer", "to another goal", "the same"],
    )
    def test_otherwise_it_succeeds_without_it(self, detour, second):
        assert ("SS", 0) == detour([(0, 0), (2, 0)], second)

    def test_a_path_that_was_long_may_become_longer(self, detour):
        """4 m is not within the proximity of 3 m."""
        assert ("SS", 0) == detour([(0, 0), (4, 0)], [(0, 0), (2, 9), (4, 0)])

    def test_proximity_and_length_factor_can_be_set(self, detour):
        """Here they are 10 m, and one and a half times."""
        assert ("SF", 1) == detour([(0, 0), (4, 0)], [(0, 0), (2, 3), (4, 0)], prox_len="10", length_factor="1.5")

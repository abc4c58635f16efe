"""Nav2's decorators: what their documentation says, sentence by sentence."""

from __future__ import annotations

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
from tests.unit.bt_controller.nodes.conftest import NEVER, At, Row, rows

HERE, THERE = {"goal": pose_at(1.0, 1.0)}, {"goal": pose_at(2.0, 1.0)}


def per_second(number):
    return {"hz": str(number)}


@rows(
    {
        "the child is ticked at once and then at the rate": Row(
            RateController, "S", "SRSRS", per_second(2.0), (0, 0.25, 0.5, 0.75, 1.0), ticks="3"
        ),
        "the default is ten times a second": Row(RateController, "S", "SRS", times=(0, 0.0999, 0.1)),
        "a child that runs is ticked each time": Row(
            RateController, "RRS", "RRSR", per_second(1.0), (0, 0.1, 0.2, 0.3), ticks="3", begun="1"
        ),
        "the time counts from the last success": Row(RateController, "RS", "RS", per_second(1.0), (0, 0.5), due=1.5),
        "it looks again when the time comes": Row(
            RateController, "SR", "SR", per_second(1.0), (0, 0.5), due=1.0, period=100.0
        ),
        "it does not look while its child runs": Row(
            RateController, "SR", "SRR", per_second(1.0), (0, 0.5, 1), due=NEVER
        ),
        "halted it ticks its child at once": Row(
            RateController, "SR", "SR!R", per_second(1.0), (0, 0.1, 0.2), ticks="2"
        ),
        "a failure is its own": Row(RateController, "F", "F"),
        "it is skipped with its child": Row(RateController, "-", "-"),
    }
)
def test_rate_controller(behaves, row):
    behaves(row)


def test_a_rate_that_is_none_is_an_error(node, told, tree):
    with pytest.raises(PortError, match=r"port 'hz': 0 is not a rate; expected a number greater than 0"):
        tree(node(RateController, told("S"), hz=0.0)).tick()


@rows(
    {
        "the child is ticked at once and then each so many meters": Row(
            DistanceController,
            "S",
            ["S", At(1.9), "R", At(2.0), "S", At(3.9), "R", At(4.1), "S"],
            {"distance": "2.0"},
            ticks="3",
        ),
        "a child that runs is ticked each time": Row(DistanceController, "RRS", "RR", due=NEVER),
        "the robot's position has to be looked at": Row(DistanceController, "S", "SR", times=(0, 0.5), due=1.0),
    }
)
def test_distance_controller(behaves, row):
    behaves(row)


@rows(
    {
        "a robot that stands has the least rate": Row(SpeedController, "S", "SS", due=11.0, period=100.0),
        "the rate is linear in the speed": Row(
            SpeedController, "S", "SS", at=At(speed=0.25), due=1 + 1 / 0.55, period=100.0
        ),
        "at half a meter per second the rate is the greatest": Row(
            SpeedController, "S", "SS", at=At(speed=0.5), due=2.0, period=100.0
        ),
        "a faster robot has the greatest rate too": Row(
            SpeedController, "S", "SS", at=At(speed=9.0), due=2.0, period=100.0
        ),
        "one speed may be the limit between two rates": Row(
            SpeedController,
            "S",
            "SS",
            {"min_speed": "0.5", "max_speed": "0.5"},
            at=At(speed=0.4),
            due=11.0,
            period=100.0,
        ),
        "the first period is that of the greatest rate": Row(SpeedController, "S", "SRS", times=(0, 0.9, 1.0)),
        "another goal has the child ticked at once": Row(
            SpeedController, "S", ["SR", THERE, "S"], times=(0, 0.1, 0.2), before=HERE
        ),
        "a child that runs is ticked each time": Row(SpeedController, "RRS", "RRS", times=(0, 0.1, 0.2)),
    }
)
def test_speed_controller(behaves, row):
    behaves(row)


@rows(
    {
        "the child is ticked at once and when the goal changes": Row(
            GoalUpdatedController, "S", ["SR", THERE, "SR"], before=HERE, ticks="2"
        ),
        "other goals count too": Row(GoalUpdatedController, "S", ["SR", {"goals": [pose_at(1.0, 1.0)]}, "S"]),
        "a child that runs is ticked each time": Row(GoalUpdatedController, "RRS", "RRSR"),
    }
)
def test_goal_updated_controller(behaves, row):
    behaves(row)


@rows(
    {
        "the goals go through at each tick": Row(
            GoalUpdater,
            "R",
            [{"a": pose_at(1.0, 2.0), "c": [pose_at(3.0, 4.0)]}, "R"],
            {"input_goal": "{a}", "output_goal": "{b}", "input_goals": "{c}", "output_goals": "{d}"},
            after={"b": pose_at(1.0, 2.0), "d": [pose_at(3.0, 4.0)]},
        ),
        "it is what its child is": Row(GoalUpdater, "RSF", "RSF"),
    }
)
def test_goal_updater(behaves, row):
    behaves(row)


@rows(
    {
        "the child is ticked until it has ended and then no more": Row(SingleTrigger, "RS", "RSFF", ticks="2"),
        "a reset gives it another turn": Row(SingleTrigger, "S", "SF!S"),
        "a global one has one turn even after a reset": Row(SingleTrigger, "S", "S!F", {"is_global": "true"}),
    }
)
def test_single_trigger(behaves, row):
    behaves(row)


def test_a_single_trigger_is_looked_at_below_a_control_that_resets_it(node, told, tree):
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


@pytest.mark.parametrize(
    ("first", "second", "ports", "statuses", "ticks"),
    [
        ([(0, 0), (2, 0)], [(0, 0), (1, 1.5), (1, 3), (2, 0)], {}, "SF", "1"),
        ([(0, 0), (2, 0)], [(0, 0), (1, 1), (2, 0)], {}, "SS", "0"),
        ([(0, 0), (2, 0)], [(0, 0), (1, 4), (3, 0)], {}, "SS", "0"),
        ([(0, 0), (2, 0)], [(0, 0), (2, 0)], {}, "SS", "0"),
        ([(0, 0), (4, 0)], [(0, 0), (2, 9), (4, 0)], {}, "SS", "0"),
        ([(0, 0), (4, 0)], [(0, 0), (2, 3), (4, 0)], {"prox_len": "10", "length_factor": "1.5"}, "SF", "1"),
    ],
    ids=[
        "more than twice as long",
        "not much longer",
        "to another goal",
        "the same",
        "not near",
        "limits of the ports",
    ],
)
def test_a_detour_shortly_before_the_goal_has_the_child_ticked(behaves, path, first, second, ports, statuses, ticks):
    steps = [statuses[0], {"path": path(*second)}, statuses[1]]

    behaves(
        Row(PathLongerOnApproach, "F", steps, {"path": "{path}", **ports}, before={"path": path(*first)}, ticks=ticks)
    )

"""Traffic of robots at places beside the lanes, and in the middle of a lane."""

from __future__ import annotations

import pytest

from hmrsim.geometry import distance
from hmrsim.protocol.commands import CallService
from hmrsim.services import registry as services
from tests.simulation import simulate, wait
from tests.unit.hmrsim.traffic.runs import go

A, B, C = (letter * 32 for letter in "abc")
YIELDING = ("priority", "planned")
LINE = {
    "waypoints": {"a": [0, 0], "b": [4, 0], "c": [8, 0], "d": [12, 0]},
    "lanes": [["a", "b"], ["b", "c"], ["c", "d"]],
}
FORK = {
    "waypoints": {"a": [0, 0], "b": [4, 0], "c": [8, 0], "d": [4, 3]},
    "lanes": [["a", "b"], ["b", "c"], ["b", "d"]],
}
BASE = {"base": {"speed": 1.0, "radius": 0.3}}


def fleet(policy, world, robots, **settings):
    """Return a simulation of robots of 0.3 m at these points."""
    there = {name: {"at": at, **BASE} for name, at in robots.items()}
    return simulate({**world, "robots": there, "traffic": {"policy": policy, **settings}})


def end(log, goal_id):
    """Return when and how a goal ended."""
    return log.changes(goal_id)[-1]


@pytest.mark.parametrize("policy", YIELDING)
class TestYielding:
    def test_a_robot_leaves_the_place_to_which_another_one_is_sent(self, policy):
        run = fleet(policy, LINE, {"parked": [4, 1], "comes": "a"})
        log = run((0.0, go("comes", 4, 1, A)))

        assert (6.0, "SUCCEEDED") == end(log, A)
        assert ["parked", "parked"] == [fields["robot"] for _, fields in log.happened("made_room")]

    def test_two_change_places_where_one_can_step_aside(self, policy):
        """One wants into the place beside a dead end, and the other one out of it."""
        run = fleet(policy, FORK, {"leaves": [8, 1.5], "comes": "a"})
        log = run((0.0, go("comes", 8, 1.5, A)), (0.0, go("leaves", 0, 0, B)))

        assert ["SUCCEEDED"] * 2 == [end(log, A)[1], end(log, B)[1]]

    def test_a_robot_in_the_middle_of_a_lane_drives_back_to_let_another_one_out(self, policy):
        run = fleet(policy, {**FORK, "waypoints": {**FORK["waypoints"], "c": [10, 0]}}, {"idle": "c", "comes": [7, 0]})
        log = run((0.0, go("comes", 10, 0, A)))

        assert (18.0, "SUCCEEDED") == end(log, A)

    def test_a_robot_makes_room_at_a_waypoint_for_one_that_would_touch_it_beside(self, policy):
        """The place is 0.5 m from the waypoint, and two robots need 0.6 m."""
        run = fleet(policy, LINE, {"idle": "b", "comes": "a"})
        log = run((0.0, go("comes", 4, 0.5, A)))
        robots = run.simulator.robots

        assert (8.5, "SUCCEEDED") == end(log, A)
        assert distance(robots["idle"].pose().point, robots["comes"].pose().point) >= 0.6

    def test_a_robot_drives_around_a_one_way_cell_to_let_another_one_out(self, policy):
        cell = {"n": [0, 5], "e": [5, 0], "s": [0, -5], "w": [-5, 0], "bay": [9, 0], "aside": [0, 9]}
        lanes = [{"from": one, "to": other, "one_way": True} for one, other in ("en", "nw", "ws", "se")]
        world = {"waypoints": cell, "lanes": [*lanes, ["e", "bay"], ["n", "aside"]]}
        run = fleet(policy, world, {"first": "e", "inside": "bay"})
        log = run((0.0, go("first", 9, 0, A)), (0.0, go("inside", -5, 0, B)))

        assert ["SUCCEEDED"] * 2 == [end(log, A)[1], end(log, B)[1]]


@pytest.mark.parametrize("policy", ["reserve", *YIELDING])
class TestWaiting:
    def test_a_robot_waits_for_a_place_before_the_last_lane(self, policy):
        """Another robot works there until 20 s, and a third one passes from b to c meanwhile."""
        run = fleet(policy, LINE, {"works": [8, 1], "comes": "a", "passes": "b"})
        run.simulator.submit(wait(20, C, "works"))
        log = run((0.0, go("comes", 8, 1, A)), (0.0, go("passes", 12, 0, B)), until=15.0)

        assert (8.0, "SUCCEEDED") == end(log, B)
        assert (4.0, 0.0) == run.simulator.robots["comes"].pose().point

    def test_patience_does_not_count_while_the_robot_ahead_drives(self, policy):
        """It takes 80 s on its lane, and the patience is 60 s."""
        world = {"waypoints": {"a": [0, 0], "b": [4, 0], "c": [44, 0], "d": [50, 0]}, "lanes": LINE["lanes"]}
        robots = {"slow": {"at": "b", "base": {"speed": 0.5}}, "behind": {"at": "a", "base": {"speed": 1.0}}}
        run = simulate({**world, "robots": robots, "traffic": {"policy": policy}})
        log = run((0.0, go("slow", 50, 0, A)), (0.0, go("behind", 44, 0, B)))

        assert (120.0, "SUCCEEDED") == end(log, B)

    def test_patience_does_not_count_while_the_robot_in_the_way_works(self, policy):
        run = fleet(policy, FORK, {"works": "b", "comes": "a"})
        run.simulator.submit(wait(65, C, "works"))
        log = run((0.0, go("comes", 4, 3, A)), until=64.0)

        assert (0.0, "EXECUTING") == end(log, A)


def test_a_repeated_goal_has_its_whole_patience():
    run = fleet("reserve", FORK, {"idle": "b", "comes": "a"}, patience=10.0)
    log = run((0.0, go("comes", 8, 0, A)), (10.0, go("comes", 8, 0, B)))

    assert [(10.0, "ABORTED"), (20.0, "ABORTED")] == [end(log, A), end(log, B)]


def test_a_robot_that_is_put_beside_another_one_can_leave_it():
    run = fleet("priority", LINE, {"one": [4, 1], "other": "d"})
    request = {"entity": "other", "state": {"pose": {"position": {"x": 4.2, "y": 1.0}}}}
    message = services()["set_entity_state"].request.model_validate(request)
    run.simulator.submit(CallService("set_entity_state", message, object()))
    log = run((0.0, go("one", 0, 0, A)))

    assert (5.0, "SUCCEEDED") == end(log, A)


class TestExplanation:
    """Results of goals explain which robot was in the way, and why it made no room."""

    def test_a_docked_robot_in_the_way_is_named(self):
        world = {**LINE, "docks": {"berth": {"at": "b"}}}
        run = fleet("priority", world, {"docked": "b", "comes": "a"})
        log = run((0.0, go("comes", 8, 0, A)))
        robots = {"robot": "comes", "at": [0.0, 0.0], "waited": 60.0, "for": ["docked"]}

        why = (
            "comes has waited at a since 0 s for docked, which makes no room meanwhile;"
            " docked is docked in 'berth' at b: it has had no goal yet;"
            " what would help: have its controller undock it once it is charged,"
            " add docks, or move the dock off the route; no policy moves a docked robot"
        )
        assert f"blocked for 60 s: {why}" == log.result(A).error_msg
        assert [(60.0, {**robots, "why": why})] == log.happened("gave_up_waiting")

    def test_a_robot_without_room_to_yield_is_named_with_its_blockers(self):
        world = {"waypoints": LINE["waypoints"], "lanes": LINE["lanes"][:2]}
        run = fleet("priority", world, {"idle": "b", "end": "c", "comes": "a"})
        log = run((0.0, go("comes", 8, 0, A)))

        text = "comes has waited at a since 0 s for idle, which has nowhere to go: a and c are taken by comes, end"
        assert log.result(A).error_msg.startswith(f"blocked for 60 s: {text}; idle is idle at b")


def test_a_door_stays_open_for_a_robot_that_waits_beside_the_lane():
    """Otherwise it would close and open again and again."""
    door = {"gate": {"at": [[10, -1], [10, 1]], "opening_time": 2, "stays_open": 3}}
    world = {**LINE, "doors": door, "lanes": [["a", "b"], ["b", "d"]]}
    run = fleet("reserve", world, {"one": [9, 2], "works": "d"})
    log = run((0.0, wait(50, B, "works")), (0.5, go("one", 12, 0, A)), until=40.0)

    assert [1, 0] == [len(log.happened(kind)) for kind in ("door_opened", "door_closed")]


@pytest.mark.parametrize("policy", ["reserve", *YIELDING])
def test_patience_behind_a_door_is_that_behind_the_robot_in_the_way(policy):
    """The robot beyond the door works for longer than the patience."""
    door = {"gate": {"at": [[2, -1], [2, 1]], "opening_time": 30}}
    world = {"waypoints": {"a": [0, 0], "b": [4, 0]}, "lanes": [["a", "b"]], "doors": door}
    run = fleet(policy, world, {"works": "b", "comes": [0, 1]}, patience=10)
    log = run((0.0, wait(60, B, "works")), (0.5, go("comes", 4, 0, A)), until=59.0)

    assert (0.5, "EXECUTING") == end(log, A)
    log = run(until=100.0)
    cause = "works is idle at b: it has had no goal since wait SUCCEEDED at 60 s"
    assert policy != "reserve" or cause in log.result(A).error_msg


def test_unused_places_are_forgotten():
    """Clients may send robots to any number of points."""
    run = fleet("reserve", LINE, {"parked": [4, 1], "comes": "a"})
    slots = run.simulator.roster.admission._rules.slots
    parked = slots.held(run.simulator.robots["parked"])
    for number in range(1_000):
        slots.spot((number / 10, 50.0))

    assert len(slots.points) < 300
    assert (4.0, 1.0) == slots.points[parked[-1]]


@pytest.mark.parametrize("policy", ["free", "reserve", *YIELDING])
def test_a_robot_beside_a_lane_waits_there_until_a_door_is_open(policy):
    """In the middle of the lane it would be in the way of others."""
    door = {"gate": {"at": [[10, -1], [10, 1]], "opening_time": 8}}
    run = fleet(policy, {**LINE, "doors": door, "lanes": [["a", "b"], ["b", "d"]]}, {"one": [9, 2]})
    log = run((0.0, go("one", 12, 0, A)), until=7.9)

    assert (9, 2) == run.simulator.robots["one"].pose().point
    assert (13.0, "SUCCEEDED") == end(run(until=20.0), A) == end(log, A)


@pytest.mark.parametrize("policy", ["reserve", *YIELDING])
def test_a_robot_does_not_leave_the_middle_of_a_lane_to_touch_another_one(policy):
    run = fleet(policy, LINE, {"one": [10, 0], "works": [12.5, 0]})
    run((0.0, wait(30, B, "works")), (1.0, go("one", 12, 0, A)), until=20.0)

    assert (10, 0) == run.simulator.robots["one"].pose().point

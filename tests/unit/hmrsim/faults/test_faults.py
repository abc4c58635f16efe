"""Faults as controllers see them."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, Read
from hmrsim.protocol.goal import GoalStatus, Refused
from hmrsim.protocol.outputs import GoalChanged, Sampled, StatusChanged
from hmrsim.protocol.time import Join
from hmrsim.protocol.topics import Topic
from hmrsim.robots.vehicle_state import VehicleState
from hmrsim.simulation.fault_injector import MOST_AT_ONCE
from hmrsim.trace.replay import replay
from tests.profiles import examples
from tests.simulation import SMALL_WORLD, A, B, C, go, in_lockstep, send, simulate, wait

LOST = "no connection to wall_e; it is lost for a while"


def pick(item, goal_id=A):
    return send("pickup", goal_id, target_name=item)


def maneuver(action, goal_id, goal, allowance):
    return send(action, goal_id, **goal, time_allowance={"sec": allowance})


def faulty(*faults, **keys):
    """Return a simulation of the small world with faults."""
    return simulate({**SMALL_WORLD, **keys, "faults": [*faults]})


def test_a_robot_that_breaks_down_aborts_its_goal():
    log = faulty({"type": "breakdown", "robot": "wall_e", "at": 2, "until": 5})((0.0, go(9, 2)))

    assert (2.0, "ABORTED") == log.changes(A)[-1]
    assert (9000, "wall_e has broken down at (3, 2)") == (log.result(A).error_code, log.result(A).error_msg)


def test_a_broken_robot_takes_no_goals_until_it_is_repaired():
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 2, "until": 5})
    log = run((0.0, go(9, 2)), (3.0, go(9, 2, B, reply_to="B")), (5.0, go(9, 2, C)))

    assert ("not_ready", "wall_e has broken down at (3, 2)") == (log.answer("B").reason, log.answer("B").error_msg)
    assert (11.0, "SUCCEEDED") == log.changes(C)[-1]


def test_a_broken_robot_waits():
    """Nav2's behavior server knows nothing of the base, so a wait also continues."""
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 2, "until": 5})
    log = run((1.0, wait(2)), (3.5, wait(1, B)))

    assert [(3.0, "SUCCEEDED"), (4.5, "SUCCEEDED")] == [log.changes(goal)[-1] for goal in (A, B)]


def test_a_robot_that_is_repaired_while_it_waits_continues_to_wait():
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 2, "until": 3})
    run((1.0, wait(9)), until=4.0)

    assert VehicleState.WORKING is run.simulator.robots["wall_e"].state


MANEUVERS = [
    ("spin", {"target_yaw": 1.5}, 701),
    ("back_up", {"target": {"x": 1.0}, "speed": 0.5}, 711),
    ("drive_on_heading", {"target": {"x": 1.0}, "speed": 0.5}, 721),
]
"""Each takes some seconds."""
SLOW_TO_TURN = {"nurse": {**SMALL_WORLD["robot_types"]["nurse"], "base": {"turning_rate": 0.5, "speed": 1}}}


@pytest.mark.parametrize(("action", "goal", "code"), MANEUVERS)
def test_a_maneuver_of_a_broken_robot_ends_with_its_time_allowance(action, goal, code):
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 1, "until": 30}, robot_types=SLOW_TO_TURN)
    log = run((0.0, maneuver(action, A, goal, 6)), (10.0, maneuver(action, B, goal, 6)))

    assert [(6.0, "ABORTED"), (16.0, "ABORTED")] == [log.changes(goal_id)[-1] for goal_id in (A, B)]
    assert [code] * 2 == [log.result(goal_id).error_code for goal_id in (A, B)]


@pytest.mark.parametrize(("action", "goal", "_code"), MANEUVERS)
def test_a_maneuver_is_finished_after_the_repair(action, goal, _code):
    whole = faulty(robot_types=SLOW_TO_TURN)((0.0, maneuver(action, A, goal, 20)))
    broken = faulty({"type": "breakdown", "robot": "wall_e", "at": 1, "until": 8}, robot_types=SLOW_TO_TURN)
    log = broken((0.0, maneuver(action, A, goal, 20)))
    (begun, _), (ended, status) = whole.changes(A)[-2:]

    assert (pytest.approx(ended - begun + 7.0), status) == (log.changes(A)[-1][0], log.changes(A)[-1][1])


@pytest.mark.parametrize("allowance", [0, 20])
@pytest.mark.parametrize(
    ("repaired_at", "lost"),
    [([1.0], 0.0), ([1.0, 1.0], 0.0), ([3.0, 3.0, 5.0], 4.0)],
    ids=["at once", "twice at once", "for no time between"],
)
@pytest.mark.parametrize(("action", "goal", "_code"), MANEUVERS)
def test_a_maneuver_is_finished_whenever_the_repair_comes(action, goal, _code, repaired_at, lost, allowance):
    """The robot may be repaired and break down again before its behavior server notices."""
    whole = faulty(robot_types=SLOW_TO_TURN)((0.0, maneuver(action, A, goal, 20)))
    run = faulty(robot_types=SLOW_TO_TURN)
    run.simulator.submit(maneuver(action, A, goal, allowance))
    run.simulator.run(1.0)
    for time in repaired_at:
        run.simulator.robots["wall_e"].disable("breakdown", "wall_e has broken down")
        if time > run.simulator.now:
            run.simulator.run(time)
        run.simulator.robots["wall_e"].enable("breakdown")
    run.simulator.run()
    (begun, _), (ended, status) = whole.changes(A)[-2:]

    assert (pytest.approx(ended - begun + lost), status) == run.log.changes(A)[-1]


def test_a_maneuver_without_an_allowance_lasts_until_it_is_canceled():
    """The robot may be broken for good."""
    run = faulty({"type": "breakdown", "robot": "wall_e"})
    log = run((0.0, maneuver("spin", A, {"target_yaw": 1.5}, 0)), (500.0, CancelGoal("wall_e", "spin", A)))

    assert (500.0, "CANCELED") == log.changes(A)[-1]


def test_a_broken_robot_with_an_empty_battery_does_not_wait():
    battery = {"initial_charge": 3, "capacity": 100, "drain": {"default": 1}}
    kind = {**SMALL_WORLD["robot_types"]["nurse"], "components": {"battery": battery}}
    run = faulty({"type": "breakdown", "robot": "wall_e"}, robot_types={"nurse": kind})
    log = run((0.0, wait(9)), (4.0, wait(1, B, reply_to="B")))

    assert ((3.0, "ABORTED"), "not_ready") == (log.changes(A)[-1], log.answer("B").reason)


def test_a_broken_robot_is_in_the_way():
    log = faulty({"type": "breakdown", "robot": "wall_e", "at": 2, "until": 5})((0.0, go(9, 2)), until=6.0)

    assert [(2.0, ["door", "home"]), (2.0, ["home", "door"])] == [
        (time, fields["lane"]) for time, fields in log.happened("lane_closed")
    ]
    assert [5.0, 5.0] == [time for time, _ in log.happened("lane_opened")]


def test_a_robot_that_broke_down_twice_is_repaired_twice():
    run = faulty(
        {"type": "breakdown", "robot": "wall_e", "until": 2},
        {"type": "breakdown", "robot": "wall_e", "at": 1, "until": 4},
    )
    unfit = []
    for time in (1.5, 3.0, 5.0):
        run.simulator.advance(time)
        unfit.append(bool(run.simulator.robots["wall_e"].disabled))

    assert [True, True, False] == unfit


def test_tags_name_the_fault_and_the_obstacle():
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 2})
    run((0.0, go(9, 2)), until=3.0)

    assert ["robot", "nurse", "claw", "breakdown", "blocking"] == run.ask(
        "get_entity_info", {"entity": "wall_e"}
    ).info.tags


def test_other_robots_drive_around_a_broken_robot():
    around = {
        "waypoints": {"a": [0, 0], "b": [4, 0], "c": [8, 0], "d": [4, 3]},
        "lanes": [["a", "b"], ["b", "c"], ["a", "d"], ["d", "c"]],
        "walls": [],
        "robots": {"wall_e": {"at": "b"}, "eve": {"at": "c"}},
        "items": {},
        "remap": {},
    }
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 2}, **around)
    log = run((0.0, go(8, 0)), (3.0, go(0, 0, B, "eve")))

    assert (13.0, "SUCCEEDED") == log.changes(B)[-1]


@pytest.mark.parametrize(
    ("service", "request_"),
    [
        ("set_entity_state", {"entity": "wall_e", "state": {"pose": {"position": {"x": 2.0, "y": 8.0}}}}),
        ("delete_entity", {"entity": "wall_e"}),
    ],
)
def test_a_broken_robot_that_is_moved_or_deleted_opens_its_lane(service, request_):
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 2})
    run((0.0, go(9, 2)), until=3.0)
    run.ask(service, request_)

    assert frozenset() == run.simulator.graph.closed


@pytest.mark.parametrize(
    ("at", "until", "end"), [(2, 4, 9.0), (4, 6, 9.0), (0, None, 16.0), (8, None, 8.0), (2, 4.5, 9.25)]
)
def test_a_robot_that_slips_is_slower(at, until, end):
    ends = {} if until is None else {"until": until}
    log = faulty({"type": "slip", "robot": "wall_e", "factor": 0.5, "at": at, **ends})((0.0, go(9, 2)))

    assert (end, "SUCCEEDED") == log.changes(A)[-1]


def test_simultaneous_slips_multiply():
    slip = {"type": "slip", "robot": "wall_e", "factor": 0.5}
    run = faulty({**slip, "at": 1, "until": 4}, {**slip, "at": 2, "until": 3})
    speeds = []
    for time in (0.5, 1.5, 2.5, 3.5, 4.5):
        run.simulator.advance(time)
        speeds.append(run.simulator.robots["wall_e"].speed)

    assert [1.0, 0.5, 0.25, 0.5, 1.0] == speeds


def test_no_route_uses_a_closed_lane():
    log = faulty({"type": "lane_closed", "lane": ["shelf", "door"], "at": 1, "until": 9, "name": "wet"})(
        (2.0, go(9, 2))
    )

    assert "shelf-door is closed (wet)" in log.result(A).error_msg
    assert 208 == log.result(A).error_code


def test_a_lane_closed_twice_opens_after_both_faults():
    lane = {"type": "lane_closed", "lane": ["shelf", "door"]}
    log = faulty({**lane, "until": 3}, {**lane, "until": 9})((0.0, go(9, 2)))

    assert {9.0} == {time for time, _ in log.happened("lane_opened")}


def test_a_driving_robot_waits_until_the_lane_opens():
    log = faulty({"type": "lane_closed", "lane": ["door", "shelf"], "at": 1, "until": 9})((0.0, go(9, 2)))

    assert (13.0, "SUCCEEDED") == log.changes(A)[-1]


def test_a_dropped_item_blocks_the_lane():
    """Placing the item fails, and the lane is closed until it is picked up."""
    run = faulty({"type": "claw_drops", "robot": "wall_e", "at": 2})
    log = run((0.0, pick("letter")), (0.0, go(9, 2, B)), until=3.0)
    closed = run.simulator.graph.closed
    place = send("place", "d" * 32, attached_object_name="letter")
    run((10.0, place), (10.0, go(3, 2, C)), until=17.0)
    run((17.0, pick("letter", "e" * 32)))

    assert [(2.0, {"robot": "wall_e", "item": "letter", "at": [3.0, 2.0]})] == log.happened("dropped")
    assert {("home", "door"), ("door", "home")} == set(closed)
    assert -19 == log.result("d" * 32).error_code.val
    assert (1, frozenset()) == (log.result("e" * 32).error_code.val, run.simulator.graph.closed)


def test_a_claw_that_misses_fails_with_moveits_code():
    log = faulty({"type": "claw_misses", "robot": "wall_e", "until": 2})(
        (1.0, pick("letter")), (3.0, pick("letter", B))
    )

    assert (-4, "the claw has missed 'letter'") == (log.result(A).error_code.val, log.result(A).error_code.message)
    assert 1 == log.result(B).error_code.val


def test_a_probability_is_the_frequency_of_failures():
    run = faulty({"type": "claw_misses", "robot": "wall_e", "probability": 0.3})
    run.simulator.advance(1.0)
    (misses,) = run.simulator.robots["wall_e"].components["claw"].misses

    assert 3000 == pytest.approx(sum(misses() for _ in range(10_000)), abs=100)


def test_a_bulky_item_blocks_its_lane():
    box = {"box": {"at": [3, 2], "blocks": True}}
    run = simulate({**SMALL_WORLD, "items": box})
    before = run.simulator.graph.closed
    run.ask("set_entity_state", {"entity": "box", "state": {"pose": {"position": {"x": 7.0, "y": 2.0}}}})
    after = run.simulator.graph.closed

    assert {("home", "door"), ("door", "home")} == set(before)
    assert {("door", "shelf"), ("shelf", "door")} == set(after)


def test_blind_sensors_see_nothing():
    sensors = {"components": {"camera": {}, "proximity": {}}}
    world = {**SMALL_WORLD, "robots": {"wall_e": {"at": "home", **sensors}}, "remap": {}}
    blind = {"type": "sensor_blind", "robot": "wall_e"}
    run = simulate({**world, "faults": [{**blind, "sensor": "camera", "until": 3}, {**blind, "at": 1, "until": 2}]})
    by = []
    for time in (0.5, 1.5, 2.5, 3.5):
        run.simulator.advance(time)
        by.append(run.ask("is_detected", {"robot": "wall_e", "entity": "letter"}).by)

    assert [["proximity"], [], ["proximity"], ["proximity"]] == by


def test_a_localization_jump_shows_in_odometry_and_feedback():
    run = faulty({"type": "localisation_jump", "robot": "wall_e", "dx": 0.5, "yaw": 1.0, "at": 2, "until": 4})
    log = run((0.0, go(9, 2)))
    odom = {
        time: event.message.pose.pose.position.x
        for time, event in log.events
        if isinstance(event, Sampled) and event.topic is Topic.ODOM and event.robot == "wall_e"
    }
    reported = {time: feedback.current_pose.pose.position.x for time, feedback in log.feedback(A)}

    assert (2.0, 4.5, 6.0) == pytest.approx((odom[1.0], odom[3.0], odom[5.0]))
    assert (2.0, 4.5, 6.0) == pytest.approx((reported[1.0], reported[3.0], reported[5.0]))
    assert (8.0, "SUCCEEDED") == log.changes(A)[-1]


def test_entities_have_the_true_pose_of_a_lost_robot():
    run = faulty({"type": "localisation_jump", "robot": "wall_e", "dx": 0.5, "at": 2})
    run.simulator.advance(3.0)

    assert 1.0 == run.ask("get_entity_state", {"entity": "wall_e"}).state.pose.position.x


def test_detections_of_a_lost_robot_have_its_error():
    """A thing 1 m ahead appears 1 m ahead of where the robot believes to be."""
    eye = {"at": [1, 2], "components": {"camera": {}}}
    world = {**SMALL_WORLD, "robots": {"wall_e": eye}, "items": {"cup": {"at": [2, 2]}}, "remap": {}}
    run = simulate({**world, "faults": [{"type": "localisation_jump", "robot": "wall_e", "dx": 3.0, "yaw": 1.5707963}]})
    run.simulator.advance(1.0)
    position = run.ask("is_detected", {"robot": "wall_e", "entity": "cup"}).pose.pose.position

    assert (4.0, 3.0) == pytest.approx((position.x, position.y), abs=1e-6)


@pytest.fixture
def cut():
    return faulty({"type": "messages_lost", "robot": "wall_e", "at": 2, "until": 10})


def test_a_goal_can_not_reach_a_robot_without_connection(cut):
    log = cut((3.0, go(9, 2, reply_to="asked")))

    answer = log.answer("asked")
    assert (False, "not_ready", LOST) == (answer.accepted, answer.reason, answer.error_msg)


@pytest.mark.parametrize(
    "command", [CancelGoal("wall_e", "wait", reply_to="asked"), Read(Topic.ODOM, "wall_e", reply_to="asked")]
)
def test_a_disconnected_robot_answers_no_request(cut, command):
    assert Refused("robot", "wall_e", LOST) == cut((3.0, command)).answer("asked")


def test_a_disconnected_robot_continues_its_goal(cut):
    log = cut((0.0, go(9, 2)), (1.0, GetResult("wall_e", "navigate_to_pose", A, "early")))
    cut((9.0, GetResult("wall_e", "navigate_to_pose", A, "late")))
    answered = {event.reply_to: time for time, event in log.events if getattr(event, "reply_to", None)}

    assert (8.0, "SUCCEEDED") == log.changes(A)[-1]
    assert (GoalStatus.SUCCEEDED, GoalStatus.SUCCEEDED) == (log.answer("early").status, log.answer("late").status)
    assert {A: 0.0, "early": 10.0, "late": 10.0} == answered


def test_a_disconnected_robot_publishes_nothing(cut):
    """After the fault its status is published again."""
    log = cut((0.0, go(9, 2)), until=11.0)
    reported = [
        time
        for time, event in log.events
        if isinstance(event, Sampled | StatusChanged) and event.robot == "wall_e" and 2.0 < time <= 10.0
    ]

    assert [10.0, 10.0] == reported


@pytest.mark.parametrize(
    "end", [lambda run: run.simulator.stop(), lambda run: run.ask("delete_entity", {"entity": "wall_e"})]
)
def test_a_waiting_client_is_answered_at_the_end_of_the_simulation_or_robot(cut, end):
    log = cut((0.0, go(9, 2)), (1.0, GetResult("wall_e", "navigate_to_pose", A, "asked")), until=3.0)
    end(cut)

    assert GoalStatus.ABORTED == log.answer("asked").status


def test_lockstep_continues_until_the_connection_is_back():
    lost = {"type": "messages_lost", "robot": "wall_e", "at": 2, "until": 10}
    cut, lockstep = in_lockstep({**SMALL_WORLD, "faults": [lost]})
    lockstep.join(Join("nurse", "joined"), 0.0)
    result = frozenset({"result"})
    lockstep.advance(Advance("nurse", 0, math.inf, result, frozenset(), (go(9, 2),), "granted"), 0.0)
    lockstep.begin()
    while lockstep.proceed(16, 0.0):
        pass
    granted = cut.log.answer("granted")

    assert (10.0, [("result", A)]) == (granted.now, [(kind, event.goal_id) for kind, _, event in granted.events])


def test_a_connection_lost_twice_is_back_after_both_faults(cut):
    cut.ask("inject_fault", {"type": "messages_lost", "robot": "wall_e", "at": 3.0, "until": 12.0})
    lost = []
    for time in (2.5, 11.0, 12.5):
        cut.simulator.advance(time)
        lost.append("wall_e" in cut.simulator.dispatcher.cut_off)

    assert [True, True, False] == lost


def test_a_disconnected_robot_continues_its_script():
    robots = {"wall_e": {"type": "nurse", "at": "home", "script": ["Go shelf", "Go home"]}}
    run = faulty({"type": "messages_lost", "robot": "wall_e", "at": 2}, robots=robots, remap={})
    run()

    assert 16.0 == run.simulator.scripts.all["wall_e"].ended
    assert "done" == run.simulator.scripts.all["wall_e"].state.value


def test_a_jammed_door_lets_no_robot_through():
    world = {**SMALL_WORLD, "doors": {"gate": {"at": [[7, 1], [7, 3]], "opening_time": 1.0}}}
    run = simulate({**world, "faults": [{"type": "door_jammed", "door": "gate", "at": 1, "until": 9}]})
    log = run((0.0, go(9, 2)))

    assert (14.0, "SUCCEEDED") == log.changes(A)[-1]


def test_a_battery_with_a_dead_cell_holds_less():
    robots = {"wall_e": {"at": "home", "components": {"battery": {"capacity": 400.0, "cells": 4}}}}
    run = faulty({"type": "battery_cell", "robot": "wall_e", "cell": 3, "at": 1, "until": 2}, robots=robots, remap={})
    usable = []
    for time in (0.5, 1.5, 2.5):
        run.simulator.advance(time)
        usable.append(run.simulator.robots["wall_e"].components["battery"].usable)

    assert [400.0, 300.0, 400.0] == usable


def spells(log, kind="fault_began"):
    return [(time, fields["name"]) for time, fields in log.happened(kind)]


def test_a_simulation_waits_for_the_end_but_not_the_beginning_of_a_fault():
    run = faulty(
        {"type": "slip", "robot": "wall_e", "factor": 0.5, "at": 1, "until": 7},
        {"type": "slip", "robot": "eve", "factor": 0.5, "at": 8},
    )
    log = run((0.0, wait(2)))

    assert [(1.0, "slip_1")] == spells(log)
    assert 7.0 == run.simulator.now


def test_random_faults_recur_with_the_given_means():
    """Draws depend on the seed, subject and kind."""
    fault = {"type": "slip", "robot": "wall_e", "factor": 0.5, "mean_time_between": 10.0, "mean_duration": 5.0}
    log = faulty(fault, seed=7)(until=400.0)
    chance = random.Random("7/wall_e/slip/1")
    now, expected = 0.0, []
    while (now := now + chance.expovariate(0.1)) < 400.0:
        expected.append(now)
        now += chance.expovariate(0.2)

    assert 15 < len(expected) < 40
    assert expected == pytest.approx([time for time, _ in log.happened("fault_began")])


def test_random_faults_of_one_robot_do_not_depend_on_others():
    fault = {"type": "breakdown", "mean_time_between": 5.0, "mean_duration": 2.0}
    more = {**SMALL_WORLD["robots"], "bob": {"type": "nurse", "at": [3, 9]}}
    alone = faulty({**fault, "robot": "wall_e"})
    crowd = faulty({**fault, "robot": "bob"}, {**fault, "robot": "wall_e"}, robots=more)

    def story(run):
        log = run((0.0, go(9, 2)), (9.0, go(1, 2, B)), (19.0, go(9, 2, C)), until=40.0)
        goals = [(time, event) for time, event in log.events if isinstance(event, GoalChanged)]
        faults = [
            (time, kind)
            for kind in ("fault_began", "fault_ended")
            for time, fields in log.happened(kind)
            if fields["robot"] == "wall_e"
        ]
        return goals, faults

    assert story(alone) == story(crowd)


def test_a_fault_of_a_missing_robot_is_missed():
    run = faulty({"type": "breakdown", "robot": "eve", "at": 2})
    run.ask("delete_entity", {"entity": "eve"})
    log = run(until=3.0)

    ((time, fields),) = log.happened("fault_missed")
    assert (2.0, "no robot 'eve'; there are cart, wall_e") == (time, fields["why"])


def test_a_reset_restarts_the_schedule():
    run = faulty({"type": "slip", "robot": "wall_e", "factor": 0.5, "mean_time_between": 10.0, "mean_duration": 5.0})
    first = spells(run(until=30.0))
    run.ask("reset_simulation")
    both = spells(run(until=30.0))

    assert first
    assert first + first == both


def test_loading_a_world_replaces_its_faults():
    run = faulty({"type": "breakdown", "robot": "wall_e", "at": 1})
    run.simulator.advance(2.0)
    run.ask("load_world", {"uri": "scenario1"})

    assert [] == run.ask("get_faults").faults


def test_a_fault_is_injected_with_the_keys_of_a_world_file():
    run = faulty()
    run.simulator.advance(1.0)
    names = [
        run.ask("inject_fault", {"type": "lane_closed", "lane": ["home", "door"], "until": 3.0}).name,
        run.ask("inject_fault", {"type": "slip", "robot": "eve", "factor": 0.5, "at": 2.0, "name": "oil"}).name,
    ]
    log = run(until=4.0)

    assert ["lane_closed_1", "oil"] == names
    assert [(1.0, "lane_closed_1"), (2.0, "oil")] == spells(log)
    assert [(3.0, "lane_closed_1")] == spells(log, "fault_ended")


@pytest.mark.parametrize(
    ("request_", "code", "why"),
    [
        ({}, 2, "type: no fault type ''; there are "),
        ({"type": "slipp"}, 2, "type: no fault type 'slipp'; did you mean 'slip'?"),
        ({"type": "slip", "robot": "wall_e"}, 4, "factor: is missing"),
        ({"type": "slip", "robot": "wally", "factor": 0.5}, 2, "robot: no robot 'wally'; did you mean 'wall_e'?"),
        ({"type": "slip", "robot": "wall_e", "factor": 2.0}, 4, "factor: must be at most 1, got 2.0"),
        ({"type": "lane_closed", "lane": ["home", "shelf"]}, 2, "lane: no lane 'home-shelf'; "),
        ({"type": "lane_closed", "lane": ["home"]}, 4, "lane"),
        ({"type": "claw_drops", "robot": "cart"}, 4, "robot: cart has no claw; there are none"),
        ({"type": "claw_drops", "robot": "eve", "until": 5.0}, 4, "until: unknown key 'until'"),
        ({"type": "breakdown", "robot": "eve", "until": 0.5}, 4, "until: 0.5 s is over; it is 1 s now"),
        ({"type": "breakdown", "robot": "eve", "until": 5.0, "duration": 1.0}, 4, "until and duration are both given"),
        ({"type": "breakdown", "settings": "[1]"}, 4, "settings: expected the text of a JSON object, got '[1]'"),
    ],
)
def test_invalid_faults_are_not_injected(request_, code, why):
    run = faulty()
    run.simulator.advance(1.0)
    answer = run.ask("inject_fault", request_)

    assert (code, "", []) == (answer.result.result, answer.name, run.ask("get_faults").faults)
    assert why in answer.result.error_message


def test_a_name_in_use_is_rejected():
    run = faulty()
    run.ask("inject_fault", {"type": "breakdown", "robot": "eve", "name": "ouch"})
    answer = run.ask("inject_fault", {"type": "breakdown", "robot": "cart", "name": "ouch"})

    assert "name: there is a fault 'ouch' already; give another name" == answer.result.error_message


def test_a_generated_name_has_the_first_free_number():
    run = faulty({"type": "breakdown", "robot": "eve", "name": "breakdown_2", "at": 100})

    def inject():
        return run.ask("inject_fault", {"type": "breakdown", "robot": "cart", "at": 50.0}).name

    names = [inject() for _ in range(3)]
    run.ask("clear_fault", {"name": "breakdown_1"})

    assert ["breakdown_1", "breakdown_3", "breakdown_4"] == names
    assert ["breakdown_1", "breakdown_5"] == [inject(), inject()]


def test_a_scheduled_fault_can_be_cleared():
    run = faulty({"type": "breakdown", "robot": "eve", "at": 5}, {"type": "breakdown", "robot": "cart"})
    run.simulator.advance(1.0)
    cleared = run.ask("clear_fault", {"type": "breakdown"}).names
    log = run(until=6.0)

    assert (["breakdown_1", "breakdown_2"], [(0.0, "breakdown_2")]) == (cleared, spells(log))
    assert [(1.0, "breakdown_2")] == spells(log, "fault_ended")


def test_clearing_an_unknown_fault_lists_the_faults():
    answer = faulty({"type": "breakdown", "robot": "eve", "name": "ouch"}).ask("clear_fault", {"name": "auch"})

    assert 2 == answer.result.result
    assert "name: no fault 'auch' goes on or is to come; did you mean 'ouch'?" == answer.result.error_message


def test_a_replay_has_the_same_faults():
    """The faults come from the file, from chance and from clients."""
    robots = {**SMALL_WORLD["robots"], "cart": {"at": "door", "script": ["Go 9 2", "Go 5 2", "Go 9 2"]}}
    faults = [
        {"type": "breakdown", "robot": "eve", "mean_time_between": 3.0, "mean_duration": 2.0},
        {"type": "messages_lost", "robot": "wall_e", "at": 2, "until": 6},
    ]
    run = simulate({**SMALL_WORLD, "robots": robots, "faults": faults}, traced=True)
    run((0.0, go(9, 2)), (3.0, go(1, 2, B)), until=4.0)
    run.ask("inject_fault", {"type": "slip", "robot": "cart", "factor": 0.5, "duration": 3.0})
    run((7.0, go(1, 2, C)))
    outcome = replay(run.lines())

    assert (True, None) == (outcome.complete, outcome.difference)
    assert {"breakdown", "messages_lost", "slip"} == {fields["fault"] for _, fields in run.log.happened("fault_began")}


TIMES = st.sampled_from([0.0, 1.0, 2.0, 4.0, 8.0, 3.3])
SPELLS = st.one_of(
    st.builds(lambda at, duration: {"at": at, "duration": duration}, TIMES, TIMES.filter(bool)),
    st.builds(lambda mean: {"mean_time_between": mean, "mean_duration": mean}, TIMES.filter(bool)),
)
ROBOTS = st.sampled_from(["wall_e", "eve"])
HAPPENING = {
    "breakdown": st.just({}),
    "slip": st.just({"factor": 0.5}),
    "claw_misses": st.just({"probability": 0.5}),
    "messages_lost": st.just({}),
    "localisation_jump": st.just({"dx": 1.0}),
    "goals_rejected": st.sampled_from([{}, {"count": 2}]),
    "goals_aborted": st.sampled_from([{}, {"delay": 1.5, "count": 2}, {"delay": 2.0, "count": None}]),
    "result_late": st.sampled_from([{"delay": 1.0}, {"delay": 7.0}, {"delay": 500.0}]),
}
FAULTS = st.sampled_from(sorted(HAPPENING)).flatmap(
    lambda kind: st.builds(
        lambda robot, said, spell: {"type": kind, "robot": robot, **said, **spell}, ROBOTS, HAPPENING[kind], SPELLS
    )
)
CLOSED = st.builds(lambda spell: {"type": "lane_closed", "lane": ["home", "door"], **spell}, SPELLS)
GOALS = st.lists(st.tuples(ROBOTS, st.sampled_from([1.0, 5.0, 9.0])), min_size=1, max_size=6)


@examples(60)
@given(st.lists(FAULTS | CLOSED, max_size=6), GOALS, st.sampled_from(["free", "reserve", "priority"]))
def test_under_any_faults_each_goal_ends_and_is_answered_once(happening, goals, policy):
    world = {**SMALL_WORLD, "traffic": {"policy": policy, "patience": 20.0}, "faults": happening}
    run = simulate(world, topics=frozenset({Topic.EVENTS}))
    sent = []
    for number, (robot, x) in enumerate(goals, 1):
        run.simulator.advance(2.0 * number)
        goal_id = f"{number:032x}"
        run.simulator.submit(go(x, 2, goal_id, robot, reply_to=("sent", number)))
        if run.log.answer(("sent", number)).accepted:
            sent.append(goal_id)
            run.simulator.submit(GetResult(robot, "navigate_to_pose", goal_id, goal_id))
    run.simulator.advance(80.0)
    run.ask("clear_fault")

    simulator = run.simulator
    assert [1] * len(sent) == [len(run.log.answers(goal_id)) for goal_id in sent]
    assert [1] * len(sent) == [
        sum(status in ("SUCCEEDED", "ABORTED", "CANCELED") for _, status in run.log.changes(goal_id))
        for goal_id in sent
    ]
    assert (frozenset(), set()) == (simulator.graph.closed, simulator.dispatcher.cut_off)
    assert {("", 1.0)} == {(robot.disabled, robot.speed) for robot in simulator.robots.values()}


def test_faults_of_a_kind_on_one_robot_are_limited():
    """The effect of each depends on the others, so thousands at one instant would block all clients."""
    slips = [{"type": "slip", "robot": "wall_e", "factor": 0.99, "at": 2, "until": 5}] * (MOST_AT_ONCE + 20)
    run = faulty(*slips)
    log = run(until=3.0)
    reported = [len(log.happened(kind)) for kind in ("fault_began", "fault_missed")]
    refused = run.ask("inject_fault", {"type": "slip", "settings": '{"robot": "wall_e", "factor": 0.5}'})
    other = run.ask("inject_fault", {"type": "slip", "settings": '{"robot": "cart", "factor": 0.5}'})

    assert [MOST_AT_ONCE, 20] == reported
    assert "100 faults of type 'slip' are active on 'wall_e'" in refused.result.error_message
    assert 1 == other.result.result
    assert MOST_AT_ONCE == len(run(until=6.0).happened("fault_ended"))

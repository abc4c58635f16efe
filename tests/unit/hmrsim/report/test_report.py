"""Reports of small worlds, with numbers that can be computed by hand."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.report import of_trace, report_of
from tests.profiles import examples
from tests.unit.hmrsim.report.worlds import ALONE, CHARGING, FAULTY, MEETING, OPENED, goal_to, traced


def test_distance_is_the_driven_one(report):
    (robot,) = report(ALONE).robots

    assert 8.0 == robot.distance


def test_time_is_shared_between_states(report):
    """4 s of driving, 2 s of waiting by a goal, and 4 s of driving."""
    (robot,) = report(ALONE).robots

    assert {"driving": 8.0, "busy": 2.0} == {state: time for state, time in robot.seconds.items() if time}
    assert {"driving": 0.8, "busy": 0.2} == {state: share for state, share in robot.share.items() if share}


def test_the_spans_of_a_robots_states_are_contiguous(report):
    spans = [(span.state, span.began, span.ended) for span in report(ALONE).states]

    assert [("driving", 0.0, 4.0), ("busy", 4.0, 6.0), ("driving", 6.0, 10.0)] == spans


def test_each_goal_is_one_entry(report):
    goals = [(goal.action, goal.accepted, goal.ended, goal.distance, goal.target) for goal in report(ALONE).goals]

    assert [
        ("navigate_to_pose", 0.0, 4.0, 4.0, "(4, 0)"),
        ("wait", 4.0, 6.0, 0.0, "2 s"),
        ("navigate_to_pose", 6.0, 10.0, 4.0, "(0, 0)"),
    ] == goals


def test_a_wait_has_its_cause_and_duration(report):
    """The second robot waits until the first one has left the crossing."""
    found = report(MEETING)

    assert [("late", ("early",), 1.0, "went_on")] == [(w.robot, w.robots, w.duration, w.until) for w in found.waits]
    assert {"early": 1.0} == {r.name: r.waited_for for r in found.robots}["late"]
    assert 1.0 == sum(goal.waited for goal in found.goals)


def test_a_wait_is_divided_among_its_causes(report):
    """First a door and then a robot: it counts as one wait of the robot, its goal and the lane."""
    found = report(OPENED)
    late = next(robot for robot in found.robots if robot.name == "late")
    goal = next(goal for goal in found.goals if goal.robot == "late")
    lane = next(lane for lane in found.lanes if (lane.begin, lane.end) == ("west", "middle"))

    causes = [(wait.why, wait.robots, wait.duration, wait.until) for wait in found.waits]
    assert [("gate is opening", (), 1.0, "waiting"), ("", ("early",), 1.0, "went_on")] == causes
    assert [1, 1, 1, 1] == [found.summary.waits, late.waits, goal.waits, lane.waits]
    assert 2.0 == late.waited == goal.waited == lane.waited


def test_lanes_count_drives_and_waits_by_direction(report):
    lanes = {(lane.begin, lane.end): (lane.drives, lane.distance, lane.seconds) for lane in report(ALONE).lanes}

    assert {("home", "door"): (1, 4.0, 4.0), ("door", "home"): (1, 4.0, 4.0)} == lanes


def test_energy_is_what_the_batteries_lost_and_gained(report):
    """12 s at 2 W out of 100 J, then 10 W of the charger until the battery is full."""
    (robot,) = report(CHARGING).robots

    assert (24.0, 24.0, 1.0) == (robot.energy_used, robot.energy_charged, robot.battery)
    assert 0.76 == robot.lowest_battery


def test_the_use_of_docks_is_counted(report):
    (dock,) = [fixture for fixture in report(CHARGING).fixtures if fixture.kind == "dock"]

    assert ("charger", 1, 1, 0) == (dock.name, dock.uses, dock.robots, dock.waits)


def test_a_canceled_goal_has_the_distance_until_its_cancel(report, send, cancel):
    found = report(
        ALONE | {"robots": {"wall_e": {"type": "cart", "at": "home"}}},
        commands=[
            (0.0, send("wall_e", "navigate_to_pose", goal_to(4, 0), "a" * 32)),
            (1.5, cancel("wall_e", "navigate_to_pose", "a" * 32)),
        ],
        until=3.0,
    )
    (goal,), (robot,) = found.goals, found.robots

    assert ("CANCELED", 1.5, 1.5) == (goal.status, goal.ended, goal.distance)
    assert {"driving": 1.5, "idle": 1.5} == {state: time for state, time in robot.seconds.items() if time}


def test_a_running_goal_has_a_distance_and_no_end(report, send):
    found = report(
        ALONE | {"robots": {"wall_e": {"type": "cart", "at": "home"}}},
        commands=[(0.0, send("wall_e", "navigate_to_pose", goal_to(4, 0)))],
        until=2.5,
    )
    (goal,) = found.goals

    assert ("EXECUTING", None, None, 2.5) == (goal.status, goal.ended, goal.duration, goal.distance)
    assert found.summary.success_rate is None


def test_distance_accounts_for_acceleration(report, send):
    """With 1 m/s² half a metre is driven in the first second."""
    world = ALONE | {
        "robot_types": {"cart": {"base": {"speed": 1, "acceleration": 1}}},
        "robots": {"wall_e": {"type": "cart", "at": "home"}},
    }
    found = report(world, commands=[(0.0, send("wall_e", "navigate_to_pose", goal_to(4, 0)))], until=1.0)

    assert 0.5 == found.robots[0].distance


def test_an_error_has_code_text_and_fault(report):
    (error, *_) = report(FAULTY).errors

    assert (2.0, "wall_e", "ABORTED", ("flat_tyre",)) == (error.at, error.robot, error.status, error.faults)
    assert "has broken down" in error.error_msg


def test_a_robot_that_has_broken_down_is_stopped(report):
    found = report(FAULTY, until=5.0)

    assert [("driving", 0.0, 2.0), ("stopped", 2.0, 5.0)] == [(s.state, s.began, s.ended) for s in found.states]
    assert [("flat_tyre", 2.0, None)] == [(f.name, f.began, f.ended) for f in found.faults]


def test_a_fault_of_a_fixture_names_it(report):
    """The event that starts the fault is not one of its settings."""
    anchor = {"goal": "executing", "action": "wait"}
    fault = {"type": "dock_out_of_order", "dock": "charger", "name": "no_power", "when": anchor}
    (span,) = report(CHARGING | {"faults": [fault]}).faults

    assert ("no_power", "charger", "", "") == (span.name, span.subject, span.robot, span.detail)


def test_rejected_goals_are_errors_with_their_reason(report, send):
    found = report(
        ALONE | {"robots": {"wall_e": {"type": "cart", "at": "home"}}},
        commands=[(1.0, send("nobody", "wait", {"time": {"sec": 1}}))],
        until=2.0,
    )

    assert [("nobody", "REJECTED", "unknown_robot")] == [(e.robot, e.status, e.error_name) for e in found.errors]
    assert (0, 1) == (len(found.goals), found.summary.rejected)


def test_throughput_counts_each_goal_once(report):
    """The buckets cover the whole time."""
    found = report(ALONE)

    assert 3 == sum(bucket.succeeded for bucket in found.throughput)
    assert (0.0, 10.0) == (found.throughput[0].began, found.throughput[-1].ended)


def test_a_trace_of_another_version_has_goals_and_waits_without_distances(trace, changed):
    lines = changed(trace(ALONE))
    found = report_of(of_trace(lambda: lines)[0])

    assert (False, None, 3) == (found.source.exact, found.summary.distance, len(found.goals))
    assert "It lacks distances" in found.source.notes[0]


def test_commands_of_a_trace_that_can_not_be_replayed_are_known(trace, changed, send):
    world = ALONE | {"robots": {"wall_e": {"type": "cart", "at": "home"}}}
    lines = changed(trace(world, commands=[(0.0, send("wall_e", "navigate_to_pose", goal_to(4, 0)))], until=5.0))
    (goal,) = report_of(of_trace(lambda: lines)[0]).goals

    assert ("(4, 0)", 4.0, 0.0) == (goal.target, goal.target_x, goal.target_y)


def test_waits_are_the_same_without_motions(report, trace, changed):
    lines = changed(trace(MEETING))
    found = report_of(of_trace(lambda: lines)[0])

    assert report(MEETING).waits[0].model_dump(exclude={"until"}) == found.waits[0].model_dump(exclude={"until"})


def test_a_truncated_trace_is_reported_exactly_and_marked(trace):
    lines = trace(ALONE)
    found = report_of(of_trace(lambda: [*lines[:4], lines[4][:20]])[0])

    assert (True, False) == (found.source.exact, found.source.complete)
    assert ("The trace is truncated: later events are missing.",) == found.source.notes


def test_the_same_trace_has_the_same_report(trace):
    lines = trace(MEETING)
    one, other = (report_of(of_trace(lambda: lines)[0]).model_dump_json() for _ in range(2))

    assert one == other


CROSSING = {
    "waypoints": {"west": [0, 0], "middle": [10, 0], "east": [20, 0], "bay": [10, 4]},
    "lanes": [["west", "middle"], ["middle", "east"], ["middle", "bay"]],
}


@pytest.mark.parametrize("exact", [True, False])
@examples(25)
@given(data=st.data())
def test_reports_are_consistent(data, exact):
    orders = st.lists(st.sampled_from(["Go west", "Go east", "Go middle", "Go bay", "Wait 1.5"]), max_size=5)
    robots = {
        name: {"at": at, "script": data.draw(orders)} for name, at in (("a", "west"), ("b", "east"), ("c", "bay"))
    }
    world = {
        **CROSSING,
        "robot_types": {
            "cart": {
                "base": {"speed": 1, "radius": 0.4, "acceleration": data.draw(st.sampled_from([0.0, 0.7])) or None}
            }
        },
        "robots": {name: robot | {"type": "cart"} for name, robot in robots.items()},
        "traffic": {"policy": data.draw(st.sampled_from(["free", "reserve", "priority"])), "patience": 20},
    }
    lines = traced(world)
    if not exact:
        lines = [lines[0].replace('"contract":1', '"contract":9'), *lines[1:]]
    found = report_of(of_trace(lambda: lines)[0])

    whole = found.summary.sim_time
    for robot in found.robots:
        spans = [(span.began, span.ended) for span in found.states if span.robot == robot.name]
        assert math.isclose(1.0, sum(robot.share.values()))
        assert math.isclose(whole, sum(robot.seconds.values()), abs_tol=1e-6)
        assert all(a[1] == b[0] for a, b in pairwise(spans))
        assert math.isclose(robot.waited, robot.seconds["waiting"], abs_tol=1e-6)
    accepted = {line.split('"goal_id":"')[1][:32] for line in lines if '"status":1}' in line}
    assert sorted(accepted) == sorted(goal.goal_id for goal in found.goals)
    assert 0 == sum(1 for note in found.source.notes if "events are ignored" in note)
    if exact:
        assert math.isclose(sum(lane.distance for lane in found.lanes), found.summary.distance, abs_tol=1e-6)


def test_a_robot_that_has_made_room_waits_for_the_other_one(report):
    """Its goal does not keep it busy where it stands aside."""
    world = {
        **CROSSING,
        "robot_types": {"cart": {"base": {"speed": 1, "radius": 0.4}}},
        "traffic": {"policy": "priority"},
        "robots": {
            "first": {"type": "cart", "at": "west", "script": ["Go east"]},
            "later": {"type": "cart", "at": "east", "script": ["Wait 1", "Go west"]},
        },
    }
    found = report(world)

    later = [span.state for span in found.states if span.robot == "later"]
    assert ["busy", "waiting"] == later[:2]
    assert "busy" not in later[1:]
    assert ("first",) in [wait.robots for wait in found.waits if wait.robot == "later"]


def test_a_robot_that_makes_room_in_a_queue_stays_in_it(report):
    """Queues stands at the crossing, which passes needs, and moves on to the bay."""
    world = {
        **CROSSING,
        "docks": {"charger": {"at": [20, 4], "staging": [20, 0], "type": "charger"}},
        "robot_types": {
            "cart": {"base": {"speed": 1, "radius": 0.4}, "components": {"battery": {"capacity": 100}}},
        },
        "traffic": {"policy": "priority"},
        "robots": {
            "docked": {"type": "cart", "at": "charger"},
            "queues": {"type": "cart", "at": "middle", "script": ["Dock charger"]},
            "passes": {"type": "cart", "at": "west", "script": ["Wait 5", "Go east"]},
        },
    }
    found = report(world)

    waits = [(wait.kind, wait.why) for wait in found.waits if wait.robot == "queues"]
    (robot,) = [robot for robot in found.robots if robot.name == "queues"]
    assert (1, [("dock", "charger")] * 2) == (found.events["made_room"], waits)
    assert robot.queued == found.summary.sim_time - 4.0

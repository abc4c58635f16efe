"""The output of ``hmrsim explain --robot``."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli.explain import (
    _after_error,
    _concerns,
    _end_of,
    _lines_about_robot,
    _lines_about_robots,
    _why_time_stands,
)
from hmrsim.cli.robot import last_error, waiting_orders
from hmrsim.testing import simulation
from hmrsim.traffic.causes import Link

STATE = {"now": 12.5, "paused": False, "waiting_for": (), "clock": "lockstep", "participants": ("nurse",)}
LINKS = [{"robot": "ann", "text": "ann has waited for bob"}, {"robot": "bob", "text": "bob is idle"}]


@pytest.mark.parametrize(
    ("changes", "told", "remedy"),
    [
        ({"paused": True}, "it is paused", "`hmrsim time resume`"),
        ({"waiting_for": ("nurse",)}, "lockstep waits for nurse", "look at nurse: "),
        ({"participants": ()}, "no controller takes part in lockstep", "start the controller"),
    ],
)
def test_time_that_stands_is_told_with_a_remedy(changes, told, remedy):
    stands, helps = _why_time_stands({**STATE, **changes})

    assert f"Simulated time stands at 12.5 s: {told}" == stands
    assert helps.startswith(remedy)


@pytest.mark.parametrize("changes", [{}, {"clock": "realtime", "participants": ()}])
def test_time_that_advances_is_not_told(changes):
    assert ("", "") == _why_time_stands({**STATE, **changes})


def test_each_cause_is_indented_below_the_one_before_it():
    found = {"time": "", "links": LINKS, "faults": [], "last_error": "", "orders": "", "help": "send bob elsewhere"}

    lines = ["ann has waited for bob", "  bob is idle", "", "What would help: send bob elsewhere"]
    assert lines == [*_lines_about_robot(found)]


def test_all_robots_that_wait_are_explained():
    found = {"time": "", "links": LINKS[1:], "faults": [], "last_error": "", "orders": "", "help": "send it"}
    lines = ["bob is idle", "", "What would help: send it"]

    assert [*lines, "", "", *lines] == [*_lines_about_robots([found, found], "", "")]
    assert ["no robot waits; `hmrsim robot list` shows what each one does"] == [*_lines_about_robots([], "", "")]
    assert ["it is paused; what would help: resume it"] == [*_lines_about_robots([], "it is paused", "resume it")]


def fault(**settings):
    since = {"sec": 20, "nanosec": 500_000_000}
    return {"name": "jam", "type": "door_jammed", "active": True, "since": since, "settings": json.dumps(settings)}


@pytest.mark.parametrize(
    ("settings", "end"),
    [
        ({"duration": 100.0}, "ends at 120.5 s."),
        ({"until": 300.0}, "ends at 300 s."),
        ({"mean_duration": 30.0}, "ends after a random time."),
        ({"duration": {"uniform": [1, 2]}}, "ends after a random time."),
        ({}, "has no end: `hmrsim fault clear jam` ends it."),
    ],
)
def test_the_end_of_a_fault_is_told(settings, end):
    assert f"The fault jam (door_jammed) {end}" == _end_of(fault(**settings))


def test_the_faults_of_what_a_robot_waits_for_are_told():
    door, lane = "eve waits at b: gate is jammed", "eve waits at b: a-b is closed (spill)"

    assert _concerns(fault(door="gate"), door)
    assert not _concerns(fault(door="gate_2"), door)
    assert _concerns(fault(lane=["b", "a"]), lane)
    assert _concerns(fault(robot="eve"), "eve is disabled")
    assert not _concerns({**fault(robot="eve"), "active": False}, "eve is disabled")


@pytest.mark.parametrize(
    ("ends", "remedy"),
    [
        ({}, "its controller has to handle this error"),
        ({"jam": "ends at 9 s."}, "wait until the fault ends, or end it: `hmrsim fault clear jam`"),
    ],
)
def test_a_robot_whose_goal_failed_because_of_a_fault_waits_for_its_end(ends, remedy):
    assert _after_error(ends).startswith(remedy)


def test_the_error_of_the_last_robot_is_told():
    found = {
        "time": "it stands",
        "links": LINKS,
        "faults": [],
        "last_error": "no route",
        "orders": "",
        "help": "handle it",
    }

    assert ["it stands", "  bob's last goal failed: no route"] == [*_lines_about_robot(found)][0:4:3]


def test_orders_that_wait_are_counted():
    order = {"item": "cup", "at": "counter", "to": "table_1", "arrives": 30, "count": 2, "name": "order"}
    with simulation("cafe", changes={"demand.+": order}) as run:
        assert "" == waiting_orders(run.client)
        run.client.sleep(75)

        told = "2 orders wait to be picked up; the oldest: order_1, from counter to table_1, for 45 s"
        assert told == waiting_orders(run.client)


@pytest.mark.parametrize(
    ("action", "status", "result", "error"),
    [
        ("navigate_to_pose", 6, {"error_code": 208, "error_msg": "no route"}, "no route"),
        ("navigate_to_pose", 4, {"error_msg": ""}, ""),
        ("pickup", 6, {"error_code": {"val": -1, "message": "out of reach"}}, "out of reach"),
        ("of_another_package", 6, {}, ""),
    ],
)
def test_the_last_error_is_that_of_the_last_goal(action, status, result, error):
    robot = {"goals": [{"action": action, "status": status, "result": result}]}

    assert error == last_error(robot, Link("ann", "idle", "ann is idle"))
    assert "" == last_error(robot, Link("ann", "drives", "ann is driving"))

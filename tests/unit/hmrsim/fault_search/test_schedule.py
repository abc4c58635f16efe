"""The injections of schedules: their descriptions and their flaws."""

from __future__ import annotations

import pytest

from hmrsim.fault_search.schedule import Injection, read_injections

GOAL = {"goal": "executing", "robot": "eve", "action": "pickup"}
GOAL_OF_EVE = {"robot": "eve", "action": "pickup"}


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"type": "breakdown", "robot": "eve", "duration": 20.0}, "breakdown of eve for 20 s"),
        (
            {"type": "claw_misses", "robot": "eve", "probability": 0.5, "when": {**GOAL, "nth": 2, "after": 0.5}},
            "claw_misses of eve (probability 0.5), 0.5 s after pickup of eve is executing (number 2)",
        ),
        (
            {"type": "goals_aborted", "count": 1, **GOAL_OF_EVE, "when": {**GOAL, "nth": 2}},
            "the 2nd pickup of eve is aborted",
        ),
        (
            {"type": "goals_aborted", "count": 3, "error_code": -7, **GOAL_OF_EVE, "when": {**GOAL, "nth": 11}},
            "3 times in a row a pickup of eve is aborted with code -7 (PREEMPTED), from the 11th on",
        ),
        (
            {"type": "goals_rejected", "count": 1, "robot": "eve", "action": "navigate_to_pose", "when": GOAL},
            "the next navigate_to_pose of eve is rejected, when pickup of eve is executing",
        ),
        ({"type": "lane_closed", "lane": ["a", "b"], "at": 3.0}, "lane_closed of a-b, at 3 s"),
        (
            {"type": "lane_closed", "lane": ["a", "b"], "when": {"event": "picked", "robot": "eve", "nth": 2}},
            "lane_closed of a-b, when eve picks up an item (event picked, number 2)",
        ),
        (
            {"type": "door_jammed", "door": "gate", "at": 0.0, "duration": 5.0},
            "door_jammed of gate for 5 s, from the start",
        ),
        ({"type": "goals_rejected", "count": 1, **GOAL_OF_EVE, "at": 0.0}, "the 1st pickup of eve is rejected"),
        (
            {"type": "slip", "robot": "eve", "when": {"event": "battery_low", "robot": "eve", "after": 2.0}},
            "slip of eve, 2 s after eve reports battery_low",
        ),
        (
            {"type": "battery_drop", "robot": "eve", "share": 0.25, "at": 0.0},
            "the battery of eve falls to 25%, from the start",
        ),
        ({"change": {"robots.eve.base.speed": 0.2}}, "robots.eve.base.speed = 0.2"),
        ({"change": {"~docks.charger": None}}, "docks.charger removed"),
        (
            {"disturbance": "controller_stalled", "duration": 5.0, "when": GOAL},
            "controller_stalled for 5 s, when pickup of eve is executing",
        ),
    ],
)
def test_describes_injections_in_words(spec, words):
    assert words == Injection(spec).describe()


def test_equal_injections_have_equal_keys():
    one, other = Injection({"type": "slip", "robot": "eve"}), Injection({"robot": "eve", "type": "slip"})

    assert one == other
    assert {one: 1}[other] == 1
    assert one != one.replaced(robot="wall_e")


def test_reports_all_flaws_of_injections():
    injections, findings = read_injections(
        [
            {"type": "breakdwn", "robot": "eve"},
            {"type": "slip", "robot": "eve", "factor": 0.5, "when": {"event": "pickd"}},
            {"disturbance": "controller_kiled", "when": GOAL},
            {"change": {}},
            {"robot": "eve"},
            "slip",
            {"type": "breakdown", "robot": "eve"},
        ]
    )
    told = [(".".join(map(str, finding.path)), finding.message) for finding in findings]

    assert len(injections) == 1
    assert told[0] == ("0.type", "no fault type 'breakdwn'; did you mean 'breakdown'?")
    assert told[1] == ("1.when.event", "there is no kind of event 'pickd'; did you mean 'picked'?")
    assert told[2][0] == "2.disturbance"
    assert [place for place, _ in told[3:]] == ["3.change", "4", "5"]


def test_schedule_has_to_be_a_list():
    assert [finding.message for finding in read_injections({"type": "slip"})[1]] == [
        "expected a list of faults, changes and disturbances, got a mapping"
    ]

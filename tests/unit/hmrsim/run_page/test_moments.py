"""The key moments of a run: those left out, merged and marked."""

from __future__ import annotations

from hmrsim.fault_search.failure_page import run_logged
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.run_page import ShownRun
from hmrsim.run_page.moments import moments_of
from tests.porters import WORLD, check_of
from tests.unit.hmrsim.run_page.conftest import BREAKDOWN

CART = {"at": "nook", "components": {"battery": {"capacity": 100}}}
DRAINED = Injection({"type": "battery_drop", "robot": "other", "share": 0.2, "at": 0.0})


def logged(function, schedule, **said):
    return run_logged(check_of(function, **said), Case(schedule), Wanted())[1]


def texts_of(kind, run):
    return [moment.text for moment in moments_of([], run, None, None) if moment.kind == kind]


def test_the_alarm_that_occurs_most_often_is_where_the_run_is_stuck():
    log = logged("vain", (BREAKDOWN,), properties={"built_in": {"no_vain_goals": 9}})
    (stuck,) = texts_of("stuck", ShownRun("", log, "", 10.0))

    assert stuck.startswith("porter pickup rejected (box): porter has broken down at store, ")
    assert stuck.endswith(" times")


def test_a_low_battery_is_shown_if_the_failure_is_about_its_robot():
    log = logged("careful", (DRAINED,), world={**WORLD, "robots": {**WORLD["robots"], "other": CART}})

    assert not texts_of("alarm", ShownRun("", log, "", 40.0, failure="porter is late"))
    assert "other has a low battery (20%)" in texts_of("alarm", ShownRun("", log, "", 40.0, failure="other is late"))


def test_violations_of_a_property_are_one_moment(failing):
    run = ShownRun("", failing[1], "", 9.0, [(1.0, "late: a"), (2.0, "lives"), (3.0, "late: b"), (4.0, "late: c")])

    assert ["late: a; 2 more until 4.000 s", "lives"] == texts_of("violated", run)


def test_a_goal_that_is_sent_again_is_shown_once_and_without_a_moment_that_shows_its_end():
    log = logged("tired", (BREAKDOWN,))
    goals = texts_of("goal", ShownRun("", log, "", 10.0))

    assert len({*goals}) == len(goals)
    assert not [text for text in goals if "ABORTED" in text]


def test_the_failure_on_which_the_controller_gave_up_has_its_cause_and_code():
    aborted = Injection({"type": "goals_aborted", "robot": "porter", "at": 0.0})
    log = logged("crashing", (aborted,))
    (silent,) = texts_of("silent", ShownRun("", log, "", 0.0))

    assert "after navigate_to_pose of porter ended as ABORTED (cause goals_aborted, error code 9000), " in silent


def test_a_run_that_is_stopped_between_two_attempts_has_not_given_up(failing):
    assert texts_of("silent", ShownRun("", failing[1], "", 10.0))
    assert not texts_of("silent", ShownRun("", failing[1], "", 10.0, stopped=True))

"""The first difference of two runs, and their key moments."""

from __future__ import annotations

import pytest

from hmrsim.events.simulation import Spawned
from hmrsim.fault_search.failure_page import run_logged
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.run_page import Cause, ShownRun
from hmrsim.run_page.comparison import first_difference
from hmrsim.run_page.moments import moments_of
from tests.porters import WORLD, check_of
from tests.unit.hmrsim.run_page.conftest import planted


def test_the_first_difference_is_no_fault_but_its_effect(failing, passing):
    difference = first_difference(failing[1], passing[1])

    assert difference is not None
    assert 10.0 == difference.at
    assert "porter pickup ABORTED (box): porter has broken down at store" == difference.texts[0]
    assert "porter picks up box" == difference.texts[1]
    assert all(
        log.lines[line].at == difference.at
        for log, line in zip((failing[1], passing[1]), difference.lines, strict=True)
    )


def test_a_later_event_in_its_place_has_its_time(passing):
    class Later:
        happenings = tuple(each._replace(at=each.at + 2_000_000_000) for each in passing[1].happenings)
        lines = passing[1].lines
        describe = passing[1].describe

    difference = first_difference(passing[1], Later())

    assert difference is not None
    assert difference.texts[1] == f"{difference.texts[0]}, at 2.000 s"
    assert (2, 1) == difference.seen


def test_a_run_does_not_differ_from_itself(failing):
    assert first_difference(failing[1], failing[1]) is None


def test_a_lane_that_a_fault_closes_is_no_difference_but_what_it_causes():
    closed = Injection({"type": "lane_closed", "lane": ["home", "store"], "at": 0.0, "duration": 30.0})
    check = check_of("careful")
    logs = [run_logged(check, Case(schedule), Wanted())[1] for schedule in ((closed,), ())]
    difference = first_difference(*logs)

    assert difference is not None
    assert difference.texts[0].startswith("porter navigate_to_pose ABORTED (store): no route from home to store")


def test_a_difference_is_about_one_robot():
    """The low battery has no event beside it, and the next one of that run is about another robot."""
    drained = Injection({"type": "battery_drop", "robot": "other", "share": 0.2, "at": 0.0})
    cart = {"at": "nook", "components": {"battery": {"capacity": 100}}}
    check = check_of("careful", world={**WORLD, "robots": {**WORLD["robots"], "other": cart}})
    logs = [run_logged(check, Case(schedule), Wanted())[1] for schedule in ((drained,), ())]
    difference = first_difference(*logs)

    assert difference is not None
    assert ("other has a low battery (20%)", "the battery of other is at 100 %") == difference.texts


def test_the_event_beside_a_difference_is_the_next_one_of_its_robot(passing):
    log = passing[1]
    first = next(each for each in log.happenings if each.event.subject == "porter")

    class Strange:
        happenings = (first._replace(at=0, event=Spawned("ghost", "item", (0.0, 0.0))), *log.happenings)
        lines = log.lines
        describe = log.describe

    difference = first_difference(Strange(), log)

    assert difference is not None
    assert "no further event of ghost" == difference.texts[1]


def test_a_run_that_ends_before_differs_by_that(passing):
    class Shorter:
        happenings = passing[1].happenings[:-1]
        lines = passing[1].lines[:-1]

    difference = first_difference(Shorter(), passing[1])

    assert difference is not None
    assert "no further event" == difference.texts[0]


def test_key_moments_are_the_causes_the_difference_and_what_went_wrong(failing, passing):
    outcome, log = failing
    run = ShownRun("Failing run", log, "ends", outcome.at, [(outcome.at, "no_vain_goals: in vain")])
    other = ShownRun("Without", passing[1], "ends", passing[0].at)
    moments = moments_of([Cause("breakdown", outcome.began[0])], run, other, first_difference(log, passing[1]))

    kinds = [moment.kind for moment in moments]
    assert ["goal", "cause", "difference", "alarm", "silent", "violated", "end"] == kinds
    assert sorted(moment.at for moment in moments) == [moment.at for moment in moments]
    assert "porter navigate_to_pose: store, SUCCEEDED at 10.000 s (also in the passing run)" == moments[0].text
    assert moments[3].text.startswith("porter pickup rejected (box): ")
    assert moments[3].text.endswith(", 4 times")
    assert (
        "after pickup of porter was rejected (reason not_ready), the controller sends no further goal"
        == moments[4].text
    )
    assert log.lines[moments[1].seen - 1].text.startswith("has the fault")


def test_the_moment_from_which_nothing_happens_says_why(waiting):
    _, _, outcome, log = waiting
    (still,) = [each for each in moments_of([], ShownRun("", log, "", outcome.at), None, None) if each.kind == "still"]

    assert 31.0 == pytest.approx(still.at)
    assert "eve has queued at ward_b since 20 s for 'charger', taken by wall_e; wall_e is docked" in still.text
    assert "the tree of eve runs " in still.text


def test_a_robot_that_gets_no_further_goal_is_a_key_moment():
    """The robot rejects a goal while it is broken down, and the dispatcher takes it for busy from then on."""
    check, case, outcome, log = planted("busy_stuck")
    other, beside = run_logged(check, case.with_schedule(()), Wanted())
    runs = ShownRun("", log, "", outcome.at), ShownRun("", beside, "", other.at)
    moments = moments_of([], *runs, first_difference(log, beside))

    assert [(6.0, "wall_e gets no further goal; in the other run it gets 12 more")] == [
        (moment.at, moment.text) for moment in moments if moment.kind == "silent"
    ]

"""Goals that the controller of a failing run omits."""

from __future__ import annotations

import pytest

from hmrsim.fault_search.failure_page import run_logged
from hmrsim.fault_search.run import Wanted
from hmrsim.fault_search.schedule import Case
from hmrsim.run_page import ShownRun
from hmrsim.run_page.moments import moments_of
from hmrsim.run_page.omissions import longest_pause, never_sent, robots_in
from tests.porters import check_of
from tests.unit.hmrsim.run_page.conftest import BREAKDOWN


@pytest.fixture(scope="module")
def careful():
    return run_logged(check_of("careful"), Case((BREAKDOWN,)), Wanted())[1]


@pytest.fixture(scope="module")
def hasty():
    return run_logged(check_of("hasty"), Case(), Wanted())[1]


def test_an_action_that_no_robot_gets_is_named_with_the_goal_that_it_has_in_the_other_run(hasty, passing):
    (omission,) = never_sent(hasty, passing[1], 100.0)

    assert "porter place: box; here, no robot gets a goal of place" == omission.text
    assert 20.0 == omission.at


def test_an_action_that_the_other_run_has_later_is_not_missing(hasty, passing):
    assert not [*never_sent(hasty, passing[1], 19.0)]


def test_the_longest_pause_of_a_robot_lies_between_its_goals(careful):
    assert (10.0, 40.0) == longest_pause("porter", careful, 600.0)


def test_the_robots_of_a_failure_are_those_named_and_those_with_goals_for_its_items(careful):
    assert ["other"] == robots_in(["other is late"], careful)
    assert ["porter"] == robots_in(["box is late"], careful)
    assert not robots_in(["another porter-2 is late"], careful)


def test_key_moments_say_what_the_robot_of_the_failure_lacks(hasty, careful, passing):
    for log, expected in (
        (hasty, "Beside: porter place: box; here, no robot gets a goal of place"),
        (careful, "porter gets no goal until 40.000 s"),
    ):
        runs = ShownRun("", log, "", 100.0, failure="porter is late"), ShownRun("Beside", passing[1], "", 100.0)
        moments = moments_of([], *runs, None)

        assert [expected] == [moment.text for moment in moments if moment.kind == "missing"]

"""In which order a demo tells what it hears."""

from __future__ import annotations

import pytest

from hmrsim.cli.demo_story import CausalOrder, Line

BEGUN = Line(1.0, "tree", "eve", "begun", hands_over=True)
ACCEPTED = Line(1.1, "world", "eve", "accepted")
SUCCEEDED = Line(2.05, "world", "eve", "SUCCEEDED", hands_over=True)
DONE = Line(2.0, "tree", "eve", "done")
AGAIN = Line(2.0, "tree", "eve", "begun again", hands_over=True)
ELSEWHERE = Line(9.0, "tree", "wall_e", "elsewhere")


@pytest.fixture
def tell():
    """Return the function that takes lines at 10 s and returns what may be told at a time."""
    turns = CausalOrder(patience=0.5)

    def run(*lines, at=10.0):
        for line in lines:
            turns.add(line, 10.0)
        return list(turns.ready(at))

    return run


@pytest.mark.parametrize(
    "lines",
    [
        [BEGUN, ACCEPTED, SUCCEEDED, DONE, AGAIN],
        [ACCEPTED, BEGUN, SUCCEEDED, DONE, AGAIN],
        [ACCEPTED, SUCCEEDED, BEGUN, DONE, AGAIN],
        [BEGUN, DONE, AGAIN, ACCEPTED, SUCCEEDED],
    ],
)
def test_causes_come_first(lines, tell):
    """However tree and world are mixed on arrival, each waits for what it comes of."""
    told = [line.text for line in tell(*lines)]

    assert ["begun", "accepted", "SUCCEEDED", "done", "begun again"] == told


def test_times_never_go_back(tell):
    """The controller's clock is behind; its lines have the time of what they come of."""
    told = [line.sim_time for line in tell(BEGUN, ACCEPTED, SUCCEEDED, DONE)]

    assert [1.0, 1.1, 2.05, 2.05] == told


def test_a_time_that_is_not_known(tell):
    """A controller that has not heard the clock yet has no time to tell."""
    (line,) = tell(BEGUN._replace(sim_time=None))

    assert line.sim_time is None


def test_robots_do_not_wait_for_each_other(tell):
    """What concerns another robot is told at once, with its own time."""
    told = [(line.text, line.sim_time) for line in tell(ACCEPTED, ELSEWHERE, BEGUN)]

    assert [("elsewhere", 9.0), ("begun", 1.0), ("accepted", 1.1)] == told


def test_patience_has_an_end(tell):
    """A behaviour may end without a word of the world, as when its goal is rejected."""
    waiting = tell(BEGUN, DONE)
    later = tell(at=10.5)

    assert (["begun"], ["done"]) == ([line.text for line in waiting], [line.text for line in later])

"""Formulas with windows of time, over the state of a world."""

from __future__ import annotations

import pytest

from hmrsim.errors import PropertyError
from hmrsim.properties import properties_of
from tests.watching import Feed

CHARGED = {"battery": "eve", "above": 0.5}
CLOSED = {"lane": ["lab", "hall"], "is": "closed"}


def watched(formula, *levels, until=100.0, ending="succeeded"):
    """Return the monitor of a run in which a battery changes, and a lane is closed from 10 to 20 s."""
    feed = Feed({"f": {"formula": formula}})
    feed.monitor.begin(0)
    told = [(at, "battery_low", {"robot": "eve", "charge": 1.0, "percentage": share}) for at, share in levels]
    told += [
        (10.0, "lane_closed", {"lane": ["lab", "hall"], "why": "wet"}),
        (20.0, "lane_opened", {"lane": ["lab", "hall"]}),
    ]
    for at, kind, fields in sorted(told, key=lambda each: each[0]):
        if at < until:
            feed.event(at, kind, **fields)
    return feed.end(until, ending)


def test_always_eventually_within_is_violated_when_a_window_is_over():
    """A battery is low from 30 to 60 s, and the window of 20 s from 30 s on ends at 50 s."""
    feed = watched({"always": {"eventually": CHARGED, "within": 20}}, (30.0, 0.4), (60.0, 0.9))

    reason = "not: always (eventually within 20 s (the battery of eve is above 50%))"
    assert [(50.0, "f", "eve", reason)] == feed.violations


def test_the_robustness_of_a_formula_is_that_of_its_conditions():
    """A battery at 70 % at least is two tenths above its bound; truncated windows do not count."""
    feed = watched({"always": {"eventually": CHARGED, "within": 20}}, (30.0, 0.4), (45.0, 0.7))

    assert ("holds", pytest.approx(0.2)) == feed.verdict("f")[1:3]


def test_a_window_can_start_later():
    """The lane is closed at some time from 15 to 30 s on, and not from 21 to 30 s on."""
    found = [watched({"eventually": CLOSED, "within": window}).verdict("f").state for window in ([15, 30], [21, 30])]

    assert ["holds", "violated"] == found


def test_until_and_if_are_parts_of_formulas():
    until = {"hold": CHARGED, "until": CLOSED, "within": 15}
    opens = {"always": {"if": CLOSED, "then": {"eventually": {"not": CLOSED}, "within": 10}}}

    found = [watched(each, (12.0, 0.1)).verdict("f").state for each in (until, opens, {"all": [until, {"not": until}]})]

    assert ["holds", "holds", "violated"] == found


@pytest.mark.parametrize(
    ("formula", "ending", "state"),
    [
        ({"eventually": CLOSED, "within": 50}, "succeeded", "undecided"),
        ({"eventually": CLOSED}, "succeeded", "violated"),
        ({"eventually": CLOSED}, "stopped", "undecided"),
        ({"always": CHARGED, "within": 5}, "succeeded", "holds"),
        ({"always": {"eventually": CHARGED, "within": 20}}, "succeeded", "undecided"),
    ],
)
def test_windows_cut_off_by_the_end_are_undecided(formula, ending, state):
    """A window without an end ends with the run, unless it was stopped."""
    levels = (
        ((1.0, 0.1),)
        if "always" in formula and isinstance(formula["always"], dict) and "eventually" in formula["always"]
        else ()
    )

    assert state == watched(formula, *levels, until=9.0, ending=ending).verdict("f").state


def test_errors_in_formulas_have_their_paths():
    with pytest.raises(PropertyError) as error:
        properties_of(
            {
                "properties": {
                    "a": {"formula": {"always": {"eventualy": CLOSED}}},
                    "b": {"formula": {"eventually": {"robot": "eve", "att": "lab"}, "within": [3, 2]}},
                }
            }
        )

    assert [
        "properties.a.formula.always: is no formula; did you mean 'eventually'?",
        "properties.b.formula.eventually.att: unknown key 'att'; did you mean 'at'?",
        "properties.b.formula.within: the window from 3 to 2 ends before it begins",
    ] == sorted(f"{problem.path}: {problem.message}" for problem in error.value.problems)

"""Planted bugs are shown by a few faults, and their correct twins bear these."""

from __future__ import annotations

import pytest

from hmrsim.fault_search.run import run_case
from hmrsim.fault_search.schedule import Case, Injection
from tests.torture.planted import catalogue, patient

_BUGS = catalogue()
_IN_PROCESS = [name for name, entry in _BUGS.items() if "command" not in entry["bug"]]


def _case(entry):
    return Case(tuple(Injection(thing.get("fault", thing)) for thing in entry["shown_by"]))


@pytest.mark.parametrize("name", _IN_PROCESS)
def test_its_schedule_shows_a_bug(name):
    entry = _BUGS[name]
    outcome = run_case(patient(entry, "bug"), _case(entry))

    assert outcome.violations
    assert len(entry["shown_by"]) <= 2


@pytest.mark.parametrize("name", _IN_PROCESS)
def test_a_correct_twin_bears_what_shows_the_bug(name):
    entry = _BUGS[name]
    outcome = run_case(patient(entry, "twin"), _case(entry))

    assert ("succeeded", ()) == (outcome.ending, outcome.violations)

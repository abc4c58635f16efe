"""Planted bugs are not seen in a run without faults."""

from __future__ import annotations

import pytest

from hmrsim.fault_search.run import run_case
from hmrsim.fault_search.schedule import Case
from tests.torture.planted import catalogue, patient

_BUGS = catalogue()
_IN_PROCESS = [name for name, entry in _BUGS.items() if "command" not in entry["bug"]]


def test_there_are_enough_bugs():
    commands = {entry["bug"]["command"][0] for entry in _BUGS.values() if "command" in entry["bug"]}

    assert len(_BUGS) >= 40
    assert {"sh", "node", "python3"} == commands


def test_each_bug_says_what_it_is():
    assert all(entry["text"].endswith(".") and entry["kind"] and entry["shown_by"] for entry in _BUGS.values())


@pytest.mark.parametrize("name", _IN_PROCESS)
def test_nothing_is_seen_without_faults(name):
    outcomes = [run_case(patient(_BUGS[name], which), Case()) for which in ("bug", "twin")]

    assert [("succeeded", ())] * 2 == [(outcome.ending, outcome.violations) for outcome in outcomes]

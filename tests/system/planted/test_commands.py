"""Planted bugs in commands of several languages."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import pytest

from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.run import run_case
from hmrsim.fault_search.schedule import Case, Injection
from tests.torture.planted import catalogue, patient

_BUGS = {name: entry for name, entry in catalogue().items() if "command" in entry["bug"]}
_CONTROLLERS = [(name, which) for name in _BUGS for which in ("bug", "twin")]
_CONTROLLERS.remove(("until_it_works", "twin"))  # its steps are those of the twin of ignores_exit_codes

_CALLED = {"sh": ("awk", "dirname", "grep")}
"""The programs that the planted scripts of an interpreter call."""


@pytest.fixture(autouse=True)
def _path(monkeypatch):
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


def _skip_unless_it_runs(command):
    missing = [each for each in (command[0], *_CALLED.get(command[0], ())) if shutil.which(each) is None]
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)}")


@pytest.mark.parametrize(("name", "which"), _CONTROLLERS)
def test_a_planted_command_succeeds_without_faults(name, which):
    _skip_unless_it_runs(_BUGS[name][which]["command"])
    outcome = run_case(patient(_BUGS[name], which), Case())

    assert ("succeeded", ()) == (outcome.ending, outcome.violations)


@pytest.mark.parametrize("name", _BUGS)
def test_the_schedule_of_a_planted_bug_shows_it(name):
    entry = _BUGS[name]
    _skip_unless_it_runs(entry["bug"]["command"])
    things = tuple(Injection(thing.get("fault", thing)) for thing in entry["shown_by"])
    outcome = run_case(patient(entry, "bug"), Case(things))

    assert outcome.violations


@pytest.mark.parametrize(("fault", "ending"), [((), "succeeded"), (({"type": "goals_rejected"},), "failed")])
def test_a_shell_script_may_send_goals_with_the_command_line_alone(tmp_path, fault, ending):
    script = tmp_path / "rounds.sh"
    goal = "hmrsim action send-goal /ann/wait '{time: {sec: 30}}'"
    script.write_text(f"#!/bin/sh\nset -e\n{goal}\n{goal}\n", encoding="utf-8")
    script.chmod(0o755)
    world = {"waypoints": {"a": [0, 0]}, "robots": {"ann": {"at": "a"}}}
    file = CheckFile.model_validate({"world": world, "controller": {"command": ["./rounds.sh"]}})
    things = tuple(Injection({**each, "robot": "ann", "at": 15.0, "count": 1}) for each in fault)
    outcome = run_case(check_at(file, tmp_path), Case(things))

    assert (outcome.ending, outcome.violations) == (ending, ()), outcome
    assert outcome.at == pytest.approx(30.0 if fault else 60.0)

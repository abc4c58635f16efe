"""Which properties hold in a run that is over, on the terminal."""

from __future__ import annotations

import json
from argparse import Namespace
from functools import cache

import pytest

from hmrsim.cli.check import check_trace
from hmrsim.errors import PropertyError, TraceError
from hmrsim.testing import simulation


@cache
def traced() -> str:
    """Return the trace of the hospital's mission."""
    with simulation("hospital", tree="bt_controller.examples.hospital:mission") as run:
        run.to_the_end()
        return run.trace


@pytest.fixture
def check(tmp_path):
    """Return the function that checks some properties on the trace."""

    def run(properties=None, *, as_json=False, trace=None):
        (tmp_path / "run.jsonl").write_text(traced() if trace is None else trace)
        path = None
        if properties is not None:
            path = tmp_path / "properties.yaml"
            path.write_text(json.dumps({"properties": properties}))
        return check_trace(Namespace(trace=tmp_path / "run.jsonl", properties=path, json=as_json, log_level="error"))

    return run


def test_verdicts_are_a_table(check, capsys):
    """Each property has a line: its verdict, its robustness, and why; the exit code is 0."""
    code = check({"door": {"sometimes": {"event": "door_opened"}}})

    out = capsys.readouterr().out.splitlines()
    assert (0, ["property", "verdict", "robustness"], ["door", "holds", "+1.00"]) == (
        code,
        out[0].split(),
        out[1].split()[:3],
    )


def test_violations_are_listed_with_their_times(check, capsys):
    """A violated property makes the exit code 1, and each violation is a line with its time."""
    code = check({"shut": {"never": {"event": "door_opened"}}})

    said = [line.split(" s  ")[-1] for line in capsys.readouterr().out.splitlines() if " s  " in line]
    assert (1, ["shut: door_opened"] * 13) == (code, said)


def test_json_has_all_of_it(check, capsys):
    """For programs the same is one JSON object."""
    code = check({"shut": {"never": {"event": "door_opened"}}}, as_json=True)

    said = json.loads(capsys.readouterr().out)
    assert (1, True, "shut", "door_opened", "violated") == (
        code,
        said["violated"],
        said["violations"][0]["property"],
        said["violations"][0]["reason"],
        said["verdicts"][0]["state"],
    )


def test_without_a_file_those_that_are_built_in_are_checked(check, capsys):
    """Goals that end, and the others, need no file."""
    code = check()

    assert (0, 7) == (code, len(capsys.readouterr().out.splitlines()) - 1)


def test_names_that_the_world_lacks_are_errors(check):
    """The error has the file and what there is instead."""
    with pytest.raises(PropertyError, match=r"properties\.x\.never\.robot: no robot 'eva'; did you mean 'eve'\?"):
        check({"x": {"never": {"robot": "eva", "at": "lab"}}})


def test_what_can_not_happen_is_a_warning(check, capsys):
    """A property that says nothing in this world is told on stderr."""
    check({"x": {"never": {"event": "lift_called"}}})

    assert "warning: properties.x.never.event: lift_called never comes in this world" in capsys.readouterr().err


def test_what_is_neither_trace_nor_recording_is_an_error(check):
    """The error has the file's name."""
    with pytest.raises(TraceError, match=r"run\.jsonl: line 1: no header of a trace"):
        check(trace="hello\n")

"""The command line of ``hmrsim report``."""

from __future__ import annotations

import csv
import json
import os
from functools import partial

import jsonschema
import pytest

from hmrsim.report import Report
from tests.unit.hmrsim.report.worlds import ALONE, FAULTY, MEETING


@pytest.fixture
def file(tmp_path, trace):
    """Return the function that writes the trace of a world to a file."""

    def write(world, **run):
        path = tmp_path / "run.jsonl"
        path.write_text("".join(trace(world, **run)))
        return path

    return write


def _table(path):
    with path.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


@pytest.fixture
def report(hmrsim):
    """Return the function that runs the command and returns exit code, output and errors."""
    return partial(hmrsim, "report")


def test_a_summary_of_the_run_and_each_robot_is_printed(file, report):
    code, out, _ = report(file(MEETING))

    assert 0 == code
    assert out.startswith("meeting: 2 robots, 9.000 simulated seconds, seed 0\n")
    assert "goals: 3 SUCCEEDED (100 % of those that ended succeeded)" in out
    assert "late" in out


def test_failed_goals_are_printed_and_exit_with_0(file, report):
    code, out, _ = report(file(FAULTY, until=4.0))

    assert (0, True) == (code, "has broken down" in out)


def test_json_is_one_value_of_the_schema(file, report):
    found = json.loads(report(file(MEETING), "--json")[1])

    jsonschema.validate(found, Report.model_json_schema(mode="serialization"))
    assert (1, 3) == (found["report"], len(found["goals"]))


def test_tables_have_a_row_per_goal_with_plain_numbers(file, tmp_path, report):
    code, _, _ = report(file(ALONE), "--csv", tmp_path / "tables")
    goals = _table(tmp_path / "tables" / "goals.csv")

    assert 0 == code
    assert [
        ("navigate_to_pose", 4.0, "SUCCEEDED", ""),
        ("wait", 2.0, "SUCCEEDED", ""),
        ("navigate_to_pose", 4.0, "SUCCEEDED", ""),
    ] == [(goal["action"], float(goal["duration"]), goal["status"], goal["error_msg"]) for goal in goals]
    assert ["4.0", "", "0.0"] == [goal["target_x"] for goal in goals]


def test_each_robot_has_a_row_with_seconds_per_state(file, tmp_path, report):
    report(file(ALONE), "--csv", tmp_path)
    (robot,) = _table(tmp_path / "robots.csv")

    assert ("8.0", "2.0", "8.0") == (robot["driving"], robot["busy"], robot["distance"])


def test_a_page_and_tables_are_written_without_printing(file, tmp_path, report):
    page = tmp_path / "report.html"

    assert (0, "", "") == report(file(ALONE), "-o", page, "--csv", tmp_path)
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_a_page_on_standard_output(file, report):
    assert report(file(ALONE), "-o", "-")[1].startswith("<!doctype html>")


NO_HEADER = "line 1: no header of a trace, and no MCAP; expected a file that was written with --trace or --record"


@pytest.mark.parametrize(
    ("content", "error"),
    [
        (b"", NO_HEADER),
        (b"hello\n", NO_HEADER),
        (b"[" * 100_000 + b"\n", NO_HEADER),
        (b'{"kind":"header"}\n', NO_HEADER),
        ("\x89MCAQ\n".encode(), NO_HEADER),
        (b"\xff\xfe\n", "neither a trace (text) nor a recording (MCAP)"),
        (None, "can't be read: no such file or directory"),
    ],
)
def test_neither_a_trace_nor_a_recording_exits_with_2(tmp_path, report, content, error):
    for path in (tmp_path / "run.jsonl", tmp_path / "run.mcap"):
        if content is not None:
            path.write_bytes(content)

        assert (2, "", f"hmrsim: {path}: {error}\n") == report(path)


def test_a_pipe_is_not_read(tmp_path, report):
    """A report reads its file twice, and would wait for a pipe without a writer."""
    path = tmp_path / "pipe"
    os.mkfifo(path)

    assert (2, "", f"hmrsim: {path}: can't be read: is not a regular file\n") == report(path)


@pytest.fixture
def with_line(file):
    """Return the function that writes a trace with a line inserted as the fourth one."""

    def write(line):
        path = file(ALONE)
        lines = path.read_text().splitlines()
        path.write_text("\n".join([*lines[:3], line, *lines[3:]]) + "\n")
        return path

    return write


@pytest.mark.parametrize("line", ["NaN", '{"kind":"status","stamp":{"sec":NaN,"nanosec":0}}', "[" * 100_000, "{", "7"])
def test_a_line_without_a_json_object_exits_with_2_and_its_place(with_line, report, line):
    path = with_line(line)
    code, _, err = report(path)

    assert (2, 1) == (code, err.count("\n"))
    assert err.startswith(f"hmrsim: {path}: line 4: ")


@pytest.mark.parametrize(
    "event",
    [
        {"kind": "status", "robot": 7, "action": "wait", "goal_id": "", "status": 1},
        {"kind": "status", "robot": "wall_e", "action": "wait", "goal_id": "", "status": 77},
        {"kind": "status", "robot": "wall_e", "action": "wait", "goal_id": "", "status": 0},
        {"kind": "waiting", "robot": "wall_e", "at": [1e999, None], "for": "all"},
        {"kind": "deadlock", "robots": {}, "lanes": 7},
        {"kind": "fault_began", "name": [], "fault": {}},
        {"kind": "motion", "robot": "wall_e", "from": [0, 0], "to": [1, 1], "duration": -1},
        {"kind": "dock_docked", "robot": "wall_e", "dock": None},
        {"kind": "battery_low", "robot": "wall_e", "percentage": "much"},
    ],
)
def test_invalid_events_are_skipped_and_counted(with_line, report, event):
    line = json.dumps({**event, "stamp": {"sec": 2, "nanosec": 0}}).replace("Infinity", "1e999")
    code, out, _ = report(with_line(line), "--json")
    found = json.loads(out)

    assert (0, 3) == (code, len([goal for goal in found["goals"] if goal["status"] == "SUCCEEDED"]))
    assert any("events are ignored" in note for note in found["source"]["notes"])


def test_a_truncated_trace_is_reported_with_a_warning(file, report):
    path = file(ALONE)
    path.write_text(path.read_text()[:-50])
    code, out, err = report(path)

    assert (0, f"{path}: The trace is truncated: later events are missing.\n") == (code, err)
    assert out.startswith("alone: 1 robot")


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (("none", "-o", "run.jsonl/x"), "-o run.jsonl/x: can't be written: not a directory"),
        (("none", "--csv", "run.jsonl/x"), "--csv run.jsonl/x: can't be written: not a directory"),
        (("none", "-o", "page", "--csv", "tables"), "none: can't be read: no such file or directory"),
        (("run.jsonl", "-o", "run.jsonl"), "-o run.jsonl: this command reads that file; name another"),
        (("run.jsonl", "--csv", ""), "argument --csv: empty; expected a folder, such as . or tables"),
        (("run.jsonl", "-o", "-", "--json"), "-o - and --json both write to the standard output"),
    ],
)
def test_an_unusable_output_exits_with_2_and_no_file_is_written(file, tmp_path, monkeypatch, report, words, error):
    """An empty folder name, as of an unset shell variable, is not the current folder."""
    path = file(ALONE)
    before = path.read_bytes()
    monkeypatch.chdir(tmp_path)
    code, out, err = report(*words)

    assert (2, "", 1, True) == (code, out, err.count("\n"), error in err)
    assert {"run.jsonl": before} == {each.name: each.read_bytes() for each in tmp_path.iterdir()}


def test_control_characters_of_a_trace_are_escaped_in_json(file, report):
    path = file(ALONE)
    text = path.read_text()
    name = json.loads(text.splitlines()[0])["world"]["name"]
    path.write_text(text.replace(f'"name":"{name}"', '"name":"a\u009b31mb\u007f"'), encoding="utf-8")
    _, out, _ = report(path, "--json")

    assert ("a\u009b31mb\u007f", True) == (json.loads(out)["world"]["name"], "a\\u009b31mb\\u007f" in out)

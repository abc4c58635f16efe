"""The command line of ``hmrsim report``."""

from __future__ import annotations

import csv
import json
import os

import jsonschema
import pytest

from hmrsim.cli import main
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


def test_a_summary_of_the_run_and_each_robot_is_printed(file, capsys):
    code = main(["report", str(file(MEETING))])
    out = capsys.readouterr().out

    assert 0 == code
    assert out.startswith("meeting: 2 robots, 9.000 simulated seconds, seed 0\n")
    assert "goals: 3 SUCCEEDED (100 % of those that ended succeeded)" in out
    assert "late" in out


def test_failed_goals_are_printed_and_exit_with_0(file, capsys):
    code = main(["report", str(file(FAULTY, until=4.0))])

    assert (0, True) == (code, "has broken down" in capsys.readouterr().out)


def test_json_is_one_value_of_the_schema(file, capsys):
    main(["report", str(file(MEETING)), "--json"])
    told = json.loads(capsys.readouterr().out)

    jsonschema.validate(told, Report.model_json_schema(mode="serialization"))
    assert (1, 3) == (told["report"], len(told["goals"]))


def test_tables_have_a_row_per_goal_with_plain_numbers(file, tmp_path):
    code = main(["report", str(file(ALONE)), "--csv", str(tmp_path / "tables")])
    goals = _table(tmp_path / "tables" / "goals.csv")

    assert 0 == code
    assert [
        ("navigate_to_pose", 4.0, "SUCCEEDED", ""),
        ("wait", 2.0, "SUCCEEDED", ""),
        ("navigate_to_pose", 4.0, "SUCCEEDED", ""),
    ] == [(goal["action"], float(goal["duration"]), goal["status"], goal["error_msg"]) for goal in goals]
    assert ["4.0", "", "0.0"] == [goal["target_x"] for goal in goals]


def test_each_robot_has_a_row_with_seconds_per_state(file, tmp_path):
    main(["report", str(file(ALONE)), "--csv", str(tmp_path)])
    (robot,) = _table(tmp_path / "robots.csv")

    assert ("8.0", "2.0", "8.0") == (robot["driving"], robot["busy"], robot["distance"])


def test_a_page_and_tables_are_written_without_printing(file, tmp_path, capsys):
    page = tmp_path / "report.html"
    main(["report", str(file(ALONE)), "-o", str(page), "--csv", str(tmp_path)])

    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert "" == capsys.readouterr().out


def test_a_page_on_standard_output(file, capsys):
    main(["report", str(file(ALONE)), "-o", "-"])

    assert capsys.readouterr().out.startswith("<!doctype html>")


@pytest.mark.parametrize("text", ["", "hello\n", "[" * 100_000 + "\n", '{"kind":"header"}\n', "\x89MCAQ\n"])
@pytest.mark.parametrize("name", ["run.jsonl", "run.mcap"])
def test_neither_a_trace_nor_a_recording_exits_with_2(tmp_path, capsys, text, name):
    path = tmp_path / name
    path.write_text(text)
    code = main(["report", str(path)])

    error = "line 1: no header of a trace, and no MCAP; expected a file that was written with --trace or --record"
    assert (2, f"hmrsim: {path}: {error}\n") == (code, capsys.readouterr().err)


def test_binary_data_that_is_no_recording_exits_with_2(tmp_path, capsys):
    path = tmp_path / "run.mcap"
    path.write_bytes(b"\xff\xfe\n")
    code = main(["report", str(path)])

    error = "neither a trace (text) nor a recording (MCAP)"
    assert (2, f"hmrsim: {path}: {error}\n") == (code, capsys.readouterr().err)


def test_a_pipe_is_not_read(tmp_path, capsys):
    """A report reads its file twice, and would wait for a pipe without a writer."""
    path = tmp_path / "pipe"
    os.mkfifo(path)
    code = main(["report", str(path)])

    assert (2, f"hmrsim: {path}: can't be read: is not a regular file\n") == (code, capsys.readouterr().err)


@pytest.mark.parametrize("line", ["NaN", '{"kind":"status","stamp":{"sec":NaN,"nanosec":0}}', "[" * 100_000, "{", "7"])
def test_a_line_without_a_json_object_exits_with_2_and_its_place(file, capsys, line):
    path = file(ALONE)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:3], line, *lines[3:]]) + "\n")
    code = main(["report", str(path)])
    err = capsys.readouterr().err

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
def test_invalid_events_are_skipped_and_counted(file, capsys, event):
    path = file(ALONE)
    lines = path.read_text().splitlines()
    text = json.dumps({**event, "stamp": {"sec": 2, "nanosec": 0}}).replace("Infinity", "1e999")
    path.write_text("\n".join([*lines[:3], text, *lines[3:]]) + "\n")
    code = main(["report", str(path), "--json"])
    told = json.loads(capsys.readouterr().out)

    assert (0, 3) == (code, len([goal for goal in told["goals"] if goal["status"] == "SUCCEEDED"]))
    assert any("events are ignored" in note for note in told["source"]["notes"])


def test_a_truncated_trace_is_reported_with_a_warning(file, capsys):
    path = file(ALONE)
    path.write_text(path.read_text()[:-50])
    code = main(["report", str(path)])
    told = capsys.readouterr()

    assert (0, f"{path}: The trace is truncated: later events are missing.\n") == (code, told.err)
    assert told.out.startswith("alone: 1 robot")


def test_a_missing_file_exits_with_2(tmp_path, capsys):
    code = main(["report", str(tmp_path / "none")])

    assert (2, f"hmrsim: {tmp_path}/none: can't be read: no such file or directory\n") == (
        code,
        capsys.readouterr().err,
    )


@pytest.mark.parametrize("option", ["-o", "--csv"])
def test_an_unwritable_output_is_reported_before_reading(tmp_path, capsys, option):
    there = tmp_path / "file"
    there.touch()
    main(["report", str(tmp_path / "none"), option, str(there / "x")])

    assert f"hmrsim: {option} {there}/x: can't be written: not a directory\n" == capsys.readouterr().err


def test_a_page_over_its_trace_is_refused(file, capsys):
    path = file(ALONE)
    before = path.read_bytes()
    code = main(["report", str(path), "-o", str(path)])

    assert (2, f"hmrsim: -o {path}: this command reads that file; name another\n") == (code, capsys.readouterr().err)
    assert before == path.read_bytes()


def test_a_failed_report_leaves_no_files(tmp_path):
    code = main(["report", str(tmp_path / "none"), "-o", str(tmp_path / "page"), "--csv", str(tmp_path / "tables")])

    assert (2, []) == (code, list(tmp_path.iterdir()))


def test_an_empty_folder_name_is_refused(file, tmp_path, monkeypatch, capsys):
    """An unset shell variable must not mean the current folder."""
    path = file(ALONE)
    monkeypatch.chdir(tmp_path)
    code = main(["report", str(path), "--csv", ""])

    assert (2, True) == (code, "--csv: empty; expected a folder" in capsys.readouterr().err)
    assert [path] == list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["-o", "--csv"])
def test_an_unwritable_output_names_its_option(file, capsys, option):
    path = file(ALONE)
    code = main(["report", str(path), option, str(path / "x")])

    assert (2, f"hmrsim: {option} {path}/x: can't be written: not a directory\n") == (code, capsys.readouterr().err)


def test_page_and_json_can_not_both_go_to_standard_output(file, capsys):
    code = main(["report", str(file(ALONE)), "-o", "-", "--json"])

    assert (2, True) == (code, "both write to the standard output" in capsys.readouterr().err)


def test_control_characters_of_a_trace_are_escaped_in_json(file, capsys):
    path = file(ALONE)
    text = path.read_text()
    name = json.loads(text.splitlines()[0])["world"]["name"]
    path.write_text(text.replace(f'"name":"{name}"', '"name":"a\u009b31mb\u007f"'), encoding="utf-8")
    main(["report", str(path), "--json"])
    out = capsys.readouterr().out

    assert ("a\u009b31mb\u007f", True) == (json.loads(out)["world"]["name"], "a\\u009b31mb\\u007f" in out)

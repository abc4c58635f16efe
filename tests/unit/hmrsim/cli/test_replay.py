"""``hmrsim replay`` and the option ``--trace``."""

from __future__ import annotations

import json
import re

import pytest

from hmrsim.cli import replay
from hmrsim.cli.replay import TraceFile
from hmrsim.events.traffic import LaneOpened
from hmrsim.protocol.outputs import EventStamped
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from tests.shipped import shipped

WORLD = """\
waypoints: {home: [0, 0], door: [4, 0]}
lanes: [[home, door]]
robots: {wall_e: {type: carrier, at: home, script: [Go door, Wait 2, Go home]}}
"""


@pytest.fixture
def trace(tmp_path, hmrsim):
    world = tmp_path / "world.yaml"
    world.write_text(WORLD)
    path = tmp_path / "run.jsonl"
    assert 0 == hmrsim("simulate", world, "--trace", path)[0]
    return path


def test_an_identical_replay_exits_with_0(trace, hmrsim):
    code, out, _ = hmrsim("replay", trace)

    assert 0 == code
    assert re.fullmatch(r"identical: \d+ lines, 0 commands, 10\.000 simulated seconds\n", out)


def test_a_truncated_trace_is_reported(trace, hmrsim):
    trace.write_text(trace.read_text()[:-50])
    code, out, _ = hmrsim("replay", trace)

    assert (0, True) == (code, out.endswith("; the trace is truncated there\n"))


def test_a_different_replay_shows_both_lines(trace, hmrsim):
    text = trace.read_text()
    trace.write_text(text.replace('"status":4', '"status":6', 1))
    code, out, _ = hmrsim("replay", trace)
    number = text[: text.index('"status":4')].count("\n") + 1

    assert 1 == code
    assert out.startswith(f"{trace}:{number}: the replay differs here\n")
    assert re.search(rf'^- +{number}  .*"status":6}}$', out, re.MULTILINE)
    assert re.search(rf'^\+ +{number}  .*"status":4}}$', out, re.MULTILINE)


def test_json_is_one_object(trace, hmrsim):
    code, out, _ = hmrsim("replay --json", trace)
    names = ("identical", "complete", "difference", "sim_time")

    assert (0, [True, True, None, 10.0]) == (code, [json.loads(out)[name] for name in names])


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (None, "can't be read: no such file or directory"),
        (b"", "line 1: no header of a trace; expected a file that was written with --trace"),
        (b"\xff\xfe\n", "is not a trace: it is not text"),
    ],
)
def test_a_file_that_is_no_trace_is_wrong_use(tmp_path, hmrsim, content, why):
    path = tmp_path / "run.jsonl"
    if content is not None:
        path.write_bytes(content)

    assert (2, "", f"hmrsim: {path}: {why}\n") == hmrsim("replay", path)


@pytest.mark.parametrize(("line", "most"), [(0, 5_000_000), (1, 1_000_000)])
def test_a_line_of_too_many_values_is_not_parsed(trace, hmrsim, line, most):
    """The first line, which contains the world, may have more values."""
    lines = trace.read_text().splitlines(keepends=True)
    lines[line] = f'{{"kind":"x","x":[{"0," * most}0]}}\n'
    trace.write_text("".join(lines))

    error = f"hmrsim: {trace}: line {line + 1} has more than {most} values\n"
    assert (2, "", error) == hmrsim("replay", trace)


def test_control_characters_of_a_header_do_not_reach_the_terminal(trace, hmrsim):
    trace.write_text(trace.read_text().replace('"hmrsim":"', '"hmrsim":"\\u001b[2J', 1))

    assert f"{trace} was written by hmrsim \\x1b[2J" in hmrsim("replay", trace)[2]


def test_an_unwritable_trace_is_wrong_use(tmp_path, hmrsim):
    (tmp_path / "world.yaml").write_text(WORLD)
    code, _, err = hmrsim("simulate", tmp_path / "world.yaml", "--trace", tmp_path / "no" / "run.jsonl")

    assert (2, True) == (code, "can't be written: no such file or directory" in err)


def test_a_line_without_end_is_not_read_into_memory(trace, hmrsim, monkeypatch):
    monkeypatch.setattr(replay, "_MAX_CHARACTERS", 100)

    assert (2, "", f"hmrsim: {trace}: line 1 has more than 100 characters\n") == hmrsim("replay", trace)


def test_outputs_after_the_end_are_ignored(tmp_path):
    """Python may free the processes of robots after the file is closed, and they then leave their docks."""
    path, world, settings = tmp_path / "trace.jsonl", shipped("scenario1").world, RunSettings()
    file = TraceFile(path, world, settings)
    simulator = Simulator(world, settings, file.sinks)
    with file.opened(simulator):
        simulator.advance(1.0)
    complete = path.read_bytes()
    for sink in file.sinks:
        for _ in range(10_000):
            sink.emit(EventStamped(0, LaneOpened(("home", "lobby"))))

    assert complete == path.read_bytes()
    assert json.loads(complete.splitlines()[-1])["kind"] == "end"

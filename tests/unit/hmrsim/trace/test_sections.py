"""Sections of a trace, which begin wherever simulated time restarts."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main
from hmrsim.cli.replay import difference_from
from hmrsim.errors import TraceError
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import SendGoal
from hmrsim.trace.difference import first_difference
from hmrsim.trace.replay import replay
from hmrsim.trace.sections import restart_text, sections_of
from tests.simulation import SMALL_WORLD, simulate

RESET, RESET_TIME, STOP, PLAY = (
    ("reset_simulation", {}),
    ("reset_simulation", {"scope": 1}),
    ("set_simulation_state", {"state": {"state": 0}}),
    ("set_simulation_state", {"state": {"state": 1}}),
)
OTHER = {"name": "other", "seed": 5, "waypoints": {"a": [0, 0]}, "robots": {"zoe": {"at": "a"}}}
LOAD = ("load_world", {"resource_string": json.dumps(OTHER)})


def wait(robot="eve"):
    return SendGoal(robot, "wait", Wait.Goal.model_validate({"time": {"sec": 1}}))


def traced(*orders, close=True, **settings):
    run = simulate(traced=True, **settings)
    for order in orders:
        if isinstance(order, float):
            run.simulator.advance(run.simulator.now + order)
        elif isinstance(order, SendGoal):
            run.simulator.submit(order)
        else:
            run.ask(*order)
    if close:
        return run.lines()
    run.trace.flush()
    return "".join(run.written).splitlines(keepends=True)


def headers(lines):
    return [line for line in map(json.loads, lines) if line["kind"] == "header"]


THREE = (2.0, wait(), 3.0, RESET, wait(), 4.0, LOAD, PLAY, wait("zoe"), 2.0)
"""Sections of 5 s, 4 s and 2 s."""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "run.jsonl"
    path.write_text("".join(traced(*THREE)))
    return path


@pytest.mark.parametrize(
    ("orders", "causes"),
    [
        ((RESET,), ["reset"]),
        ((("reset_simulation", {"scope": 255}),), ["reset"]),
        ((("reset_simulation", {"scope": 3}),), ["reset"]),
        ((RESET_TIME,), ["time_reset"]),
        ((("reset_simulation", {"scope": 5}),), ["time_reset"]),
        ((("reset_simulation", {"scope": 2}),), []),
        ((("reset_simulation", {"scope": 4}),), []),
        ((("reset_simulation", {"scope": 6}),), []),
        ((("reset_simulation", {"scope": 64}),), []),
        ((STOP, PLAY), ["stopped"]),
        ((LOAD,), ["world_loaded"]),
        ((("load_world", {"resource_string": "name: [wrong"}),), []),
        ((RESET, 1.0, RESET), ["reset", "reset"]),
    ],
)
def test_a_section_begins_where_time_restarts(orders, causes):
    first, *others = headers(traced(1.0, *orders, 1.0))

    assert ("section" in first, "cause" in first) == (False, False)
    assert list(enumerate(causes, 2)) == [(header["section"], header["cause"]) for header in others]


def test_the_header_repeats_that_of_the_first_section():
    first, second = headers(traced(1.0, RESET, seed=7, step_size=0.3, run_id="x"))

    assert first | {"section": 2, "cause": "reset"} == second


@pytest.mark.parametrize(("settings", "seed"), [({}, 5), ({"seed": 7}, 7)])
def test_a_loaded_world_is_in_its_header_with_its_seed_or_the_given_one(settings, seed):
    _, header = headers(traced(1.0, LOAD, **settings))

    assert ("other", seed, bool(settings)) == (header["world"]["name"], header["seed"], header["seed_given"])
    assert ["zoe"] == [*header["world"]["definition"]["robots"]]


def test_times_restart_with_the_section():
    """The command that begins a section belongs to the one before."""
    lines = [json.loads(line) for line in traced(2.0, wait(), 0.5, RESET)]
    at = next(i for i, line in enumerate(lines) if line.get("section") == 2)

    assert {(2, 500_000_000)} == {(line["stamp"]["sec"], line["stamp"]["nanosec"]) for line in lines[at - 2 : at]}
    assert ("reset", {"sec": 0, "nanosec": 1}) == (lines[at + 1]["kind"], lines[at + 1]["stamp"])


def test_the_header_is_canonical():
    line = next(line for line in traced(1.0, LOAD) if '"section"' in line)
    world = json.loads(line)["world"]

    assert [*json.loads(line)] == sorted(json.loads(line))
    assert line == json.dumps({**json.loads(line), "world": world}, separators=(",", ":")) + "\n"


def test_a_replay_counts_each_section():
    lines = traced(*THREE)
    outcome = replay(lines)

    assert (None, True, len(lines)) == (outcome.difference, outcome.complete, outcome.lines)
    assert [5.0, 4.0, 2.0] == [section.sim_time for section in outcome.sections]
    assert [2, 2, 2] == [section.commands for section in outcome.sections]
    assert ["small", "small", "other"] == [section.header.name for section in outcome.sections]
    assert 11.0 == outcome.sim_time


@pytest.mark.parametrize("orders", [(RESET_TIME,), (STOP, PLAY), (RESET, RESET), (LOAD, PLAY, 1.0, LOAD)])
def test_each_cause_of_a_section_is_replayed(orders):
    outcome = replay(traced(1.5, wait(), 0.5, *orders, 2.0))

    assert (None, True) == (outcome.difference, outcome.complete)


def test_a_replay_ends_after_the_requested_section():
    lines = traced(*THREE)
    ends = sections_of(lines)[2].line - 1
    outcome = replay([*lines[:ends], lines[ends], "nonsense\n"], section=2)

    assert (None, True, ends, 2) == (outcome.difference, outcome.complete, outcome.lines, len(outcome.sections))


def test_a_difference_in_an_earlier_section_is_reported():
    lines = traced(*THREE)
    number = next(i for i, line in enumerate(lines) if '"status":4' in line)
    lines[number] = lines[number].replace('"status":4', '"status":6')
    outcome = replay(lines, section=2)

    assert (number + 1, 1) == (outcome.difference.line, len(outcome.sections))


def test_an_extra_header_is_a_difference():
    lines = traced(1.0, wait(), 2.0)
    header = traced(1.0, RESET)[2]
    difference = replay([*lines[:3], header, *lines[3:]]).difference

    assert (4, header) == (difference.line, difference.was + "\n")


def test_a_missing_header_is_a_difference():
    lines = traced(1.0, RESET, 1.0)
    number = next(i for i, line in enumerate(lines) if '"section":2' in line)
    difference = replay(lines[:number] + lines[number + 1 :]).difference

    assert (number + 1, lines[number]) == (difference.line, difference.now + "\n")


def test_a_trace_that_was_cut_is_replayed_to_its_end():
    text = "".join(traced(*THREE))
    for cut in range(text.index("\n") + 1, len(text) - 1, 97):
        outcome = replay(text[:cut].splitlines(keepends=True))

        assert (None, False) == (outcome.difference, outcome.complete)
        assert text[:cut].count("\n") == outcome.lines


def test_a_section_alone_is_no_trace():
    """It depends on the sections before it."""
    lines = traced(*THREE)
    alone = lines[sections_of(lines)[1].line - 1 :]

    with pytest.raises(TraceError, match="line 1: the header of section 2; a replay needs the sections before it, too"):
        replay(alone)


def test_lines_that_resemble_a_header_are_none():
    lines = traced()
    others = ['{"kind":"x","goal":{"kind":"header"}}\n', '"\\"kind\\":\\"header\\""\n', '{"kind":"header"\n', "[]\n"]

    assert [1] == [section.line for section in sections_of([*lines, *others, lines[0][:-1]])]


def test_the_cause_of_a_section_is_described():
    assert ("a world was loaded", "eclipse", "") == tuple(map(restart_text, ("world_loaded", "eclipse", "")))


def test_a_test_of_a_controller_has_sections(simulation):
    run = simulation(SMALL_WORLD)
    run.client.sleep(2.0)
    run.client.get("hmrsim/_world/reset_simulation", payload=b"{}")
    run.client.sleep(1.0)
    lines = run.trace.splitlines(keepends=True)

    assert ([1, 2], None) == ([section.number for section in sections_of(lines)], replay(lines).difference)


class TestCommand:
    def test_sections_are_listed(self, path, capsys):
        code = main(["replay", str(path)])
        *sections, last = capsys.readouterr().out.splitlines()

        assert 0 == code
        assert ["section 1, small, seed 0, ", "section 2, small, seed 0, ", "section 3, other, seed 5, "] == [
            line[:26] for line in sections
        ]
        assert ["", "the simulation was reset", "a world was loaded"] == [
            line.partition(" simulated seconds")[2].removeprefix(": ") for line in sections
        ]
        assert last.endswith(", 6 commands, 11.000 simulated seconds")

    def test_one_section_is_replayed(self, path, capsys):
        code = main(["replay", str(path), "--section", "2"])
        section, last = capsys.readouterr().out.splitlines()

        assert 0 == code
        assert section.endswith("2 commands, 4.000 simulated seconds: the simulation was reset")
        assert last.endswith("4 commands, 9.000 simulated seconds, up to the end of section 2")

    def test_json_has_sections(self, path, capsys):
        main(["replay", str(path), "--json"])
        found = json.loads(capsys.readouterr().out)

        assert 11.0 == found["sim_time"]
        assert [(1, "", 5.0), (2, "reset", 4.0), (3, "world_loaded", 2.0)] == [
            (each["number"], each["cause"], each["sim_time"]) for each in found["sections"]
        ]

    @pytest.mark.parametrize("command", ["replay", "report"])
    def test_an_unknown_section_exits_with_2(self, path, capsys, command):
        code = main([command, str(path), "--section", "4"])
        second, third = (section.line for section in sections_of(path.read_text().splitlines(keepends=True))[1:])
        there = f"1 from line 1 on ('small'), 2 from line {second} on ('small'), 3 from line {third} on ('other')"

        assert (2, f"hmrsim: {path}: no section 4; there are {there}\n") == (code, capsys.readouterr().err)

    @pytest.mark.parametrize("command", ["replay", "report"])
    @pytest.mark.parametrize("number", ["0", "-1", "x", "1.5", ""])
    def test_an_invalid_section_number_exits_with_2(self, path, capsys, command, number):
        code = main([command, str(path), f"--section={number}"])
        error = capsys.readouterr().err

        assert (2, True) == (code, f"argument --section: {number!r} is not a whole number greater than 0" in error)

    def test_a_truncated_header_begins_no_section(self, path, capsys):
        text = path.read_text()
        path.write_text(text[: text.index('"section":3') + 20])

        assert 2 == main(["replay", str(path), "--section", "3"])
        assert "no section 3; there are 1 from" in capsys.readouterr().err
        assert 0 == main(["replay", str(path)])
        assert capsys.readouterr().out.endswith("; the trace is truncated there\n")

    def test_a_header_may_have_as_many_values_as_a_world(self, path, capsys):
        path.write_text(path.read_text() + f'{{"kind":"header","x":[{"0," * 5_000_000}0]}}\n')

        assert 2 == main(["replay", str(path)])
        assert "has more than 5000000 values" in capsys.readouterr().err


def test_scripts_stopped_before_their_first_instant_are_replayed():
    """Neither the trace nor the replay has the remaining orders of that instant."""
    scripted = {**OTHER, "robots": {"zoe": {"at": "a", "script": ["Wait 5"]}}}
    run = simulate(traced=True)
    run.ask("load_world", {"resource_string": json.dumps(scripted)})
    run.simulator.stop()
    lines = run.lines()

    outcome = replay(iter(lines))

    assert outcome.difference is None, outcome.difference
    assert not any('"script_ended"' in line for line in lines)


WAS = '{"kind":"header"}\n{"kind":"status","robot":"eve","stamp":{"nanosec":500000000,"sec":3},"status":4}\n'
NOW = WAS.replace('"status":4', '"status":6')


def test_equal_runs_have_no_difference():
    assert first_difference(WAS, WAS) is None


def test_the_first_difference_has_both_lines():
    difference = first_difference(WAS, NOW)

    assert difference is not None
    assert (
        "first difference: line 2, at 3.500 s, robot eve\n"
        "  was 3.500000000 s eve status status=4\n"
        "  is  3.500000000 s eve status status=6"
    ) == difference.describe()


def test_a_run_that_ends_earlier_differs():
    difference = first_difference(WAS, WAS.splitlines()[0])

    assert difference is not None
    assert difference.describe().endswith("\n  is  nothing: it ends before")


@pytest.mark.parametrize("line", ["", "[]", "no JSON"])
def test_a_line_that_is_no_event_is_shown_raw(line):
    difference = first_difference(line + "x", NOW)

    assert difference is not None
    assert difference.describe().startswith("first difference: line 1, at the start\n")


def order_of_a_set() -> str:
    return " ".join({f"robot_{number}" for number in range(50)})


def test_without_a_trace_the_run_is_repeated_in_other_processes():
    """Sets have another order there."""
    assert "two runs of now differ, too" in difference_from("", order_of_a_set(), order_of_a_set)


def test_equal_repetitions_are_reported():
    assert "the code of the controller" in difference_from("", "'abc'", repr, "abc")


def test_a_kept_trace_is_compared():
    assert "line 2, at 3.500 s" in difference_from(WAS, NOW, lambda: "")

"""Reports of traces with several sections, each of which starts at 0 with the state of that moment."""

from __future__ import annotations

import csv
import json

import jsonschema
import pytest

from hmrsim.cli import main
from hmrsim.interfaces.simulation_interfaces import LoadWorld, ResetSimulation, SetSimulationState, SimulationState
from hmrsim.protocol.commands import CallService
from hmrsim.report import Report, Sections, of_trace, report_of, section_of
from hmrsim.trace.sections import sections_of
from tests.unit.hmrsim.report.worlds import ALONE, CHARGING, FAULTY, MEETING, goal_to

RESET = CallService("reset_simulation", ResetSimulation.Request())
RESET_TIME = CallService("reset_simulation", ResetSimulation.Request(scope=1))
LOAD = CallService("load_world", LoadWorld.Request(resource_string=json.dumps(MEETING | {"seed": 5})))
PLAY = CallService("set_simulation_state", SetSimulationState.Request(state=SimulationState(state=1)))
MANUAL = ALONE | {"robots": {"wall_e": {"type": "cart", "at": "home"}}}

TWICE = {"commands": [(3.0, RESET)], "until": 12.0}
"""An aborted drive of 3 s, and then the whole script."""


@pytest.fixture
def reports(trace):
    """Return the function that runs a world and returns the reports of its trace's sections."""

    def make(world, **run):
        lines = trace(world, **run)
        return [report_of(each) for each in of_trace(lambda: lines)]

    return make


@pytest.fixture
def path(tmp_path, trace):
    """Return the trace of two sections of a world, and of one of another."""
    path = tmp_path / "run.jsonl"
    path.write_text("".join(trace(ALONE, commands=[(3.0, RESET), (11.0, LOAD), (0.0, PLAY)], until=10.0)))
    return path


def test_each_section_is_reported_like_a_separate_run(reports):
    first, second = reports(ALONE, **TWICE)

    assert [("ABORTED", 0.0, 3.0)] == [(goal.status, goal.accepted, goal.ended) for goal in first.goals]
    assert [(0.0, 4.0), (4.0, 6.0), (6.0, 10.0)] == [(goal.accepted, goal.ended) for goal in second.goals]
    assert (3.0, 3.0, 12.0, 8.0) == (
        first.summary.sim_time,
        first.summary.distance,
        second.summary.sim_time,
        second.summary.distance,
    )
    assert (True, True) == (first.source.exact and second.source.exact, first.source.complete)
    assert () == first.source.notes + second.source.notes


def test_a_whole_reset_gives_the_report_of_a_first_run(reports, report):
    second, alone = reports(ALONE, **TWICE)[1], report(ALONE, until=12.0)

    assert (alone.states, alone.lanes, alone.robots) == (second.states, second.lanes, second.robots)
    assert second.events == alone.events | {"reset": 1}


def test_robots_stay_where_they_are_if_only_time_is_reset(reports, send):
    to_the_door = send("wall_e", "navigate_to_pose", goal_to(4, 0))
    first, second = reports(MANUAL, commands=[(0.0, to_the_door), (3.0, RESET_TIME), (0.0, to_the_door)], until=2.0)

    assert (3.0, 1.0) == (first.summary.distance, second.summary.distance)
    assert [("driving", 0.0, 1.0), ("idle", 1.0, 2.0)] == [(s.state, s.began, s.ended) for s in second.states]


def test_idle_time_before_a_reset_belongs_to_its_section(reports, send):
    """The last event is 2 s before the reset at 6 s."""
    drive = send("wall_e", "navigate_to_pose", goal_to(4, 0))
    first, second = reports(MANUAL, commands=[(0.0, drive), (6.0, RESET), (0.0, drive)], until=4.0)

    assert (6.0, 2.0, 4.0) == (first.summary.sim_time, first.robots[0].seconds["idle"], second.summary.sim_time)
    assert "command" not in " ".join(first.events)


def test_another_world_has_its_report(trace):
    lines = trace(ALONE, commands=[(3.0, LOAD), (0.0, PLAY)], until=10.0)
    first, second = (section_of(each) for each in of_trace(lambda: lines))

    assert (1, "", 2, "world_loaded") == (first.section, first.cause, second.section, second.cause)
    assert ("alone", 0, "meeting", 5) == (
        first.report.world.name,
        first.report.world.seed,
        second.report.world.name,
        second.report.world.seed,
    )
    assert (["wall_e"], ["early", "late"]) == tuple(
        [robot.name for robot in each.report.robots] for each in (first, second)
    )


def test_faults_are_those_of_the_section(reports):
    first, second = reports(FAULTY, commands=[(3.0, RESET)], until=5.0)

    assert [("flat_tyre", 2.0)] == [(fault.name, fault.began) for fault in first.faults]
    assert [("flat_tyre", 2.0)] == [(fault.name, fault.began) for fault in second.faults]


def test_energy_counts_to_the_end_of_the_section(reports):
    """A robot uses 2 units a second until the reset, which fills its battery."""
    first, second = reports(CHARGING, commands=[(3.0, RESET)], until=4.0)

    assert 6.0 == pytest.approx(first.robots[0].energy_used)
    assert 1.0 == second.batteries["wall_e"][0][1]


def test_lines_after_a_difference_are_reported_as_written(trace):
    """The sections before the difference stay exact."""
    lines = trace(ALONE, **TWICE)
    number = next(i for i, line in enumerate(lines) if i > sections_of(lines)[1].line and '"status":4' in line)
    lines[number] = lines[number].replace('"status":4', '"status":6')
    first, second = (report_of(each) for each in of_trace(lambda: lines))

    assert (True, 3.0) == (first.source.exact, first.summary.distance)
    assert (False, None, 3) == (second.source.exact, second.summary.distance, len(second.goals))
    assert f"the replay differs from line {number + 1} on" in second.source.notes[0]


def test_sections_of_another_version_are_separated_by_their_headers(trace, changed):
    lines = changed(trace(ALONE, **TWICE))
    first, second = (report_of(each) for each in of_trace(lambda: lines))

    assert [(0.0, 3.0)] == [(goal.accepted, goal.ended) for goal in first.goals]
    assert [(0.0, 4.0), (4.0, 6.0), (6.0, 10.0)] == [(goal.accepted, goal.ended) for goal in second.goals]
    assert (3.0, True, 12.0, True) == (
        first.summary.sim_time,
        first.source.complete,
        second.summary.sim_time,
        second.source.complete,
    )


def test_a_trace_of_an_earlier_version_is_one_section(trace):
    lines = [line for line in trace(ALONE, **TWICE) if '"section":2' not in line]
    (found,) = (report_of(each) for each in of_trace(lambda: lines))

    assert (False, 15.0, 4) == (found.source.exact, found.summary.sim_time, len(found.goals))
    assert "Simulated time was reset (once); here it continues." in found.source.notes


@pytest.mark.parametrize("exact", [True, False])
def test_sections_before_a_truncated_one_are_complete(trace, changed, exact):
    lines = trace(ALONE, **TWICE)
    lines = lines if exact else changed(lines)
    cut = [*lines[: sections_of(lines)[1].line + 3], lines[-1][:20]]
    first, second = (report_of(each) for each in of_trace(lambda: cut))

    assert (exact, True, exact, False) == (
        first.source.exact,
        first.source.complete,
        second.source.exact,
        second.source.complete,
    )
    assert "The trace is truncated: later events are missing." in second.source.notes


class TestCommand:
    def test_sections_are_listed_and_summarized(self, path, capsys):
        code = main(["report", str(path)])
        lines = capsys.readouterr().out.splitlines()

        assert 0 == code
        assert [
            "section 1, alone, seed 0, 3.000 s, 1 goal",
            "section 2, alone, seed 0, 11.000 s, 3 goals: the simulation was reset",
            "section 3, meeting, seed 5, 10.000 s, 3 goals: a world was loaded",
            "",
            "section 1",
            "alone: 1 robot, 3.000 simulated seconds, seed 0",
        ] == lines[:6]
        assert "meeting: 2 robots, 10.000 simulated seconds, seed 5" in lines

    def test_one_section_has_its_line_and_summary(self, path, capsys):
        code = main(["report", str(path), "--section", "2"])
        lines = capsys.readouterr().out.splitlines()

        assert 0 == code
        assert "section 2, alone, seed 0, 11.000 s, 3 goals: the simulation was reset" == lines[0]
        assert ["alone: 1 robot, 11.000 simulated seconds, seed 0"] == [line for line in lines if "simulated" in line]

    def test_json_has_a_report_per_section(self, path, capsys):
        main(["report", str(path), "--json"])
        found = json.loads(capsys.readouterr().out)

        jsonschema.validate(found, Sections.model_json_schema(mode="serialization"))
        assert [(1, ""), (2, "reset"), (3, "world_loaded")] == [
            (each["section"], each["cause"]) for each in found["sections"]
        ]

    def test_json_of_one_section_is_a_report(self, path, capsys):
        main(["report", str(path), "--json", "--section", "3"])
        found = json.loads(capsys.readouterr().out)

        jsonschema.validate(found, Report.model_json_schema(mode="serialization"))
        assert "meeting" == found["world"]["name"]

    def test_tables_have_a_folder_per_section(self, path, tmp_path):
        main(["report", str(path), "--csv", str(tmp_path / "tables")])
        counts = {}
        for folder in sorted((tmp_path / "tables").iterdir()):
            with (folder / "goals.csv").open(encoding="utf-8", newline="") as lines:
                counts[folder.name] = len(list(csv.DictReader(lines)))

        assert {"section_1": 1, "section_2": 3, "section_3": 3} == counts

    def test_no_table_is_written_over_the_page(self, path, tmp_path, capsys):
        page = tmp_path / "tables" / "section_2" / "goals.csv"
        page.parent.mkdir(parents=True)
        code = main(["report", str(path), "--csv", str(tmp_path / "tables"), "-o", str(page)])

        assert (2, True) == (code, "goals.csv" in capsys.readouterr().err)

    def test_the_page_has_a_part_per_section(self, path, tmp_path):
        page = tmp_path / "report.html"
        main(["report", str(path), "-o", str(page)])
        text = page.read_text(encoding="utf-8")
        ids = [part.partition('"')[0] for part in text.split(' id="')[1:]]
        links = {part.partition('"')[0] for part in text.split('href="#')[1:]}

        assert len(ids) == len(set(ids))
        assert {"section-1", "section-2", "section-3", "section-3-goals"} <= links <= set(ids)
        assert "<td>the simulation was reset</td>" in text
        assert 3 == text.count("<h1>") - 1

    def test_the_page_of_one_section_equals_that_of_one_run(self, path, tmp_path):
        page = tmp_path / "report.html"
        main(["report", str(path), "-o", str(page), "--section", "3"])
        text = page.read_text(encoding="utf-8")

        assert ("<h1>meeting</h1>" in text, 'id="goals"' in text, "section-" in text) == (True, True, False)

    def test_missing_data_is_a_warning_per_section(self, path, capsys):
        path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
        main(["report", str(path)])

        assert f"{path}: section 3: The trace is truncated: later events are missing." in capsys.readouterr().err

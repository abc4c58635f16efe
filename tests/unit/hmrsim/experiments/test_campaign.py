"""Campaigns: the order of runs, the stored results, and executors that break."""

from __future__ import annotations

import os
import random
import sqlite3
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from typing import TYPE_CHECKING, Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from hmrsim.errors import ExperimentError, ResultsError, WriteError
from hmrsim.experiments.campaign import Campaign, Schedule
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.store import FILE, Results, Row
from hmrsim.experiments.table import write_table
from hmrsim.trials.batches import factory_of
from hmrsim.trials.trial import DIED

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.experiments.plan import Plan
    from hmrsim.experiments.replications import Task


def plan_of(folder: Path, **changes: Any) -> Plan:
    """Return a plan of two scenarios and two treatments."""
    tree = {"tree": "bt_controller.examples.hospital:mission"}
    content = {
        "name": "pace",
        "world": "zoo/crossing",
        "factors": {"speed": [0.5, 1.0]},
        "treatments": {"a": tree, "b": tree},
        "replications": 5,
        "measures": {"time": "end.at"},
        **changes,
    }
    path = folder / "pace.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return read_plan(path)


def row_of(plan: Plan, number: int) -> Row:
    """Return a made-up result, which depends on the run alone."""
    run = plan.run_of(number)
    assert run is not None
    value = 10.0 + random.Random(number).gauss(0, 3)
    return Row(run, "succeeded", success=True, at=value, wall=0.001, measures={"time": value})


class Inline(Executor):
    """An executor that does everything at once, and breaks at some runs.

    Args:
        plan: Whose runs it makes up.
        deadly: The numbers of the runs at which it breaks.
    """

    def __init__(self, plan: Plan, deadly: frozenset[int]) -> None:
        self._plan, self._deadly, self._broken = plan, deadly, False

    def submit(self, _function: Any, task: Task, /, *_args: Any, **_kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if self._broken:
            raise BrokenProcessPool
        if self._deadly & {*task.numbers}:
            self._broken = True
            future.set_exception(BrokenProcessPool())
        else:
            future.set_result([row_of(self._plan, number) for number in task.numbers])
        return future


def table(folder: Path) -> list[Any]:
    """Return all rows without their wall times."""
    with Results(folder) as results:
        columns = [name for name in results.columns() if name != "wall"]
        return [tuple(row.values()) for row in results.rows(columns)]


def made(folder: Path, plan: Plan, deadly: frozenset[int] = frozenset(), workers: int = 2) -> list[Any]:
    """Make all runs; return the table."""
    with Results.create(folder, plan) as results:
        Campaign(plan, results, lambda: Inline(plan, deadly), workers).run()
    return table(folder)


def test_all_runs_are_made_once(tmp_path: Path) -> None:
    plan = plan_of(tmp_path)
    rows = made(tmp_path / "r", plan)
    assert [row[0] for row in rows] == [*range(20)]
    assert made(tmp_path / "r", plan) == rows


def test_reports_the_first_mishap_while_runs_continue(tmp_path: Path) -> None:
    """A mission that fails is no mishap."""
    plan, told = plan_of(tmp_path), []
    with Results.create(tmp_path / "r", plan) as results:
        campaign = Campaign(
            plan, results, lambda: Inline(plan, frozenset({3, 5})), 1, lambda now: told.append(now.mishap)
        )
        progress = campaign.run()

    assert {DIED: 2} == progress.failed
    assert None is told[0]
    assert [3] == [*{row.run.number for row in told if row is not None}]


@settings(max_examples=30, deadline=None)
@given(deadly=st.frozensets(st.integers(0, 19)), workers=st.integers(1, 5))
def test_runs_that_break_the_executor_are_rows(
    tmp_path_factory: pytest.TempPathFactory, deadly: frozenset[int], workers: int
) -> None:
    folder = tmp_path_factory.mktemp("broken")
    plan = plan_of(folder)
    whole, found = made(folder / "whole", plan), made(folder / "broken", plan, deadly, workers)
    endings = {row[0]: row[6] for row in found}
    assert {number for number, ending in endings.items() if ending == DIED} == deadly
    assert [row for row in found if row[0] not in deadly] == [row for row in whole if row[0] not in deadly]


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), error=st.floats(0.02, 0.5), kept=st.integers(0, 200))
def test_the_order_of_results_and_a_resumption_change_nothing(
    tmp_path_factory: pytest.TempPathFactory, seed: int, error: float, kept: int
) -> None:
    until = {"measure": "time", "relative_error": error}
    plan = plan_of(tmp_path_factory.mktemp("order"), replications={"min": 3, "max": 20, "until": until})

    def numbers(chance: random.Random, done: dict[int, Any]) -> set[int]:
        schedule, open_runs = Schedule(plan, done), []
        found = set(done)
        while True:
            open_runs += schedule.next(chance.randint(1, 9))
            if not open_runs:
                assert schedule.done == schedule.expected
                return found
            run = open_runs.pop(chance.randrange(len(open_runs)))
            found.add(run.number)
            schedule.note(run, row_of(plan, run.number).measures["time"])

    whole = numbers(random.Random(seed), {})
    again = {number: (row_of(plan, number).measures["time"], "") for number in sorted(whole)[:kept]}
    assert numbers(random.Random(seed + 1), again) == whole


def test_replications_stop_where_the_mean_is_known(tmp_path: Path) -> None:
    until = {"measure": "time", "relative_error": 0.05}
    many = plan_of(tmp_path, replications={"min": 3, "max": 500, "until": until})
    rows = made(tmp_path / "many", many)
    counts = {(row[1], row[2]): sum(each[1:3] == row[1:3] for each in rows) for row in rows}
    assert counts[0, "a"] == counts[0, "b"]
    assert all(30 < count < 400 for count in counts.values())
    with Results(tmp_path / "many") as results:
        assert results.about["replications"]["until"]["measure"] == "time"


@pytest.mark.parametrize("least", [1, 2])
def test_a_mean_is_not_known_before_three_replications(tmp_path: Path, least: int) -> None:
    until = {"measure": "time", "relative_error": 0.5}
    plan = plan_of(tmp_path, replications={"min": least, "max": 9, "until": until})
    schedule = Schedule(plan, {})
    while runs := schedule.next(7):
        for run in runs:
            schedule.note(run, 10.0 + run.number / 1000)

    assert 3 * len(plan.scenarios) * len(plan.treatments) == schedule.done


@pytest.mark.parametrize("margin", [None, 0.0, 0.1])
def test_replications_stop_when_the_comparison_is_decided(tmp_path: Path, margin: float | None) -> None:
    """B takes 0.5 s more than A, give or take 0.2 s, while both vary by 3 s together."""
    until = {"measure": "time", "decided": True}
    measures = {"time": {"value": "end.at", "margin": margin}}
    plan = plan_of(tmp_path, replications={"min": 4, "max": 2000, "until": until}, measures=measures)
    schedule, values = Schedule(plan, {}), {}
    while runs := schedule.next(7):
        for run in runs:
            chance = random.Random(run.seed)
            common, own = chance.gauss(10, 3), random.Random(run.number).gauss(0, 0.2)
            values[run.number] = common + own + (0.5 if run.treatment == "b" else 0.0)
            schedule.note(run, values[run.number])
    assert schedule.done == schedule.expected == len(values)
    assert 16 <= len(values) <= 200


@pytest.mark.parametrize("how", [{"relative_error": 0.01}, {"decided": True}])
def test_repeated_replications_are_enough(tmp_path: Path, how: dict[str, Any]) -> None:
    plan = plan_of(tmp_path, replications={"min": 2, "max": 1000, "until": {"measure": "time", **how}})
    schedule = Schedule(plan, {})
    while runs := schedule.next(7):
        for run in runs:
            schedule.note(run, 10.0 + run.scenario, f"{run.scenario} {run.treatment}")

    assert {2 * len(plan.scenarios) * len(plan.treatments)} == {schedule.done, schedule.expected}


def test_scenario_without_randomness_ends_before_the_others(tmp_path: Path) -> None:
    until = {"measure": "time", "relative_error": 0.01}
    plan = plan_of(tmp_path, replications={"min": 3, "max": 50, "until": until})
    schedule = Schedule(plan, {})
    while runs := schedule.next(7):
        for run in runs:
            value = random.Random(run.number).gauss(10, 3)
            schedule.note(run, value if run.scenario else 10.0, "" if run.scenario else run.treatment)

    assert (3 + 50 * (len(plan.scenarios) - 1)) * len(plan.treatments) == schedule.done


def test_results_of_another_experiment_are_not_mixed_in(tmp_path: Path) -> None:
    made(tmp_path / "r", plan_of(tmp_path))
    with pytest.raises(ResultsError, match="has results of another experiment"):
        Results.create(tmp_path / "r", plan_of(tmp_path, seed=2))


def test_results_of_another_controller_are_not_mixed_in(tmp_path: Path) -> None:
    """Nor are results of another world; a controller without a file counts as unchanged."""
    world, controller = tmp_path / "w.yaml", tmp_path / "drive.py"
    world.write_text("waypoints: {a: [0, 0]}\nrobots: {w: {at: a}}\n")
    controller.write_text("def drive(client):\n    pass\n")
    said: dict[str, Any] = {
        "world": "w.yaml",
        "factors": {},
        "treatments": {"a": {"python": "drive.py:drive"}, "b": {"command": "drive.py"}},
    }
    Results.create(tmp_path / "r", plan_of(tmp_path, **said)).close()
    Results.create(tmp_path / "r", plan_of(tmp_path, **said)).close()

    controller.write_text("def drive(client):\n    return True\n")
    with pytest.raises(ResultsError, match=r"r: has results from before drive\.py was changed, .*another folder"):
        Results.create(tmp_path / "r", plan_of(tmp_path, **said))
    world.write_text("waypoints: {a: [0, 1]}\nrobots: {w: {at: a}}\n")
    with pytest.raises(ResultsError, match=r"r: has results from before the world was changed, "):
        Results.create(tmp_path / "r", plan_of(tmp_path, **said))


def test_one_process_at_a_time_adds_results(tmp_path: Path) -> None:
    plan = plan_of(tmp_path)
    with (
        Results.create(tmp_path / "r", plan) as one,
        Results.create(tmp_path / "r", plan) as two,
        one.writing(),
        pytest.raises(ResultsError, match="another process runs this experiment"),
        two.writing(),
    ):
        pass


def test_a_link_in_place_of_the_lock_is_not_followed(tmp_path: Path) -> None:
    results = Results.create(tmp_path / "r", plan_of(tmp_path))
    target = tmp_path / "thesis.tex"
    target.write_text("text")
    (tmp_path / "r" / "lock").symlink_to(target)
    with results, pytest.raises(ResultsError, match=r"lock: can't be opened for writing"), results.writing():
        pass
    assert target.read_text() == "text"


def test_write_error_ends_the_campaign_without_losses(tmp_path: Path, monkeypatch) -> None:
    plan = plan_of(tmp_path)
    add, count = Results.add, 0

    def fails(self: Results, plan: Plan, rows: Any, _coverages: Any) -> None:
        nonlocal count
        count += 1
        if count == 2:
            self._db.execute(f"PRAGMA max_page_count = {self._db.execute('PRAGMA page_count').fetchone()[0]}")
            rows = [Row(**{**vars(row), "output": "x" * 10**6}) for row in rows]
        add(self, plan, rows)

    monkeypatch.setattr(Results, "add", fails)
    with pytest.raises(WriteError, match="full; those before are kept, and the same command goes on"):
        made(tmp_path / "r", plan)
    before = len(table(tmp_path / "r"))
    assert 0 < before < 20
    monkeypatch.setattr(Results, "add", add)
    assert [row[0] for row in made(tmp_path / "r", plan)] == [*range(20)]


def test_reports_a_trace_that_can_not_be_kept(tmp_path: Path) -> None:
    plan = plan_of(tmp_path)
    with Results.create(tmp_path / "r", plan) as results:
        (tmp_path / "r" / "traces").write_text("a file", encoding="utf-8")
        results.add(plan, [Row(**{**vars(row_of(plan, 0)), "trace": "{}\n"})])
        (row,) = results.rows()
    assert row["cause"].startswith("its trace can't be kept: ")


def test_tables_are_exported(tmp_path: Path) -> None:
    made(tmp_path / "r", plan_of(tmp_path))
    with Results(tmp_path / "r") as results:
        for kind in ("csv", "json", "parquet"):
            write_table(results, tmp_path / f"runs.{kind}")
        with pytest.raises(Exception, match=r"is of no known format; expected one of \.csv, \.json, \.parquet"):
            write_table(results, tmp_path / "runs.xlsx")
    assert len((tmp_path / "runs.csv").read_text(encoding="utf-8").splitlines()) == 21
    assert len(yaml.safe_load((tmp_path / "runs.json").read_text(encoding="utf-8"))) == 20
    with closing(sqlite3.connect(tmp_path / "r" / FILE)) as database:
        assert database.execute("SELECT COUNT(*), AVG(speed) FROM runs").fetchone() == (20, 0.75)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("pol", "expected pool, pool:N, dask, dask://HOST:PORT or MODULE:FACTORY"),
        ("pool:x", "expected a number of processes after pool:, got 'x'"),
        ("nowhere:make", "No module named 'nowhere'"),
        ("json:make", "module 'json' has no function 'make'"),
    ],
)
def test_rejects_unknown_executors(text: str, said: str) -> None:
    with pytest.raises(ExperimentError, match=said):
        factory_of(text, None)


def test_custom_factory_makes_executors() -> None:
    make, workers = factory_of("concurrent.futures:ThreadPoolExecutor", 3)
    assert workers == 3
    make().shutdown()


def test_pool_has_a_process_per_processor_without_affinity_masks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: 5)
    _, workers = factory_of("pool", None)

    assert 5 == workers

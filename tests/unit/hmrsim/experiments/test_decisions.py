"""Experiments that run until the better treatment is decided: the order of pairs, and the verdicts."""

from __future__ import annotations

import json
import random
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import yaml

from hmrsim.cli import main
from hmrsim.experiments.contrast import contrast, sides_of
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.report import summary_of
from hmrsim.experiments.store import Results, Row

if TYPE_CHECKING:
    from hmrsim.experiments.plan import Run

TREE = {"tree": "bt_controller.examples.hospital:mission"}
LEVELS = {"first": -1.0, "second": 1.0, "third": 3.0}
"""By how many seconds B takes longer."""


def by_level(run: Run, level: str) -> float:
    """Return a time: B is faster at the first level, and slower at the others."""
    chance = random.Random(run.seed)
    common, own = chance.gauss(60, 5), random.Random(run.number).gauss(0, 0.1)
    return common + own + (LEVELS[level] if run.treatment == "b" else 0.0)


def by_replication(run: Run, _level: str) -> float:
    """Return a time: B is faster in the first 15 replications and slower in the others; C hardly ever differs."""
    common, own = random.Random(run.seed).gauss(60, 5), random.Random(run.number).gauss(0, 1)
    less = {"a": 0.0, "b": -1.5 if run.replication < 15 else 3.0, "c": 0.1}
    return common + own + less[run.treatment]


def one_or_none(run: Run, _level: str) -> float:
    """Return 0 for A and 1 for B; runs at the first level are not random."""
    return float(run.treatment == "b")


TIMES = {"levels": by_level, "replications": by_replication, "fixed": one_or_none}


class MadeUp(Executor):
    """An executor that makes up the results of an experiment, by the name of the experiment."""

    def submit(self, _function: Any, task: Any, /, *_args: Any, **_kwargs: Any) -> Future[Any]:
        plan = read_plan(Path(task.path))
        future: Future[Any] = Future()
        rows = []
        for number in task.numbers:
            run = plan.run_of(number)
            assert run is not None
            level = plan.scenarios[run.scenario]["level"]
            time = TIMES[plan.file.name](run, level)
            row = Row(run, "succeeded", success=True, at=time, wall=0.001, measures={"time": time})
            same = (plan.file.name, level) == ("fixed", "first")
            rows.append(replace(row, fingerprint="same" if same else ""))
        future.set_result(rows)
        return future


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Return a function that runs an experiment in the folder ``results``, and returns its output."""
    monkeypatch.chdir(tmp_path)

    def made(name: str, treatments: str, *options: str, **replications: Any) -> str:
        content = {
            "name": name,
            "world": "zoo/crossing",
            "factors": {"level": [*LEVELS]},
            "treatments": dict.fromkeys(treatments, TREE),
            "replications": replications,
            "measures": {"time": {"value": "end.at", "better": "smaller"}},
        }
        Path("e.yaml").write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        arguments = ["experiment", "run", "e.yaml", "-o", "results", "--executor", f"{__name__}:MadeUp", *options]
        assert 0 == main(arguments)
        return capsys.readouterr().out

    return made


DECIDED = {"measure": "time", "decided": True}


def test_treatment_faster_at_the_first_level_only_is_worse(run):
    """`until`, `compare` and the report agree, whatever the order of the levels."""
    out = run("levels", "ab", min=2, max=100, until=DECIDED)
    compared = contrast(*sides_of("results:a", "results:b"), measures=["time"])
    with Results(Path("results")) as results:
        (comparison,) = summary_of(results).comparisons
    time, told = compared.comparisons["time"], comparison.measures["time"]

    assert f"time of b compared with a: worse after {time.decided_after} of {compared.pairs} pairs\n" in out
    assert 30 <= compared.pairs <= 90
    assert ("worse", (), ()) == (time.verdict, time.withdrawn, compared.notes)
    assert ("worse", time.decided_after, ()) == (told.verdict, told.decided_after, comparison.notes)
    for bounds in (time.difference, told.difference):
        assert 0 < bounds.low <= bounds.estimate <= bounds.high
        assert 1.0 == pytest.approx(bounds.estimate, abs=0.1)


def test_reports_a_withdrawn_verdict(run):
    out = run("replications", "abc", min=15, max=60, until=DECIDED)
    compared = contrast(*sides_of("results:a", "results:b"), measures=["time"])
    with Results(Path("results")) as results:
        comparison, _ = summary_of(results).comparisons
    note = "'better' withdrawn, since all pairs together contradict what the first ones said"

    lines = [line for line in out.splitlines() if line.startswith("time of ")]
    assert lines[0].startswith("time of b compared with a: worse after ")
    assert lines[0].endswith(f"; {note}")
    assert "time of c compared with a: undecided after 180 pairs" == lines[1]
    assert ("worse", ("better",)) == (compared.comparisons["time"].verdict, compared.comparisons["time"].withdrawn)
    assert (f"time: {note}",) == compared.notes
    assert ("worse", f"time: {note}") == (comparison.measures["time"].verdict, *comparison.notes)


def test_means_of_yes_and_no_are_real_numbers(run):
    out = run("fixed", "ab", min=2, max=100, until=DECIDED)
    compared = contrast(*sides_of("results:a", "results:b"), measures=["time"])
    with Results(Path("results")) as results:
        (comparison,) = summary_of(results).comparisons

    assert "time of b compared with a: worse after 30 of " in out
    assert ("worse", 30) == (compared.comparisons["time"].verdict, compared.comparisons["time"].decided_after)
    assert ("worse", 30) == (comparison.measures["time"].verdict, comparison.measures["time"].decided_after)


def test_json_has_the_verdicts(run):
    out = run("levels", "ab", "--json", min=2, max=100, until=DECIDED)
    *_, before, last = map(json.loads, out.splitlines())

    assert last.pop("over")
    verdicts = last.pop("verdicts")
    assert before == last
    assert {"verdict": "worse", "withdrawn": []}.items() <= verdicts["b"].items()

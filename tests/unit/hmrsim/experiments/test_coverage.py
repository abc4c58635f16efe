"""The coverage of trees in the runs of an experiment."""

from __future__ import annotations

from concurrent.futures import Executor, Future
from typing import TYPE_CHECKING, Any

import pytest
import yaml

from bt_controller.coverage.files import read_coverage
from hmrsim.experiments.campaign import Campaign
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.store import Results

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from bt_controller.coverage import TreeCoverage

TREE = "bt_controller.examples.hospital:mission"


class Here(Executor):
    """An executor that runs everything in this process; a run with a high number acts like Ctrl-C."""

    def __init__(self, most: int = 100) -> None:
        self._most = most

    def submit(self, function: Callable[..., Any], task: Any, /, *_args: Any, **_kwargs: Any) -> Future[Any]:
        if max(task.numbers) > self._most:
            raise KeyboardInterrupt
        future: Future[Any] = Future()
        future.set_result(function(task))
        return future


@pytest.fixture
def experiment(tmp_path: Path) -> Callable[..., Path]:
    """Make an experiment with two runs of each treatment; return the folder of its results."""

    def made(most: int = 100, **keep: Any) -> Path:
        drive = {"python": "math:sqrt"}
        content = {
            "name": "e",
            "world": "hospital",
            "treatments": {"mission": {"tree": TREE, "robots": ["eve"]}, "function": drive},
            "replications": 2,
            "keep": keep,
        }
        (tmp_path / "e.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
        plan = read_plan(tmp_path / "e.yaml")
        with Results.create(tmp_path / "results", plan) as results:
            Campaign(plan, results, lambda: Here(most), 1).run()
        return tmp_path / "results"

    return made


def seen(folder: Path) -> TreeCoverage:
    """Return the coverage of the treatment with a tree."""
    return read_coverage(folder / "coverage_mission.json")


def test_the_runs_of_a_treatment_are_counted_together(experiment: Callable[..., Path]) -> None:
    assert 2 == seen(experiment(coverage=True)).runs(TREE)


def test_treatment_without_a_tree_has_no_coverage(experiment: Callable[..., Path]) -> None:
    assert ["coverage_mission.json"] == [path.name for path in experiment(coverage=True).glob("coverage*")]


def test_keeps_no_coverage_by_default(experiment: Callable[..., Path]) -> None:
    assert [] == [*experiment().glob("coverage*")]


def test_resumed_experiment_counts_no_run_twice(experiment: Callable[..., Path], tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        experiment(most=1, coverage=True)
    assert 1 == seen(tmp_path / "results").runs(TREE)

    assert 2 == seen(experiment(coverage=True)).runs(TREE)


def test_plan_without_coverage_keeps_its_hash(tmp_path: Path) -> None:
    content: dict[str, Any] = {"name": "e", "world": "hospital", "treatments": {"mission": {"tree": TREE}}}
    hashes = []
    for keep in ({}, {"keep": {"coverage": False}}, {"keep": {"coverage": True}}):
        (tmp_path / "e.yaml").write_text(yaml.safe_dump(content | keep), encoding="utf-8")
        hashes.append(read_plan(tmp_path / "e.yaml").hash)

    assert hashes[0] == hashes[1] != hashes[2]

"""Results of experiments that were never run: their rows are made up."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import pytest
import yaml

from hmrsim.experiments.plan import Run
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.store import Results, Row

if TYPE_CHECKING:
    from pathlib import Path

TREE = {"tree": "bt_controller.examples.hospital:mission"}

Made = Callable[[Run, Mapping[str, Any]], Row | None]


def times(run: Run, levels: Mapping[str, Any]) -> Row:
    """Return a result: 10 plus the replication, 6 less if fast; 1 less for b, and another 2 less if fast."""
    fast = levels["speed"] == 1.0
    less = 0 if run.treatment == "a" else 3 if fast else 1
    value = 10.0 + run.replication - 6 * fast - less
    return Row(run, "succeeded", success=True, at=value, measures={"time": value})


@pytest.fixture
def results(tmp_path):
    """Return a function that makes up the results of an experiment; a row that is None is missing."""
    opened = []

    def make(made: Made = times, **changes: Any) -> Results:
        content = {
            "name": "pace",
            "world": "zoo/crossing",
            "factors": {"speed": [0.5, 1.0]},
            "treatments": {"a": TREE, "b": TREE},
            "replications": 5,
            "seed": 7,
            "measures": {"time": "end.at"},
            **changes,
        }
        path: Path = tmp_path / f"pace_{len(opened)}.yaml"
        path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
        plan = read_plan(path)
        cells = len(plan.scenarios) * len(plan.treatments)
        runs = [plan.run_of(number) for number in range(cells * plan.file.replications.max)]
        found = Results.create(tmp_path / f"results_{len(opened)}", plan)
        opened.append(found)
        rows = [made(run, plan.scenarios[run.scenario]) for run in runs if run is not None]
        found.add(plan, [row for row in rows if row is not None])
        return found

    yield make
    for each in opened:
        each.__exit__()

"""An experiment of many short runs: with one worker, with two, and on Dask; start and end of the workers included."""

from __future__ import annotations

import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path
from typing import Any

from benchmarks._report import Row
from benchmarks._spread import Spread

QUICK: dict[str, Any] = {"replications": 8, "rounds": 1}

STUDY = """\
name: study
world: hospital
factors: {{speed: [0.5, 0.8, 1.1], charge: [1000, 2000, 3000], reach: [0.9, 1.0, 1.1]}}
treatments: {{one: {{tree: "bt_controller.examples.hospital:mission", robots: [wall_e]}}}}
replications: {replications}
overlay:
  ~robots.auto: null
  ~robots.vaq_m: null
  robots.wall_e:
    base.speed: $speed
    components: {{battery.initial_charge: $charge, claw.reach: $reach}}
  doors.*.opening_time: {{uniform: {{low: 1, high: 6}}}}
limits: {{simulated: 900}}
measures: {{time: end.at, energy: energy}}
"""

_WHERE = {"one worker": ["-j", "1"], "two workers": ["-j", "2"], "Dask, two workers": ["--executor", "dask", "-j", "2"]}


def run(*, replications: int = 48, rounds: int = 3) -> list[Row]:
    """Return how long a study of 27 scenarios takes, with six robots of which one drives.

    Args:
        replications: Of each scenario.
        rounds: How often each way has its turn.
    """
    took: dict[str, list[float]] = {name: [] for name in _WHERE}
    tables: set[int] = set()
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        (home / "study.yaml").write_text(STUDY.format(replications=replications), encoding="utf-8")
        for turn in range(rounds):
            for way, options in _WHERE.items():
                folder = home / f"{turn} {way}"
                command = [
                    sys.executable,
                    "-m",
                    "hmrsim.cli",
                    "experiment",
                    "run",
                    "study.yaml",
                    "-o",
                    str(folder),
                    *options,
                ]
                began = time.monotonic()
                subprocess.run(command, cwd=home, check=True, capture_output=True)
                took[way].append(time.monotonic() - began)
                tables.add(_table(folder))
    runs = 27 * replications
    one = Spread.of(took["one worker"])
    rows = [
        Row(
            f"{runs} runs: {way}",
            Spread.of(seconds),
            "s",
            Spread.of(one / each for each in seconds),
            at_most=10.0 if way == "two workers" else None,
        )
        for way, seconds in took.items()
    ]
    return [*rows, Row("different tables of results", len(tables), "", at_most=1)]


def _table(folder: Path) -> int:
    """Return what a table says, but for wall times."""
    with closing(sqlite3.connect(folder / "results.sqlite")) as database:
        names = [f'"{row[1]}"' for row in database.execute("PRAGMA table_info(runs)") if row[1] != "wall"]
        query = f"SELECT {', '.join(names)} FROM runs ORDER BY number"
        return hash(tuple(database.execute(query)))

"""The time and memory for loading large maps."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks._processes import ENVIRONMENT, HMRSIM, ROOT
from benchmarks._report import Row
from benchmarks._spread import Spread

QUICK: dict[str, Any] = {"side": 64, "lanes": 500, "walls": 50, "rounds": 1}

_SECONDS = 3.0
_MEGABYTES = 300.0
_PILLAR = 8
"""Each cell whose column and row are multiples of this is closed."""
_GAP = 2.0
"""Meters between neighbours in the hall."""


def run(*, side: int = 512, lanes: int = 20_000, walls: int = 3_000, rounds: int = 5) -> list[Row]:
    """Return the wall seconds and the peak memory of commands that read a grid, and a hall in YAML."""
    with tempfile.TemporaryDirectory() as folder:
        grid, ride, hall = (Path(folder, name) for name in ("grid.map", "ride.yaml", "hall.yaml"))
        grid.write_text(_grid(side))
        ride.write_text(f"include: [grid.map]\nrobots: {{r: {{at: 1_1, script: [Go {side - 1}_{side - 1}]}}}}\n")
        hall.write_text(_hall(lanes, walls))
        rows = []
        for name, words in (
            (f"map validate, a Moving AI map of {side} x {side}", ("map", "validate", grid)),
            (f"simulate, one goal from corner to corner of {side} x {side}", ("simulate", ride)),
            (f"map validate, {lanes:,} lanes and {walls:,} walls in YAML", ("map", "validate", hall)),
        ):
            taken = [_run(*HMRSIM, *map(str, words)) for _ in range(rounds)]
            limit = _SECONDS if words[0] == "map" else None
            rows.append(Row(name, Spread.of(seconds for seconds, _ in taken), "s", at_most=limit))
            rows.append(Row(f"{name}: peak memory", max(size for _, size in taken), "MB", at_most=_MEGABYTES))
    return rows


def _run(*words: str) -> tuple[float, float]:
    """Run a command; return its wall seconds, and its peak memory in MB.

    Raises:
        RuntimeError: It failed.
    """
    began = time.perf_counter()
    process = subprocess.Popen(words, cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{words!r} ended with {process.returncode}")
    return seconds, used.ru_maxrss * 1024 / 1e6


def _grid(side: int) -> str:
    """Return a Moving AI map with pillars."""
    rows = ["".join("@."[bool(x % _PILLAR or y % _PILLAR)] for x in range(side)) for y in range(side)]
    return "\n".join(["type octile", f"height {side}", f"width {side}", "map", *rows, ""])


def _hall(lanes: int, walls: int) -> str:
    """Return a lattice of so many lanes with walls between them, as a native world."""
    side = 2
    while 2 * side * (side - 1) < lanes:
        side += 1
    cells = [(x, y) for y in range(side) for x in range(side)]
    joined = [((x, y), to) for x, y in cells for to in ((x + 1, y), (x, y + 1)) if max(to) < side]
    where = [(_GAP * (x + 0.5), _GAP * (y + 0.5)) for x, y in cells[:walls]]
    return "\n".join(
        [
            "waypoints:",
            *(f"  n{x}_{y}: [{_GAP * x}, {_GAP * y}]" for x, y in cells),
            "lanes:",
            *(f"  - [n{x}_{y}, n{to_x}_{to_y}]" for (x, y), (to_x, to_y) in joined[:lanes]),
            "walls:",
            *(f"  - [[{x - _GAP / 4}, {y}], [{x + _GAP / 4}, {y}]]" for x, y in where),
            "",
        ]
    )

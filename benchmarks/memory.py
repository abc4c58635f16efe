"""Memory of the simulator's process, as ``hmrsim run`` serves a world: resident (RSS) and proportional (PSS)."""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks._fleet import SIDE, grid_world
from benchmarks._processes import HMRSIM, command, line_of, memory
from benchmarks._report import Row
from benchmarks._wire import GoalSender
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client

QUICK: dict[str, Any] = {"sizes": (10, 1010)}

_GOALS = 20
_TARGETS = ((450.0, 330.0), (78.0, 86.0))


def run(*, sizes: Sequence[int] = (1000, 2000, 5000), side: int = SIDE) -> list[Row]:
    """Return the memory of scenario 2 after some goals, and by how much each step in size adds, a thousand robots."""
    resident, proportional = _memory("scenario2", "wall_e")
    rows = [
        Row(f"scenario 2 after {_GOALS} goals, RSS", resident, "MB", at_most=65.0),
        Row(f"scenario 2 after {_GOALS} goals, PSS", proportional, "MB"),
    ]
    found = [_of_grid(robots, side) for robots in sizes]
    rows += [Row(f"grid of {robots:,} robots, RSS", size, "MB") for robots, size in zip(sizes, found, strict=True)]
    for (fewer, small), (more, large) in itertools.pairwise(zip(sizes, found, strict=True)):
        growth = (large - small) * 1000 / (more - fewer)
        rows.append(Row(f"growth from {fewer:,} to {more:,} robots", growth, "MB/1,000 robots", at_most=1.5))
    return rows


def _of_grid(robots: int, side: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "grid.yaml")
        path.write_text(grid_world(robots, side=side).model_dump_json(by_alias=True, exclude_unset=True))
        return _memory(str(path), "robot_0")[0]


def _memory(world: str, robot: str) -> tuple[float, float]:
    """Serve a world as a user does, have a robot do some goals, and return the simulator's RSS and PSS."""
    words = ("run", world, "--real-time-factor", "0", "--listen", "tcp/127.0.0.1:0")
    with command(*HMRSIM, *words) as process:
        endpoint = line_of(process).split()[1]
        with open_client(SessionOptions(connect=(endpoint,))) as session:
            for x, y in itertools.islice(itertools.cycle(_TARGETS), _GOALS):
                goal = {"pose": {"pose": {"position": {"x": x, "y": y}}}}
                GoalSender(session, f"{robot}/navigate_to_pose", goal).one_by_one()
            return memory(process.pid)

"""Measures that keep a simulator's memory level for hours."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tests.torture import soak
from tests.torture._simulator import simulator

pytestmark = pytest.mark.uncovered

MAPS = "/proc/{}/maps"
_ARENA = 64 << 20
"""Bytes; glibc maps each further heap at a multiple of so many."""


@pytest.mark.skipif(not Path(MAPS.format("self")).exists(), reason="reads Linux's /proc")
def test_all_threads_share_few_heaps(tmp_path):
    world = tmp_path / "world.json"
    world.write_text(json.dumps(soak.world()))
    with simulator(world, tmp_path / "log.txt") as running, running.session() as session:
        assert list(session.get("hmrsim/robot_0/odom"))
        maps = Path(MAPS.format(running.process.pid)).read_text()
        threads = len(list(Path(f"/proc/{running.process.pid}/task").iterdir()))
        running.end()
    begins = [int(begin, 16) for begin in re.findall(r"^([0-9a-f]+)-[0-9a-f]+ rw-p 0+ 00:00 0\s*$", maps, re.MULTILINE)]

    assert threads > 5
    assert len([begin for begin in begins if begin % _ARENA == 0]) <= 2

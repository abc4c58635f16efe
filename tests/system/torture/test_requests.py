"""A small sample of the requests that `make torture` sends."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hmrsim.cli import main
from tests.torture import requests
from tests.torture._simulator import simulator

pytestmark = pytest.mark.uncovered


@pytest.mark.skipif(not Path("/proc/self/smaps_rollup").exists(), reason="reads Linux's /proc")
def test_no_request_crashes_the_simulator_and_a_replay_agrees(tmp_path):
    world, log, trace = tmp_path / "world.json", tmp_path / "log.txt", tmp_path / "trace.jsonl"
    world.write_text(json.dumps(requests.WORLD_FILE))
    with simulator(world, log, "--real-time-factor", "0", "--ros2", "--trace", str(trace)) as running:
        ledger = requests.torture(running, 2_000, seed=7)
        running.end()

    assert [] == ledger.flaws
    assert 2_000 == ledger.answers.total()
    assert 3 == len(ledger.answers)
    # What happens in the world may be logged as an error, such as a battery that is empty after so much time.
    assert [] == [line for line in log.read_text().splitlines() if " | sim " not in line]
    assert 0 == main(["replay", str(trace)])

"""Missions within one process are those over Zenoh: what the client sees, and the trace, byte for byte.

``python -m tests.torture.missions`` tries many more.
"""

from __future__ import annotations

import pytest

from tests.torture import missions


@pytest.mark.parametrize("seed", range(2 * len(missions.WORLDS)))
def test_a_random_mission_has_the_same_trace_in_process_and_over_zenoh(seed):
    assert "" == missions.compare(missions.WORLDS[seed % len(missions.WORLDS)], seed)

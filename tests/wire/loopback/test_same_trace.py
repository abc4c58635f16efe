"""Missions within one process are those over Zenoh: what the client sees, and the trace, byte for byte.

``python -m tests.torture.missions`` tries many more.
"""

from __future__ import annotations

import pytest

from tests.torture import missions


@pytest.mark.parametrize("seed", range(2 * len(missions.WORLDS)))
def test_a_mission_by_chance(seed):
    """With goals, cancels, faults, resets and subscriptions."""
    assert "" == missions.compare(missions.WORLDS[seed % len(missions.WORLDS)], seed)

"""How often Python's garbage is collected."""

from __future__ import annotations

import gc

import pytest

from hmrsim.program.garbage import collect_runs_young
from hmrsim.testing import simulation

WORLD = {"waypoints": {"a": [0, 0]}, "robots": {"ann": {"at": "a"}}}


@pytest.fixture(autouse=True)
def thresholds():
    """Have the settings of the process again afterwards."""
    before = gc.get_threshold()
    yield
    gc.set_threshold(*before)


def test_the_runs_of_tests_do_not_grow_old():
    """Those that are over are found without a look at all that is loaded."""
    gc.set_threshold(700, 10, 10)
    with simulation(WORLD):
        pass
    before = gc.get_stats()[1]["collections"]
    for _ in range(100):
        with simulation(WORLD):
            pass

    assert before == gc.get_stats()[1]["collections"]


@pytest.mark.parametrize("own", [(0, 10, 10), (100_000, 1, 1)])
def test_settings_that_are_rarer_are_kept(own):
    """They are somebody's own."""
    gc.set_threshold(*own)
    collect_runs_young()

    assert own == gc.get_threshold()

"""Garbage collection, and the C library's heap."""

from __future__ import annotations

import gc
import sys

import pytest

from hmrsim.program import memory
from hmrsim.program.memory import collect_runs_young
from hmrsim.testing import simulation
from tests.torture._simulator import allocated

WORLD = {"waypoints": {"a": [0, 0]}, "robots": {"ann": {"at": "a"}}}


@pytest.fixture(autouse=True)
def thresholds():
    before = gc.get_threshold()
    yield
    gc.set_threshold(*before)


def test_finished_runs_are_freed_cheaply():
    """A collection must not traverse everything that is loaded."""
    gc.set_threshold(700, 10, 10)
    with simulation(WORLD):
        pass
    before = gc.get_stats()[1]["collections"]
    for _ in range(100):
        with simulation(WORLD):
            pass

    assert before == gc.get_stats()[1]["collections"]


@pytest.mark.parametrize("own", [(0, 10, 10), (100_000, 1, 1)])
def test_less_frequent_collections_are_kept(own):
    gc.set_threshold(*own)
    collect_runs_young()

    assert own == gc.get_threshold()


@pytest.mark.skipif(sys.platform != "linux", reason="reads Linux's /proc")
def test_free_memory_is_returned_once_a_minute(monkeypatch):
    """The heap shrinks even if its most recent allocation is in use."""
    now = [0.0]
    monkeypatch.setattr(memory.time, "monotonic", lambda: now[0])
    heap = memory.Heap()
    pieces = [bytes(2_000) for _ in range(20_000)]
    last = pieces.pop()
    del pieces
    sizes = []
    for now[0] in (59.0, 60.0):
        heap.trim()
        sizes.append(allocated("self"))

    assert last
    assert sizes[1] < sizes[0] - 20e6

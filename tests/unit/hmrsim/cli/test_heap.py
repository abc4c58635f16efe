"""The C library's heap stays small."""

from __future__ import annotations

import sys

import pytest

from hmrsim.cli import heap
from tests.torture._simulator import allocated


@pytest.mark.skipif(sys.platform != "linux", reason="reads Linux's /proc")
def test_free_memory_is_given_back_once_a_minute(monkeypatch):
    """Although what was allocated last is still there."""
    now = [0.0]
    monkeypatch.setattr(heap.time, "monotonic", lambda: now[0])
    tidied = heap.Heap()
    pieces = [bytes(2_000) for _ in range(20_000)]
    last = pieces.pop()
    del pieces
    sizes = []
    for now[0] in (59.0, 60.0):
        tidied.give_back()
        sizes.append(allocated("self"))

    assert last
    assert sizes[1] < sizes[0] - 20e6

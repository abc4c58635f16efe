"""The guards of a run: its limits of time and memory."""

from __future__ import annotations

import gc
import weakref

import pytest

from hmrsim.experiments.model import Limits
from hmrsim.trials.guards import attempt, ending_of_lost


@pytest.mark.parametrize(("seconds", "ending"), [(0.1, "died"), (34.9, "died"), (35.0, "hung")])
def test_run_without_its_process_hung_if_the_guard_was_due(seconds, ending):
    """A worker that dies before the guard is due did not hang."""
    assert ending == ending_of_lost(Limits(wall=20.0, processor=60.0), seconds)[0]


class _Cycle:
    def __init__(self):
        self.itself = self


def test_a_run_that_has_ended_is_freed_at_once():
    """Its objects refer to each other, and are collected while they are still in the processor's caches."""
    gc.disable()
    try:
        freed = attempt(Limits(), lambda: weakref.ref(_Cycle()), lambda *_ended: None).result
    finally:
        gc.enable()

    assert freed() is None

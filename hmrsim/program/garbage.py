"""The settings of Python's garbage collector in processes that run commands, or trials."""

from __future__ import annotations

import gc
from typing import Final

_THRESHOLDS: Final = (50_000, 20, 10)
_OF_TRIALS: Final = (50_000, 10, 5)


def raise_thresholds() -> None:
    """Collect less often than by default: what a command loads stays until its end."""
    gc.set_threshold(*_THRESHOLDS)


def collect_rarely() -> None:
    """Exclude existing objects from garbage collection, and collect the others less often.

    A simulation makes few cycles and many objects that live for a lane or a goal; with a thousand robots the
    defaults spend a fifth of the time on traversing them.
    """
    gc.freeze()
    raise_thresholds()


def collect_runs_young() -> None:
    """Collect so rarely that most runs are over by then; settings that are as rare, or of nothing at all, are kept.

    All objects of a run refer to each other, so that the collector alone frees them. By the defaults of Python they
    count as old by then, and are looked for among all that is loaded, which took a quarter of the time of a short run.
    """
    if 0 < gc.get_threshold()[0] < _OF_TRIALS[0]:
        gc.set_threshold(*_OF_TRIALS)

"""The settings of Python's garbage collector in a process that runs one command."""

from __future__ import annotations

import gc
from typing import Final

_THRESHOLDS: Final = (50_000, 20, 10)


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

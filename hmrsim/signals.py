"""Ctrl-C and SIGTERM as calls."""

from __future__ import annotations

import signal
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
"""Those that mean an end."""

_SIGNALLED: Final = 128


def exit_code_of(number: int) -> int:
    """Return what a shell makes of a process that a signal has ended."""
    return _SIGNALLED + number


@contextmanager
def on_signals(call: Callable[[int], None]) -> Iterator[None]:
    """Call with the signal's number on SIGINT and SIGTERM; in the main thread only.

    The call comes in the middle of whatever the main thread does, so it must take no lock:
    ``list.append`` and ``SimpleQueue.put`` are safe, ``Event.set`` is not.
    """
    before = {number: signal.signal(number, lambda number, _frame: call(number)) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)

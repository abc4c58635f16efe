"""Ctrl-C and SIGTERM as calls."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final

SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
"""Those that mean an end."""

INTERRUPTED: Final = 130
"""What a shell makes of a process that Ctrl-C has ended."""

_SIGNALLED: Final = 128


def exit_code_of(number: int) -> int:
    """Return what a shell makes of a process that a signal has ended."""
    return _SIGNALLED + number


def must_leave(code: int) -> bool:
    """Return whether the process has to end by `leave`.

    After Ctrl-C, Python would end it by SIGINT if the interrupt came while a class was being made: it remembers an
    interrupt that left an ``exec``, even one that was caught afterwards. And a thread of Zenoh's that calls Python
    while it ends crashes the process, which may happen as long as an answer is awaited.
    """
    return code == INTERRUPTED or "zenoh" in sys.modules


def leave(code: int) -> None:
    """End the process with a code at once, without Python's own end."""
    with suppress(OSError, ValueError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


@contextmanager
def on_signals(call: Callable[[int], None]) -> Iterator[None]:
    """Call with the signal's number on SIGINT and SIGTERM; in the main thread only.

    The call interrupts the main thread at any point, so it must take no lock:
    ``list.append`` and ``SimpleQueue.put`` are safe, ``Event.set`` is not.
    """
    before = {number: signal.signal(number, lambda number, _frame: call(number)) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)

"""Ctrl-C and SIGTERM as calls, also while the main thread waits."""

from __future__ import annotations

import os
import signal
import sys
import threading
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
    """Call with the signal's number on SIGINT and SIGTERM, in a thread of its own; in the main thread only.

    Python calls a handler in the main thread, when that next runs Python code: not at all where the signal came just
    before it began to wait for a queue.
    """
    heard, written = os.pipe()
    os.set_blocking(written, False)
    listener = threading.Thread(target=_listen, args=(heard, call), name="signals", daemon=True)
    listener.start()
    descriptor = signal.set_wakeup_fd(written, warn_on_full_buffer=False)
    before = {number: signal.signal(number, _go_on) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(descriptor)
        os.close(written)
        listener.join()


def _go_on(_number: int, _frame: object) -> None:
    """Handle a signal in the main thread, where it has nothing to do."""


def _listen(heard: int, call: Callable[[int], None]) -> None:
    """Call with the numbers that Python writes as signals come, until the other end is closed."""
    with open(heard, "rb", buffering=0) as numbers:
        while number := numbers.read(1):
            # Other signals' handlers are others' business.
            if number[0] in SIGNALS:
                call(number[0])

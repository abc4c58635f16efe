"""Handling of Ctrl-C and SIGTERM, also while the main thread waits."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final

SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)
"""The signals that end a command."""

INTERRUPTED: Final = 130
"""The exit code of a process that was ended by Ctrl-C, as in a shell."""

_SIGNALLED: Final = 128


def exit_code_of(number: int) -> int:
    """Return the exit code of a process that was ended by a signal, as in a shell."""
    return _SIGNALLED + number


def must_leave(code: int) -> bool:
    """Return whether the process has to end with `leave`.

    If Ctrl-C interrupts the creation of a class, Python later ends the process by SIGINT, even if the exception was
    caught. And a thread of Zenoh's that calls Python while the interpreter exits crashes the process, which can happen
    while a reply is pending.
    """
    return code == INTERRUPTED or "zenoh" in sys.modules


def leave(code: int) -> None:
    """Exit at once with a code, without finalizing Python."""
    with suppress(OSError, ValueError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(code)


@contextmanager
def on_signals(call: Callable[[int], None]) -> Iterator[None]:
    """Call a function with the signal's number on SIGINT and SIGTERM, in a separate thread.

    To be entered in the main thread. A usual handler is called in the main thread when that next runs Python code,
    which may be never if the signal arrives just before the thread waits for a queue.
    """
    heard, written = os.pipe()
    os.set_blocking(written, False)
    listener = threading.Thread(target=_listen, args=(heard, call), name="signals", daemon=True)
    listener.start()
    descriptor = signal.set_wakeup_fd(written, warn_on_full_buffer=False)
    before = {number: signal.signal(number, _do_nothing) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(descriptor)
        os.close(written)
        listener.join()


def _do_nothing(_number: int, _frame: object) -> None:
    """Do nothing in the main thread."""


def _listen(heard: int, call: Callable[[int], None]) -> None:
    """Call the function with the signal numbers that Python writes, until the other end is closed."""
    with open(heard, "rb", buffering=0) as numbers:
        while number := numbers.read(1):
            # Other signals have their own handlers.
            if number[0] in SIGNALS:
                call(number[0])

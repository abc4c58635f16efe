"""Ctrl-C and SIGTERM, also while a behaviour does not return."""

from __future__ import annotations

import os
import select
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final

from hmrsim.program.signals import SIGNALS, exit_code_of, on_signals

_PATIENCE: Final = 4.0
"""Wall seconds for a regular stop: longer than the grace period of canceled goals."""

_OVER: Final = 0
"""Ends the watch; no signal has this number."""


@contextmanager
def on_interrupt(stop: Callable[[], None], give_up: Callable[[], None]) -> Iterator[list[int]]:
    """Stop regularly on the first SIGINT or SIGTERM, and end the process on the second or after a time limit.

    The signals are heard by a thread of its own: the main thread may be in a behaviour that blocks, even in C.
    Yields where it keeps the numbers of the signals. In the main thread only.

    Args:
        stop: Asks for an end; called at the first signal.
        give_up: Does what can be done without the main thread; then the process ends.
    """
    numbers: list[int] = []
    ear, mouth = socket.socketpair()
    with ear, mouth, on_signals(lambda _number: None):
        mouth.setblocking(False)
        before = signal.set_wakeup_fd(mouth.fileno(), warn_on_full_buffer=False)
        watch = threading.Thread(target=_watch, args=(ear, numbers, stop, give_up), daemon=True)
        watch.start()
        try:
            yield numbers
        finally:
            signal.set_wakeup_fd(before)
            mouth.send(bytes([_OVER]))
            watch.join()


def _watch(ear: socket.socket, numbers: list[int], stop: Callable[[], None], give_up: Callable[[], None]) -> None:
    first = _next(ear, None)
    if first == _OVER:
        return
    numbers.append(first)
    stop()
    with suppress(TimeoutError):
        if _next(ear, _PATIENCE) == _OVER:
            return
    # Whatever happens now must not keep the process alive.
    with suppress(Exception):
        give_up()
    os._exit(exit_code_of(first))


def _next(ear: socket.socket, timeout: float | None) -> int:
    """Return the next of the signals that mean an end, or `_OVER`; other signals' handlers are others' business.

    Raises:
        TimeoutError: None came in *timeout* wall seconds.
    """
    while True:
        if not select.select([ear], [], [], timeout)[0]:
            raise TimeoutError
        number = ear.recv(1)[0]
        if number in (*SIGNALS, _OVER):
            return number

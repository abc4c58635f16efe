"""Ctrl-C and SIGTERM, also while a behavior does not return."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final

from hmrsim.program.signals import exit_code_of, on_signals

_PATIENCE: Final = 4.0
"""Wall seconds for a regular stop: longer than the grace period of canceled goals."""

_OVER: Final = 0
"""Ends the watch; no signal has this number."""


@contextmanager
def on_interrupt(stop: Callable[[], None], give_up: Callable[[], None]) -> Iterator[list[int]]:
    """Stop regularly on the first SIGINT or SIGTERM, and end the process on the second or after a time limit.

    The signals are heard by a thread of its own: the main thread may be in a behavior that blocks, even in C.
    Yields where it keeps the numbers of the signals. In the main thread only.

    Args:
        stop: Asks for an end; called at the first signal.
        give_up: Does what can be done without the main thread; then the process ends.
    """
    numbers: list[int] = []
    heard: queue.SimpleQueue[int] = queue.SimpleQueue()
    with on_signals(heard.put):
        watch = threading.Thread(target=_watch, args=(heard, numbers, stop, give_up), daemon=True)
        watch.start()
        try:
            yield numbers
        finally:
            heard.put(_OVER)
            watch.join()


def _watch(
    heard: queue.SimpleQueue[int], numbers: list[int], stop: Callable[[], None], give_up: Callable[[], None]
) -> None:
    first = heard.get()
    if first == _OVER:
        return
    numbers.append(first)
    stop()
    with suppress(queue.Empty):
        if heard.get(timeout=_PATIENCE) == _OVER:
            return
    # Whatever happens now must not keep the process alive.
    with suppress(Exception):
        give_up()
    os._exit(exit_code_of(first))

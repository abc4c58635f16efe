"""The C library's heap in a process that runs for hours."""

from __future__ import annotations

import ctypes
import os
import sys
import time
from typing import Final

_M_ARENA_MAX: Final = -8
_M_MMAP_THRESHOLD: Final = -3
"""Of glibc's ``mallopt``."""
_ARENAS: Final = 2
_MAX_PIECE: Final = 32_768
"""Bytes; Zenoh's buffers of 64 KiB are larger."""

_EVERY: Final = 60.0
"""Wall seconds between two times that free memory is given back: it takes some milliseconds, and Python goes on."""


class Heap:
    """The heap of this process, with few arenas for all threads; to be made before any of them begins.

    By default glibc gives each of Zenoh's threads an arena of its own. What one allocates another frees, and free
    pieces pile up in each: memory grows for hours, with nothing in it. So it does where small pieces that stay come to
    lie between the large buffers of sessions that go: those get pages of their own, which are given back at once. The
    environment may say otherwise, as glibc documents it. Nothing is done where the C library is not glibc.
    """

    def __init__(self) -> None:
        library = ctypes.CDLL(None) if sys.platform == "linux" else None
        self._trim = getattr(library, "malloc_trim", None)
        self._due = time.monotonic() + _EVERY
        mallopt = getattr(library, "mallopt", None)
        if mallopt is not None and "MALLOC_ARENA_MAX" not in os.environ:
            mallopt(_M_ARENA_MAX, _ARENAS)
        if mallopt is not None and "MALLOC_MMAP_THRESHOLD_" not in os.environ:
            mallopt(_M_MMAP_THRESHOLD, _MAX_PIECE)

    def give_back(self) -> None:
        """Give free memory back to the system, once a minute; to be called now and then."""
        now = time.monotonic()
        if self._trim is not None and now >= self._due:
            self._due = now + _EVERY
            self._trim(0)

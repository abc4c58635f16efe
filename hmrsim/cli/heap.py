"""The settings of the C library's heap in a process that runs for hours."""

from __future__ import annotations

import ctypes
import os
import sys
from typing import Final

_M_ARENA_MAX: Final = -8
"""Of glibc's ``mallopt``."""
_ARENAS: Final = 2


def use_few_arenas() -> None:
    """Have all threads share a few heaps, before any of them begins, unless the environment says how many.

    By default glibc gives each of Zenoh's threads one of its own. What one allocates another frees, and free pieces
    pile up in each: memory grows for hours, with nothing in it.
    """
    if sys.platform == "linux" and "MALLOC_ARENA_MAX" not in os.environ:
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            mallopt(_M_ARENA_MAX, _ARENAS)

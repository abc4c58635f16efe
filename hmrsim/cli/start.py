"""The start of ``hmrsim``: signal handlers are installed before slow imports."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from typing import Final

from hmrsim.program.signals import INTERRUPTED, leave, must_leave, on_signals

_SERVING: Final = ("run", "view", "record")
"""Commands that a signal ends successfully, whenever it arrives."""

_DONE: Final = 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Args:
        argv: The arguments after ``hmrsim``; those of this process if None.
    """
    words = sys.argv[1:] if argv is None else argv
    try:
        with on_signals(_end) if words and words[0] in _SERVING else nullcontext():
            from hmrsim.cli.entry import main as run  # noqa: PLC0415 - what takes its time

            code = run(argv)
    except KeyboardInterrupt:
        code = INTERRUPTED
    if argv is None and must_leave(code):
        leave(code)
    return code


def _end(_number: int) -> None:
    """End the process at once: no client is served yet.

    An exception would be lost where Python ignores it, as in its own callbacks during an import.
    """
    os._exit(_DONE)

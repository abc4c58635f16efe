"""A child process that ends when its parent does, on Linux however the parent ends.

``python -m hmrsim.cli.child PARENT_PID MODULE:FUNCTION ARGUMENT…`` calls a command's main function with the
arguments. Linux sends SIGTERM when the parent is gone; elsewhere a child stays if its parent is killed.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import signal
import sys
from collections.abc import Sequence
from typing import Final

from hmrsim.program.signals import leave, must_leave

_PR_SET_PDEATHSIG: Final = 1
_ORPHANED: Final = 1


def main(argv: Sequence[str]) -> int:
    """Run the command and return its exit code.

    Args:
        argv: The parent's process id, ``module:function``, and the command's own arguments.
    """
    parent, target, *arguments = argv
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if os.getppid() != int(parent):
        return _ORPHANED
    module, _, function = target.partition(":")
    code: int = getattr(importlib.import_module(module), function)(arguments)
    return code


if __name__ == "__main__":
    ended = main(sys.argv[1:])
    if must_leave(ended):
        leave(ended)
    sys.exit(ended)

"""The files that a command reads."""

from __future__ import annotations

import errno
import os
import stat
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from pathlib import Path

MAX_VALUES: Final = 1_000_000
"""Values in a line of a trace or in a message of a recording, more or less, which take some 200 bytes each."""
MAX_VALUES_OF_WORLD: Final = 5_000_000
"""Likewise in a world there; that of the largest grid has 4,000,000."""


def check_regular(path: Path) -> None:
    """Check that there is a file to read; a pipe or a device might never end, and opening it might never return.

    Raises:
        OSError: There is none.
    """
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file")


def has_more_values(text: str | bytes, most: int) -> bool:
    """Return whether JSON has more values than that, more or less, before they take any memory."""
    if len(text) <= most:
        return False
    counts = map(text.count, ",[{") if isinstance(text, str) else map(text.count, (b",", b"[", b"{"))
    return sum(counts) > most

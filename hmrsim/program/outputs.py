"""The files that a command writes: none of them is one that it reads, or another output."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Hashable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, Self

from hmrsim.errors import OutputError, WriteError, reason_of

STDOUT: Final = "-"

NO_SPACE: Final = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EBADF)
"""Errors of writing to a full disk, or to a closed file."""


_ENDINGS: Final = {"--trace": ("a trace", ".jsonl"), "--record": ("a recording", ".mcap")}
_OTHERS: Final = frozenset({".csv", ".html", ".jsonl", ".mcap", ".pdf", ".png", ".sqlite", ".svg", ".yaml", ".yml"})
"""Endings that say what a file is; others, such as .txt or none, say nothing."""


def check_outputs(outputs: Iterable[tuple[str, str | Path | None]], inputs: Iterable[str | Path | None]) -> None:
    """Check that no output is an input or another output, by whatever path; call it before any of them is opened.

    Args:
        outputs: Options and their files; None or ``-`` for none.
        inputs: The files that the command reads; None for none.

    Raises:
        OutputError: One is, or its name ends as that of another kind of file.
    """
    read = {_identity(Path(path)): path for path in inputs if path is not None}
    written: dict[Hashable, str] = {}
    for option, path in outputs:
        if path is None or str(path) == STDOUT or _is_stream(Path(path)):
            continue
        identity = _identity(Path(path))
        if identity in read:
            spelled = "" if str(read[identity]) == str(path) else f" as {read[identity]}"
            raise OutputError(f"{option} {path}: this command reads that file{spelled}; name another")
        if identity in written:
            raise OutputError(f"{written[identity]} and {option} are both {path}; name two files")
        written[identity] = option
        _check_ending(option, Path(path))


def _check_ending(option: str, path: Path) -> None:
    """Refuse a name that ends in what the file isn't: the next command that reads it would be misled."""
    what, right = _ENDINGS.get(option, ("", ""))
    ending = path.suffix.lower()
    if what and ending in _OTHERS and ending not in right:
        raise OutputError(f"{option} {path}: {what} is no {ending} file; expected a name that ends in {right}")


def unwritable(name: str, error: OSError) -> OutputError | WriteError:
    """Return the error of an output: of a full disk, or of a file that is none to write to."""
    kind = WriteError if error.errno in NO_SPACE else OutputError
    return kind(f"{name}: can't be written: {reason_of(error)}")


class TextOutput:
    """A file of text that an option names; what is written is in it at once.

    Raises:
        OutputError: It can't be opened.
        WriteError: The disk is full: opening, writing or closing it.
    """

    def __init__(self, option: str, path: Path) -> None:
        self._name = f"{option} {path}"
        self._failure: Exception | None = None
        with self._errors():
            self._file = path.open("w", encoding="utf-8", newline="\n")

    def __enter__(self) -> Self:
        """Return the file."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close it."""
        self.close()

    def write(self, text: str) -> None:
        """Write text, and flush: a reader finds it there, also after a crash. Nothing follows what was not written."""
        if self._failure is not None:
            raise self._failure
        with self._errors():
            self._file.write(text)
            self._file.flush()

    def close(self) -> None:
        """Close the file."""
        with self._errors():
            self._file.close()

    @contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            # Closing tries to write once more what could not be written.
            with suppress(OSError, AttributeError):
                self._file.close()
            self._failure = unwritable(self._name, error)
            raise self._failure from None


def _identity(path: Path) -> Hashable:
    """Return what all paths to a file have in common."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return os.path.realpath(path)
    except (OSError, ValueError):
        return str(path)
    return found.st_dev, found.st_ino


def _is_stream(path: Path) -> bool:
    """Return whether it is a pipe, a terminal or another device, which several outputs may share."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))

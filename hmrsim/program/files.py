"""The files that a command reads and writes."""

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
"""Error numbers of writing to a full disk, or to a closed file."""

_SUFFIXES: Final = {"--trace": ("a trace", ".jsonl"), "--record": ("a recording", ".mcap")}
_KNOWN_SUFFIXES: Final = frozenset(
    {".csv", ".html", ".jsonl", ".mcap", ".pdf", ".png", ".sqlite", ".svg", ".yaml", ".yml"}
)
"""Suffixes that tell what a file is; others, such as .txt or none, are accepted for any output."""


def check_outputs(outputs: Iterable[tuple[str, str | Path | None]], inputs: Iterable[str | Path | None]) -> None:
    """Check that no output is also an input or another output, under any path; call it before opening them.

    Args:
        outputs: Options and their files; None or ``-`` is ignored.
        inputs: The files that the command reads; None is ignored.

    Raises:
        OutputError: An output is also an input or another output, or its suffix is that of another kind of file.
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
        _check_suffix(option, Path(path))


def _check_suffix(option: str, path: Path) -> None:
    """Check that the suffix is not that of another kind of file, which would mislead the next command that reads it."""
    kind, expected = _SUFFIXES.get(option, ("", ""))
    suffix = path.suffix.lower()
    if kind and suffix in _KNOWN_SUFFIXES and suffix not in expected:
        raise OutputError(f"{option} {path}: {kind} is no {suffix} file; expected a name that ends in {expected}")


def unwritable(name: str, error: OSError) -> OutputError | WriteError:
    """Return the error for an output that can't be written: `WriteError` for a full disk, else `OutputError`."""
    kind = WriteError if error.errno in NO_SPACE else OutputError
    return kind(f"{name}: can't be written: {reason_of(error)}")


def check_writable(option: str, path: Path) -> None:
    """Check that a file can be written, and leave it as it is.

    Raises:
        OutputError: The file can't be written.
        WriteError: The disk is full.
    """
    try:
        is_new = not path.exists()
        path.open("a").close()
        if is_new:
            path.unlink()
    except OSError as error:
        raise unwritable(f"{option} {path}", error) from None


def write_text(option: str, path: Path, text: str) -> None:
    """Write a text file that an option names.

    Raises:
        OutputError: The file can't be written.
        WriteError: The disk is full.
    """
    with TextOutput(option, path) as file:
        file.write(text)


class TextOutput:
    """A text file named by an option, flushed after every write.

    Raises:
        OutputError: The file can't be opened.
        WriteError: The disk is full when opening, writing or closing it.
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
        """Close the file."""
        self.close()

    def write(self, text: str) -> None:
        """Write and flush text, so that it survives a crash; after a failed write, every further write fails."""
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
            # Closing the file tries again to write the buffered text.
            with suppress(OSError, AttributeError):
                self._file.close()
            self._failure = unwritable(self._name, error)
            raise self._failure from None


def _identity(path: Path) -> Hashable:
    """Return a value that is equal for all paths to the same file."""
    try:
        found = path.stat()
    except FileNotFoundError:
        return os.path.realpath(path)
    except (OSError, ValueError):
        return str(path)
    return found.st_dev, found.st_ino


def _is_stream(path: Path) -> bool:
    """Return whether a path is a pipe, a terminal or another device, which several outputs may share."""
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


MAX_VALUES: Final = 1_000_000
"""Approximate limit of values in a line of a trace or a message of a recording; each takes about 200 bytes."""
MAX_VALUES_OF_WORLD: Final = 5_000_000
"""The limit for a world in a trace or a recording; the largest grid has 4,000,000 values."""


def check_regular(path: Path) -> None:
    """Check that a path is a regular file: opening or reading a pipe or a device might never return.

    Raises:
        OSError: It is not, or it does not exist.
    """
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file")


def has_more_values(text: str | bytes, most: int) -> bool:
    """Return whether JSON text has more values than *most*, approximately, without parsing it."""
    if len(text) <= most:
        return False
    counts = map(text.count, ",[{") if isinstance(text, str) else map(text.count, (b",", b"[", b"{"))
    return sum(counts) > most

"""Finding and reading the file that a world comes from."""

from __future__ import annotations

import stat
from pathlib import Path

from hmrsim.diagnostics import instead, meant
from hmrsim.errors import Problem, WorldError, reason_of
from hmrsim.world.shipped import shipped_maps

MAX_BYTES = 16 * 1024 * 1024
"""Maximum size of a file, in bytes."""


def find(source: str | Path) -> Path:
    """Return the file of a source: a path, or the bare name of a shipped world.

    Raises:
        WorldError: There is neither.
    """
    path = Path(source)
    name = str(source)
    if not name:
        raise _error("", "the name of the world is empty; expected a file, or the name of a shipped world")
    try:
        if path.is_file():
            return path
    except OSError as error:  # of a name that is too long
        raise _error(name, f"can't be read: {reason_of(error)}") from None
    shipped = shipped_maps()
    if name in shipped and isinstance(source, str):
        return shipped[name]
    bare = isinstance(source, str) and not path.suffix and (path.name == name or meant(name, shipped) is not None)
    if bare and not path.exists():
        raise _error(name, f"no such file, and no shipped world of that name{instead(name, shipped)}")
    if path.stem in shipped and not path.exists():
        raise _error(name, f"no such file; the shipped world is called {path.stem!r}")
    return path


def read_text(path: Path, file: str) -> str:
    """Return the text of a file.

    *file* is its name as the user knows it, for errors.

    Raises:
        WorldError: It can't be read, is too large, or is not text.
    """
    try:
        # A named pipe or device might never end.
        if not stat.S_ISREG(path.stat().st_mode):
            raise _error(file, f"is {'a folder' if path.is_dir() else 'not a regular file'}; expected a file")
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise _error(file, "no such file") from None
    except OSError as error:
        raise _error(file, f"can't be read: {reason_of(error)}") from None
    except ValueError:
        raise _error(file, "can't be read: its name has a null character") from None
    if len(content) > MAX_BYTES:
        raise _error(file, f"is larger than {MAX_BYTES // 1024 // 1024} MiB")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        message = f"is not UTF-8: byte 0x{content[error.start]:02x}; save it as UTF-8"
        raise WorldError([Problem(file, "", message, line)]) from None


def _error(file: str, message: str) -> WorldError:
    return WorldError([Problem(file, "", message)])

"""The files of worlds: those shipped with hmrsim, and the search for the file of a name."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from hmrsim.diagnostics import instead, meant
from hmrsim.errors import Problem, WorldError, reason_of

_PACKAGE = Path(__file__).resolve().parents[1]


def folder(kind: str) -> Path:
    """Return the folder of the shipped ``maps`` or ``schemas``, in a wheel or in a source checkout."""
    installed = _PACKAGE / "data" / kind
    return installed if installed.is_dir() else _PACKAGE.parent / kind


def shipped_maps() -> dict[str, Path]:
    """Return the shipped worlds by bare name, such as ``hospital`` and ``zoo/crossing``, in order of name."""
    return dict(_maps_in(folder("maps")))


@cache
def _maps_in(maps: Path) -> dict[str, Path]:
    found = {path.relative_to(maps).with_suffix("").as_posix(): path for path in maps.rglob("*.yaml")}
    return dict(sorted(found.items()))


def find(source: str | Path) -> Path:
    """Return the file of a source: a path, or the bare name of a shipped world.

    Raises:
        WorldError: No such file exists, and no shipped world has this name.
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


def _error(file: str, message: str) -> WorldError:
    return WorldError([Problem(file, "", message)])

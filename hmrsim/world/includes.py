"""A world file together with the files that it includes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hmrsim.errors import Problem, WorldError
from hmrsim.world.files import read_text
from hmrsim.world.finding import Finding, shown
from hmrsim.world.formats import choose, registry
from hmrsim.world.merging import Merged, Source

if TYPE_CHECKING:
    from hmrsim.world.formats import Document

_DEEPEST = 10
"""Includes inside each other."""

_MOST_FILES = 100


def read_document(path: Path, file: str) -> Document:
    """Return what a file brings, whatever its format.

    Args:
        path: The file.
        file: Its name as the user knows it, for errors.

    Raises:
        WorldError: It can't be read, or is of no known format.
    """
    text = read_text(path, file)
    kind = choose(path.name, text)
    if kind is None:
        suffixes = ", ".join(sorted(suffix for kind in registry().values() for suffix in kind.suffixes))
        raise WorldError([Problem(file, "", f"is of no known format; expected one of {suffixes}")])
    return kind.read(text, file)


def read_all(path: Path, file: str) -> Merged:
    """Return a file with all that it includes.

    Raises:
        WorldError: The file itself can't be read; what is wrong with the others is in the result.
    """
    merged = Merged(Source(file, read_document(path, file)))
    _include(merged, merged.root, (_real(path),), {_real(path)})
    return merged


def _real(path: Path) -> Path:
    return path.parent.resolve() / path.name


def _include(merged: Merged, source: Source, above: tuple[Path, ...], seen: set[Path]) -> None:
    """Add the files that *source* includes, each once; the last of *above* is its own path."""
    names = source.document.data.get("include", [])
    if not isinstance(names, list):
        finding = Finding(("include",), f"expected a list of files, got {shown(names)}", names)
        merged.problems.append(source.problem(finding))
        return
    for i, name in enumerate(names):
        target = _target(name, above, seen)
        if isinstance(target, str):
            merged.problems.append(source.problem(Finding(("include", i), target, name)))
            merged.complete = False
        elif target not in seen:
            seen.add(target)
            file = str(Path(source.file).parent / name)
            try:
                part = Source(file, read_document(target, file))
            except WorldError as error:
                merged.problems += error.problems
                merged.complete = False
                continue
            merged.add(part)
            _include(merged, part, (*above, target), seen)


def _target(name: object, above: tuple[Path, ...], seen: set[Path]) -> Path | str:
    """Return the file that is meant, or what is wrong with it."""
    if not isinstance(name, str):
        return f"expected the name of a file, got {shown(name)}"
    folder = above[-1].parent
    try:
        target = (folder / name).resolve()
    except (OSError, ValueError, RuntimeError) as error:
        return f"{shown(name)} is no file: {error}"
    wrong = None
    if Path(name).is_absolute() or not target.is_relative_to(folder):
        wrong = "is outside the folder of this file; include files beside or below it"
    elif target in above:
        wrong = "includes this file in turn; take one of the two includes out"
    elif len(above) > _DEEPEST:
        wrong = f"is included {len(above)} deep; at most {_DEEPEST}"
    elif len(seen) >= _MOST_FILES:
        wrong = f"is one file too many; at most {_MOST_FILES}"
    return f"{name!r} {wrong}" if wrong else target

"""A world file together with the files that it includes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, instead, shown
from hmrsim.documents.document import read_text
from hmrsim.errors import Problem, WorldError
from hmrsim.world.files import AS_IT_IS, ReadOptions, shipped_maps
from hmrsim.world.files import folder as shipped_folder
from hmrsim.world.formats import choose, registry
from hmrsim.world.merging import Merged, Source

if TYPE_CHECKING:
    from hmrsim.world.formats import Document

_MAX_DEPTH = 10
"""Maximum depth of nested includes."""

_IN_TURN = "includes this file in turn; remove one of the two includes"

_MAX_FILES = 100

_BARE = re.compile(r"\w+(/\w+)*")
"""The form of the names of shipped worlds."""

_PICTURES = (".png", ".jpg", ".jpeg", ".pdf", ".webp")
"""Suffixes of pictures that draw.io exports."""


def read_document(path: Path, file: str, options: ReadOptions = AS_IT_IS) -> Document:
    """Return the document of a file of any format.

    *file* is its name as the user knows it, for errors.

    Raises:
        WorldError: It can't be read, or is of no known format.
    """
    if path.suffix.lower() in _PICTURES and path.is_file():
        raise WorldError([Problem(file, "", "is a picture; open the drawing in draw.io and save it as .drawio")])
    text = read_text(path, file)
    kind = choose(path.name, text)
    if kind is None:
        suffixes = ", ".join(sorted(suffix for kind in registry().values() for suffix in kind.suffixes))
        raise WorldError([Problem(file, "", f"is of no known format; expected one of {suffixes}")])
    return kind.read(text, file, options)


def read_all(path: Path, file: str, options: ReadOptions = AS_IT_IS) -> Merged:
    """Return a file with all files that it includes.

    Raises:
        WorldError: The file itself can't be read; the problems of the others are in the result.
    """
    merged = Merged(Source(file, read_document(path, file, options)))
    merged.paths.add(_real(path))
    reader = _Includes(merged, options, merged.paths, [merged.root.document])
    reader.add(merged.root, (_real(path),))
    merged.complete = merged.complete and all(document.complete for document in reader.documents)
    merged.problems += _not_taken(options, reader.documents, complete=merged.complete)
    return merged


def _real(path: Path) -> Path:
    return path.parent.resolve() / path.name


def _not_taken(options: ReadOptions, documents: Sequence[Document], *, complete: bool) -> Iterator[Problem]:
    """Yield the options that apply to no file, unless an unreadable file might have used them."""
    if options.page is not None and complete and not any(document.pages for document in documents):
        yield Problem(
            f"--page {options.page}", "", "there are no pages; drawings have them, and levels and layouts count"
        )
    if options.neighbours is not None and complete and not any(document.grid for document in documents):
        yield Problem(f"--neighbours {options.neighbours}", "", "there is no grid; only MovingAI maps are grids")
    robots = [robot for document in documents for robot in document.robots]
    for old, new in options.rename.items():
        if complete and old not in robots:
            yield Problem(f"--rename {old}={new}", "", f"no robot {old!r} of a drawing to rename{instead(old, robots)}")


@dataclass
class _Includes:
    """Adds the files that other files include, each file once."""

    merged: Merged
    options: ReadOptions
    seen: set[Path]
    documents: list[Document]

    def add(self, source: Source, above: tuple[Path, ...]) -> None:
        """Add the files that *source* includes; the last of *above* is its own path."""
        names = source.document.data.get("include", [])
        if not isinstance(names, list):
            finding = Finding(("include",), f"expected a list of files, got {shown(names)}", names)
            self.merged.problems.append(source.problem(finding))
            self.merged.complete = False
            return
        if len(names) > _MAX_FILES:
            finding = Finding(("include",), f"names {len(names)} files; a world includes at most {_MAX_FILES}", names)
            self.merged.problems.append(source.problem(finding))
            self.merged.complete = False
            return
        for i, name in enumerate(names):
            target = _target(name, above, self.seen)
            if isinstance(target, Path) and target.name != Path(name).name:
                # A shipped world, without its suffix; a file of the same name would take precedence.
                self.merged.absent.add(above[-1].parent / name)
            if isinstance(target, str):
                self.merged.problems.append(source.problem(Finding(("include", i), target, name)))
                # The document of a file that includes itself is known already.
                self.merged.complete = self.merged.complete and target.endswith(_IN_TURN)
            elif target not in self.seen:
                self.seen.add(target)
                try:
                    part = self._read(target, str(Path(source.file).parent / name))
                except WorldError as error:
                    self.merged.problems += (_reported_by(source, i, problem) for problem in error.problems)
                    self.merged.complete = False
                else:
                    self.add(part, (*above, target))

    def _read(self, target: Path, file: str) -> Source:
        """Return a file that is included, after its parts were added."""
        part = Source(file, read_document(target, file, self.options))
        self.documents.append(part.document)
        self.merged.add(part)
        return part


def _reported_by(source: Source, number: int, problem: Problem) -> Problem:
    """Return the problem of an included file; without a line, it gets the line of the include."""
    if problem.line is not None:
        return problem
    return source.problem(Finding(("include", number), str(problem), problem.value))


def _target(name: object, above: tuple[Path, ...], seen: set[Path]) -> Path | str:
    """Return the file to include, or the error; a bare name is that of a shipped world unless there is such a file."""
    if not isinstance(name, str):
        return f"expected the name of a file, got {shown(name)}"
    folder = above[-1].parent
    if _BARE.fullmatch(name) and not (folder / name).exists():
        shipped = shipped_maps()
        if name not in shipped:
            return f"{shown(name)} is neither a file nor a shipped world{instead(name, shipped)}"
        folder, name = shipped_folder("maps"), f"{name}.yaml"
    try:
        target = (folder / name).resolve()
    except (OSError, ValueError, RuntimeError) as error:
        return f"{shown(name)} is not a file name: {error}"
    wrong = None
    if Path(name).is_absolute() or not target.is_relative_to(folder):
        wrong = "is outside the folder of this file; include files beside or below it"
    elif target in above:
        wrong = _IN_TURN
    elif len(above) > _MAX_DEPTH:
        wrong = f"is included {len(above)} deep; at most {_MAX_DEPTH}"
    elif len(seen) >= _MAX_FILES:
        wrong = f"exceeds the maximum of {_MAX_FILES} files"
    return f"{name!r} {wrong}" if wrong else target

"""An overlay: a file of changes, or one change of a command line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import Finding
from hmrsim.documents.document import read_document
from hmrsim.documents.yaml_text import Unreadable, read_yaml
from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document
from hmrsim.world.merging import Source
from hmrsim.world.overlays.changes import REMOVE, changes
from hmrsim.world.overlays.flaw import OverlayFlaw
from hmrsim.world.overlays.laying import lay
from hmrsim.world.overlays.tables import read_tables
from hmrsim.world.overlays.work import FLAW, TooMuchWorkError, Work

if TYPE_CHECKING:
    from hmrsim.world.merging import Merged
    from hmrsim.world.overlays.expressions import Names

_TABLES: Final = "tables"


@dataclass(frozen=True)
class Overlay:
    """Changes of a world.

    Attributes:
        source: The file, or the option, that asks for them, with what it says.
        names: The values that its expressions ask for: tables, and the levels of an experiment's factors.
        files: The files that it was read from.
    """

    source: Source
    names: Names = field(default_factory=lambda: MappingProxyType({}))
    files: tuple[Path, ...] = ()

    def lay_over(self, merged: Merged, work: Work) -> None:
        """Make the changes in order; what is wrong with one becomes a problem.

        Raises:
            TooMuchWorkError: They and those that were counted before ask for more than the limit.
        """
        merged.unshare()
        merged.paths.update(self.files)
        merged.problems += [self.source.problem(finding) for finding in self.source.document.findings]
        for change in changes(self.source.document.data, self.names, work):
            if isinstance(change, Finding):
                work.spend(FLAW, change.path)
                merged.problems.append(self.source.problem(change))
                continue
            try:
                for path in lay(merged.data, change, work):
                    merged.claim(path, self.source, change.path)
            except OverlayFlaw as error:
                work.spend(FLAW, change.path)
                merged.problems.append(self.source.problem(Finding(change.path, str(error), change.value)))

    def with_names(self, names: Names) -> Overlay:
        """Return the same overlay with further values for its expressions."""
        return replace(self, names={**self.names, **names})


def lay_all(overlays: Iterable[Overlay], merged: Merged) -> None:
    """Lay overlays over a world in order, with one limit for the work of all.

    Raises:
        WorldError: They ask for more than the limit.
    """
    work = Work()
    for overlay in overlays:
        try:
            overlay.lay_over(merged, work)
        except TooMuchWorkError as error:
            # A world that is half laid would only have errors that follow from this one.
            raise WorldError([overlay.source.problem(Finding(error.path, str(error)))]) from None


def overlay_of(said: Mapping[str, Any], source: str, names: Names = MappingProxyType({})) -> Overlay:
    """Return the overlay that plain values describe; *source* is what they come from, for errors."""
    return Overlay(Source(source, Document(dict(said))), names)


def read_overlay(path: str | Path) -> Overlay:
    """Return the overlay of a YAML or JSON file, with the tables that it names under ``tables``.

    Raises:
        WorldError: It can't be read.
    """
    document = read_document(path, WorldError, "a mapping of paths to values such as robots.*.base.speed: 0.8")
    tables, files, flaws = read_tables(document.data.get(_TABLES, {}), Path(path).parent)
    document.raise_for(replace(flaw, path=(_TABLES, *flaw.path)) for flaw in flaws)
    changes = {key: value for key, value in document.data.items() if key != _TABLES}
    source = Source(document.file, Document(changes, document.line))
    return Overlay(source, tables, (Path(path).absolute(), *files))


def setting(text: str) -> Overlay:
    """Return the change of ``--set PATH=VALUE``, or of ``--set ~PATH``, which takes an entry away.

    Raises:
        WorldError: *text* is neither.
    """
    place = f"--set {text}"
    path, equals, said = text.partition("=")
    if text.startswith(REMOVE) and not equals:
        return Overlay(Source(place, Document({text: None})))
    if not equals or not path.strip() or text.startswith(REMOVE):
        raise WorldError([Problem(place, "", "expected PATH=VALUE such as robots.*.base.speed=0.8, or ~PATH")])
    try:
        value, _, findings = read_yaml(said) if said.strip() else ("", 0, [])
    except Unreadable as error:
        raise WorldError([Problem(place, "", f"the value {error}; put texts with : or # into quotes")]) from None
    if findings:
        raise WorldError([Problem(place, "", finding.message) for finding in findings])
    return Overlay(Source(place, Document({path.strip(): value})))


def overlays_of(files: Iterable[str], settings: Iterable[str]) -> list[Overlay]:
    """Return the overlays of a command line: those of files, and over them single settings.

    Raises:
        WorldError: Some can't be read; it has all problems.
    """
    overlays: list[Overlay] = []
    problems: list[Problem] = []
    for texts, parse in ((files, read_overlay), (settings, setting)):
        for text in texts:
            try:
                overlays.append(parse(text))
            except WorldError as error:
                problems += error.problems
    if problems:
        raise WorldError(problems)
    return overlays

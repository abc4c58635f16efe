"""Files and summaries of coverage: JSON, which can be merged, and LCOV's tracefile for editors and CI services.

In a tracefile, a line is one on which a node stands, and its count is that of the node's ticks. Its branches are the
outcomes of the node: 0 success, 1 failure, 2 canceled, 3 recovered. Trees in Python have no lines. They get those of
an outline with one line per node, which is saved beside the tracefile.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from bt_controller.coverage.node_coverage import ENDINGS, RUNNING, SKIPPED
from bt_controller.coverage.tree_coverage import CoverageError, TreeCoverage
from hmrsim.errors import OutputError, reason_of
from hmrsim.program.files import TextOutput, check_regular, unwritable

if TYPE_CHECKING:
    from bt_controller.coverage.node_coverage import NodeCoverage

JSON: Final = ".json"
INFO: Final = ".info"


def read_coverage(path: Path) -> TreeCoverage:
    """Return the coverage in a file.

    Raises:
        CoverageError: The file can't be read, or is not coverage in JSON.
    """
    try:
        check_regular(path)
        text = path.read_bytes()
    except OSError as error:
        raise CoverageError(f"{path}: can't be read: {reason_of(error)}") from None
    try:
        return TreeCoverage.from_json(text)
    except CoverageError as error:
        raise CoverageError(f"{path}: {error}") from None


def check_format(option: str, path: Path) -> None:
    """Check that a file to write has the suffix of a format.

    Raises:
        OutputError: It has another suffix.
    """
    if path.suffix not in (JSON, INFO):
        raise OutputError(f"{option} {path} has no known format; expected a name that ends with {JSON} or {INFO}")


def check_mergeable(option: str, path: Path) -> None:
    """Check that coverage can be merged into a file, before the trees run.

    Raises:
        CoverageError: The file exists, but is not coverage in JSON.
        OutputError: The suffix is not that of a format, or the folder does not exist.
    """
    check_format(option, path)
    if not path.parent.is_dir():
        raise OutputError(f"{option} {path}: there is no folder {path.parent}")
    if path.suffix == JSON and path.exists():
        read_coverage(path)


def merge_into(option: str, path: Path, coverage: TreeCoverage) -> None:
    """Write coverage to a file; a JSON file keeps the counts that it has already.

    Raises:
        CoverageError: The file is not coverage.
        OutputError: The file can't be written.
        WriteError: The disk is full.
    """
    if path.suffix == JSON and path.exists():
        merged = read_coverage(path)
        merged.merge(coverage)
        coverage = merged
    write_coverage(option, path, coverage)


def write_coverage(option: str, path: Path, coverage: TreeCoverage) -> None:
    """Write coverage in the format of the file's suffix; a JSON file is replaced only when the new one is complete.

    Raises:
        OutputError: The file can't be written.
        WriteError: The disk is full.
    """
    if path.suffix == INFO:
        text, outline = lcov(coverage, outline_beside(path))
        with TextOutput(option, path) as file:
            file.write(text)
        if outline:
            with TextOutput(option, outline_beside(path)) as file:
                file.write(outline)
        return
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    with TextOutput(option, unfinished) as file:
        file.write(json.dumps(coverage.to_json(), indent=1) + "\n")
    try:
        unfinished.replace(path)
    except OSError as error:
        raise unwritable(f"{option} {path}", error) from None


_INDENT: Final = 4
_SUFFIX: Final = ".outline.txt"

Lines: TypeAlias = "dict[int, list[NodeCoverage]]"
"""The nodes on each line of a file."""


def outline_beside(path: Path) -> Path:
    """Return the file of the outline of a tracefile."""
    return path.with_suffix(_SUFFIX)


def lcov(coverage: TreeCoverage, outline: Path) -> tuple[str, str]:
    """Return the text of a tracefile, and that of the outline; the latter is empty if all trees come from files.

    Args:
        coverage: The coverage.
        outline: The file of the outline.
    """
    files: dict[str, Lines] = {}
    drawn: list[str] = []
    for name in coverage.trees:
        nodes = coverage.nodes(name)
        if any(node.origin for node in nodes):
            for file, line, node in _in_files(nodes):
                files.setdefault(str(Path(file).resolve()), {}).setdefault(line, []).append(node)
            continue
        drawn += [*([""] if drawn else []), name]
        for node in nodes:
            drawn.append(f"{' ' * _INDENT * len(node.place)}{node.kind} {node.name}")
            files.setdefault(str(outline.resolve()), {})[len(drawn)] = [node]
    text = "".join(f"{line}\n" for file in sorted(files) for line in _records(file, files[file]))
    return text, "".join(f"{line}\n" for line in drawn)


def _in_files(nodes: Sequence[NodeCoverage]) -> Iterator[tuple[str, int, NodeCoverage]]:
    """Yield files, lines and nodes; a node without an origin is on its parent's line."""
    places: dict[tuple[int, ...], str] = {}
    for node in nodes:
        origin = places[node.place] = node.origin or places.get(node.place[:-1], "")
        file, _, line = origin.rpartition(":")
        if file and line.isdigit():
            yield file, int(line), node


def _records(file: str, lines: Mapping[int, Sequence[NodeCoverage]]) -> Iterator[str]:
    yield "TN:"
    yield f"SF:{file}"
    branches = list(_branches(lines))
    yield from branches
    yield f"BRF:{len(branches)}"
    yield f"BRH:{sum(not branch.endswith((',-', ',0')) for branch in branches)}"
    ticks = {line: sum(node.ticks for node in nodes) for line, nodes in sorted(lines.items())}
    yield from (f"DA:{line},{count}" for line, count in ticks.items())
    yield f"LF:{len(ticks)}"
    yield f"LH:{sum(count > 0 for count in ticks.values())}"
    yield "end_of_record"


def _branches(lines: Mapping[int, Sequence[NodeCoverage]]) -> Iterator[str]:
    for line, nodes in sorted(lines.items()):
        for block, node in enumerate(nodes):
            for outcome in node.points:
                taken = str(node.counts[outcome]) if node.ticks else "-"
                yield f"BRDA:{line},{block},{ENDINGS.index(outcome)},{taken}"


@dataclass(frozen=True)
class Share:
    """The share of the possible outcomes that have occurred.

    Attributes:
        seen: The number of outcomes that have occurred.
        possible: The number of possible outcomes.
    """

    seen: int
    possible: int

    def __str__(self) -> str:
        """Return the numbers and the share."""
        share = f" ({self.seen / self.possible:.0%})" if self.possible else ""
        return f"{self.seen} of {self.possible} outcomes{share}"

    def to_json(self) -> dict[str, Any]:
        """Return the share as JSON values; null for the share of nothing."""
        share = self.seen / self.possible if self.possible else None
        return {"seen": self.seen, "possible": self.possible, "share": share}


def share_of(nodes: Sequence[NodeCoverage]) -> Share:
    """Return the covered share of some nodes."""
    possible = sum(len(node.points) for node in nodes)
    return Share(possible - sum(len(node.missing) for node in nodes), possible)


def goal_ends(node: NodeCoverage) -> dict[str, int]:
    """Return the number of a leaf's goals that neither succeeded nor were canceled, by outcome."""
    return {outcome: count for outcome, count in node.seen.items() if outcome not in (*ENDINGS, RUNNING, SKIPPED)}


def summary(coverage: TreeCoverage) -> dict[str, Any]:
    """Return the counts of all nodes, and the outcomes that never occurred, as JSON values."""
    return {
        "trees": [
            {
                "name": name,
                "runs": coverage.runs(name),
                "covered": share_of(coverage.nodes(name)).to_json(),
                "nodes": [_plain(node) for node in coverage.nodes(name)],
            }
            for name in coverage.trees
        ]
    }


def _plain(node: NodeCoverage) -> dict[str, Any]:
    values = {"path": node.path, "kind": node.kind, "ticks": node.ticks, "counts": node.seen, "never": node.never}
    return {**values, "origin": node.origin} if node.origin else values

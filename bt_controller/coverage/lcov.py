"""Coverage as LCOV's tracefile, which editors and CI services read, and ``genhtml`` makes pages of.

A line is one on which a node stands, and its count is that of the node's ticks. Its branches are what can happen to the
node: 0 success, 1 failure, 2 canceled, 3 recovered. Trees in Python have no lines of their own: their lines are those
of an outline, one for each node, which is saved beside the tracefile.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from bt_controller.coverage.outcomes import ENDINGS

if TYPE_CHECKING:
    from bt_controller.coverage.node_coverage import NodeCoverage
    from bt_controller.coverage.tree_coverage import TreeCoverage

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
        outline: Where the outline is saved.
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
    """Yield files, lines and nodes; a node that no file names is on its parent's line."""
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

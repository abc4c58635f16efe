"""What ``bt-controller coverage`` does: it counts files of coverage together, and prints or writes the result."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from bt_controller.cli._codes import DONE
from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import check_format, goal_ends, read_coverage, share_of, summary, write_coverage
from bt_controller.coverage.node_coverage import ABORTED, ENDINGS, WORDS
from hmrsim.errors import printable
from hmrsim.program.files import check_outputs

if TYPE_CHECKING:
    from bt_controller.coverage import NodeCoverage

_WIDTH: Final = 200
_INDENT: Final = 2
_IMPOSSIBLE: Final = "-"
_NEVER: Final = "never"


def coverage(args: argparse.Namespace) -> int:
    """Show the coverage of the files; return the exit code."""
    if args.output is not None:
        check_outputs([("--output", args.output)], args.files)
        check_format("--output", args.output)
    merged = TreeCoverage()
    for path in args.files:
        merged.merge(read_coverage(path))
    if args.output is not None:
        write_coverage("--output", args.output, merged)
    elif args.json:
        print(json.dumps(summary(merged)))
    else:
        _show(merged, missing=args.missing)
    return DONE


def _show(merged: TreeCoverage, *, missing: bool) -> None:
    console = Console(width=None if Console().is_terminal else _WIDTH, highlight=False)
    for number, name in enumerate(merged.trees):
        nodes, runs = merged.nodes(name), merged.runs(name)
        if number:
            console.print()
        times = "1 run" if runs == 1 else f"{runs:,} runs"
        console.print(Text(f"{printable(name)}: {share_of(nodes)} in {times} of the tree", style="bold"))
        console.print(_table(name, [node for node in nodes if not missing or node.never]))


def _table(tree: str, nodes: list[NodeCoverage]) -> Table:
    table = Table(box=None, pad_edge=False)
    origins = any(node.origin for node in nodes)
    for heading in ("node", "ticks", *WORDS.values(), "goals", *(["line"] if origins else [])):
        left = heading in ("node", "goals", "line")
        table.add_column(heading, justify="left" if left else "right", no_wrap=not left)
    for node in nodes:
        table.add_row(
            Text(f"{' ' * _INDENT * len(node.place)}{printable(node.name)}", style="" if node.ticks else "dim"),
            _count(node.ticks),
            *(_count(node.counts[each]) if each in node.points else Text(_IMPOSSIBLE, "dim") for each in ENDINGS),
            Text(", ".join(f"{count:,} {_words(end)}" for end, count in goal_ends(node).items())),
            *([Text(printable(node.origin.removeprefix(f"{tree}:")))] if origins else []),
        )
    return table


def _count(count: int) -> Text:
    return Text(f"{count:,}") if count else Text(_NEVER, style="red")


def _words(end: str) -> str:
    """Return the end of a goal in words."""
    code = end.removeprefix(ABORTED)
    return f"aborted ({code})" if code != end else end.lower()

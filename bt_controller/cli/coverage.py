"""``bt-controller coverage``: show which nodes the runs of a tree have covered."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Final

from bt_controller.cli._options import DONE, EXIT_CODES
from hmrsim.errors import printable

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

    from bt_controller.coverage import NodeCoverage, TreeCoverage

_EXAMPLES: Final = """\
examples:
  bt-controller run navigate.xml --robot mocha --set goal=kitchen --coverage seen.json
  bt-controller coverage seen.json
  bt-controller coverage monday.json tuesday.json -o both.json
  bt-controller coverage seen.json -o seen.info && genhtml --branch-coverage seen.info -o page
  bt-controller coverage seen.json --json | jq '.trees[].nodes[] | select(.never != []) | {path, never}'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller coverage``."""
    parser.description = (
        "Show which outcomes the nodes of trees had in runs with --coverage, and which possible ones never occurred;"
        " several files are merged."
    )
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="a file written by --coverage FILE.json")
    parser.add_argument("--missing", action="store_true", help="show only nodes with outcomes that never occurred")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="write the coverage to FILE instead: .json, or .info for an LCOV tracefile",
    )
    parser.set_defaults(function=_coverage)


_WIDTH: Final = 200
_INDENT: Final = 2
_IMPOSSIBLE: Final = "-"
_NEVER: Final = "never"


def _coverage(args: argparse.Namespace) -> int:
    from bt_controller.coverage import TreeCoverage
    from bt_controller.coverage.files import check_format, read_coverage, summary, write_coverage
    from hmrsim.program.files import check_outputs

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
    from rich.console import Console
    from rich.text import Text

    from bt_controller.coverage.files import share_of

    console = Console(width=None if Console().is_terminal else _WIDTH, highlight=False)
    for number, name in enumerate(merged.trees):
        nodes, runs = merged.nodes(name), merged.runs(name)
        if number:
            console.print()
        times = "1 run" if runs == 1 else f"{runs:,} runs"
        console.print(Text(f"{printable(name)}: {share_of(nodes)} in {times} of the tree", style="bold"))
        console.print(_table(name, [node for node in nodes if not missing or node.never]))


def _table(tree: str, nodes: list[NodeCoverage]) -> Table:
    from rich.table import Table
    from rich.text import Text

    from bt_controller.coverage.files import goal_ends
    from bt_controller.coverage.node_coverage import ENDINGS, WORDS

    table = Table(box=None, pad_edge=False)
    origins = any(node.origin for node in nodes)
    for heading in ("node", "ticks", *WORDS.values(), "goals", *(["line"] if origins else [])):
        left = heading in ("node", "goals", "line")
        table.add_column(heading, justify="left" if left else "right", no_wrap=not left)
    for node in nodes:
        table.add_row(
            Text(f"{' ' * _INDENT * len(node.place)}{printable(node.name)}", style="" if node.ticks else "dim"),
            _count(node.ticks),
            *(_count(node.counts[ending]) if ending in node.points else Text(_IMPOSSIBLE, "dim") for ending in ENDINGS),
            Text(", ".join(f"{count:,} {_goal_end(end)}" for end, count in goal_ends(node).items())),
            *([Text(printable(node.origin.removeprefix(f"{tree}:")))] if origins else []),
        )
    return table


def _count(count: int) -> Text:
    from rich.text import Text

    return Text(f"{count:,}") if count else Text(_NEVER, style="red")


def _goal_end(end: str) -> str:
    from bt_controller.coverage.node_coverage import ABORTED

    code = end.removeprefix(ABORTED)
    return f"aborted ({code})" if code != end else end.lower()

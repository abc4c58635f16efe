"""``bt-controller coverage``: show which nodes the runs of a tree have covered."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from bt_controller.cli._codes import EXIT_CODES
from hmrsim.program.command_line import Later

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
        "Show what happened to the nodes of trees in runs with --coverage, and what never did although it can; several"
        " files are counted together."
    )
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="a file written by --coverage FILE.json")
    parser.add_argument("--missing", action="store_true", help="show only nodes of which something never happened")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="write it to FILE instead: .json, or .info for LCOV's tracefile",
    )
    parser.set_defaults(command=Later("bt_controller.cli.coverage_table", "coverage"))

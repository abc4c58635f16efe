"""``hmrsim replay``: run a trace again, and report whether the result is the same."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.options import count
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options

_EXAMPLES: Final = """\
A trace has a section for each time that a client began the simulation anew. All are repeated, as each begins with what
those before it have left; --section N ends behind that one.

exit codes: 0 the replay is identical, byte for byte; 1 it is not; 2 the file is not a trace, or has no such section

examples:
  hmrsim replay run.jsonl
  hmrsim replay run.jsonl --section 2
  hmrsim replay run.jsonl --json | jq .difference"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim replay``."""
    parser.description = (
        "Run a trace again without any network or controller, and tell whether it is identical,\n"
        "or where it first differs. A truncated trace is run to its end."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("trace", type=Path, metavar="TRACE", help="a file that --trace has written")
    parser.add_argument(
        "--section", type=count, metavar="N", help="tell of this section, and leave out those behind it (default: all)"
    )
    parser.add_argument("--json", action="store_true", help="print the outcome as one JSON object")
    add_log_options(parser, default="error")
    parser.set_defaults(function=Later("hmrsim.cli.replay_trace", "run_again"))

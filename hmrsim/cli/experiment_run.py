"""``hmrsim experiment run``: the runs of an experiment."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.experiment_options import add_file
from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
exit codes: 0 all runs have a result, whatever it is; 1 results can't be written; 2 the experiment has errors;
130 Ctrl-C

examples:
  hmrsim experiment run delivery.yaml
  hmrsim experiment run delivery.yaml -o results -j 4
  hmrsim experiment run delivery.yaml -o flaky --variant flaky
  hmrsim experiment run delivery.yaml --executor dask://10.0.0.7:8786"""


def jobs(text: str) -> int:
    """Return the number of processes that an option says."""
    if not text.isdecimal() or not 0 < int(text) <= 10_000:  # noqa: PLR2004
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of processes")
    return int(text)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment run``."""
    parser.description = (
        "Make all runs of an experiment, some at a time. Results are kept as they come: the same command goes on\n"
        "where it stopped, also after a crash."
    )
    parser.epilog = _EXAMPLES
    add_file(parser)
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help="the folder of the results (the experiment's name)"
    )
    parser.add_argument("-j", "--jobs", metavar="N", type=jobs, help="processes at once (one a processor)")
    parser.add_argument(
        "--executor",
        metavar="WHERE",
        default="pool",
        help="pool or pool:N processes of this machine, dask, dask://HOST:PORT, or MODULE:FACTORY, which returns a "
        "concurrent.futures.Executor (pool)",
    )
    parser.add_argument("--json", action="store_true", help="print how far it is as JSON, one object a line")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_campaign", "run"))

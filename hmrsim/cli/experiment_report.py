"""``hmrsim experiment report``: the results of an experiment as one page."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.cli.experiment_options import add_results
from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
exit codes: 0 done, also if runs have failed; 1 the page can't be written, or scipy is missing; 2 there are
no results

examples:
  hmrsim experiment report results
  hmrsim experiment report results -o results.html
  hmrsim experiment report results --json | jq '.comparisons[].measures | map_values(.verdict)'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim experiment report``."""
    parser.description = (
        "Write the results of an experiment as one self-contained HTML page: rates and means of each treatment with\n"
        "confidence intervals, verdicts, effects of factors, distributions, and the runs without success. Also while\n"
        "the experiment runs."
    )
    parser.epilog = _EXAMPLES
    add_results(parser)
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="the page; - is the standard output (report.html in the folder)"
    )
    parser.add_argument("--json", action="store_true", help="print what is on the page as one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_page", "report"))

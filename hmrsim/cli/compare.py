"""``hmrsim compare``: two treatments, or two traces."""

from __future__ import annotations

import argparse
from typing import Final

from hmrsim.program.command_line import Later

_EXAMPLES: Final = """\
exit codes: 0 no verdict is worse, the traces are identical; 1 a verdict is worse, the traces differ; 2 they can't be
compared

examples:
  hmrsim compare results:nearest results:planned
  hmrsim compare before after --measure time --margin time=2
  hmrsim compare run_1.jsonl run_2.jsonl"""


def _alpha(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a probability between 0 and 1")
    return value


def _margin(text: str) -> tuple[str, float]:
    name, equals, number = text.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = -1.0
    if not equals or not name or not 0.0 <= value < 1e300:  # noqa: PLR2004 - finite
        raise argparse.ArgumentTypeError(f"{text!r} is not MEASURE=NUMBER with a number that is not negative")
    return name, value


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim compare``."""
    parser.description = (
        "Compare two treatments of experiments, run by run under the same seeds: is B better than A, worse, or\n"
        "equivalent? The verdict may be looked at as often as wanted while the experiments go on. Of two traces, show\n"
        "the first difference."
    )
    parser.epilog = _EXAMPLES
    for name in ("a", "b"):
        parser.add_argument(
            name, metavar=name.upper(), help="DIR or DIR:TREATMENT of an experiment's results, or a trace"
        )
    parser.add_argument(
        "--measure", action="append", default=[], metavar="NAME", help="compare this measure only; repeatable (all)"
    )
    parser.add_argument(
        "--margin",
        action="append",
        default=[],
        metavar="MEASURE=X",
        type=_margin,
        help="differences of the means up to X count as none; repeatable (as the experiment says)",
    )
    parser.add_argument(
        "--alpha", type=_alpha, default=0.05, metavar="P", help="probability that any verdict is false (0.05)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.comparison", "compare"))

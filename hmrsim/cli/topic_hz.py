"""``hmrsim topic hz``: how often a topic is published, by the wall clock."""

from __future__ import annotations

import argparse
import queue
import statistics
import time
from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from hmrsim.cli import numbers
from hmrsim.cli.connection import connected, look_for_simulator
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.topics import find_topic
from hmrsim.program.signals import on_signals
from hmrsim_zenoh.wire.options import ENVIRONMENT

_EXAMPLES: Final = f"""\
examples:
  hmrsim topic hz /mocha/odom
  hmrsim topic hz /_world/clock --window 100 --json

{ENVIRONMENT}"""

_PERIOD: Final = 1.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim topic hz``."""
    parser.description = "Measure how often a topic is published by the wall clock, each second until Ctrl-C."
    parser.epilog = _EXAMPLES
    parser.add_argument("name", metavar="NAME", help="such as /mocha/odom")
    parser.add_argument(
        "--window", type=numbers.count, default=10_000, metavar="N", help="the latest N messages (default: %(default)s)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    parser.set_defaults(function=_hz)
    add_connection_options(parser)


def _hz(args: argparse.Namespace) -> int:
    signals: queue.SimpleQueue[int] = queue.SimpleQueue()
    arrivals: deque[float] = deque(maxlen=args.window + 1)
    with on_signals(signals.put), connected(args) as (client, info):
        topic = find_topic(info, args.name)
        absence = look_for_simulator(client)
        with client.subscribe(topic.key(client.keys), lambda _key, _payload: arrivals.append(time.monotonic())):
            before = 0.0
            while True:
                try:
                    signals.get(timeout=_PERIOD)
                except queue.Empty:
                    absence()
                else:
                    return ExitCode.DONE
                before = _tell(list(arrivals), before, as_json=args.json)


def _tell(arrivals: Sequence[float], before: float, *, as_json: bool) -> float:
    """Print the rate, if anything came after *before*; return when the last message came."""
    if len(arrivals) < 2 or arrivals[-1] == before:  # noqa: PLR2004 - a rate needs two
        warn("no new messages")
        return before
    gaps = [after - one for one, after in pairwise(arrivals)]
    found = {
        "average_rate": 1.0 / statistics.fmean(gaps),
        "min": min(gaps),
        "max": max(gaps),
        "std_dev": statistics.pstdev(gaps),
        "window": len(gaps),
    }
    if as_json:
        show_json(found)
    else:
        show(
            f"average rate: {found['average_rate']:.3f}\n\tmin: {found['min']:.3f}s max: {found['max']:.3f}s "
            f"std dev: {found['std_dev']:.5f}s window: {found['window']}"
        )
    return arrivals[-1]

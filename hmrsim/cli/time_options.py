"""The options that say how a world is run: its seed and trace, and how its time moves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli import numbers
from hmrsim.protocol.time import CLOCKS, REALTIME

if TYPE_CHECKING:
    import argparse
    from collections.abc import Callable

TIME_STANDS: Final = "time passes only while robots do something"


def add_run_options(parser: argparse.ArgumentParser) -> None:
    """Add what every run of a world has."""
    parser.add_argument("--seed", type=int, metavar="N", help="replaces the world's")
    parser.add_argument(
        "--trace", type=Path, metavar="FILE", help="write what happens as lines of JSON, for `hmrsim replay`"
    )


def add_clock_options(
    parser: argparse.ArgumentParser | argparse._ArgumentGroup, factor: Callable[[str], float], default: float
) -> None:
    """Add the clock and its pace.

    Args:
        parser: Of the command, or a group of its options.
        factor: Reads a real-time factor.
        default: The factor if none is given.
    """
    parser.add_argument(
        "--clock",
        choices=CLOCKS,
        default=REALTIME,
        help="how simulated time moves: with the wall; or as far as the controllers that join allow, as fast as the "
        "machine can, and the same each time (default: %(default)s)",
    )
    fast = "; 0: as fast as possible" if factor is numbers.factor else ""
    parser.add_argument(
        "--real-time-factor",
        type=factor,
        default=default,
        metavar="X",
        help=f"simulated seconds a wall second, in real time{fast} (default: %(default)g)",
    )


def add_time_options(parser: argparse.ArgumentParser) -> None:
    """Add how time moves in a simulation that others control."""
    group = parser.add_argument_group("time")
    add_clock_options(group, numbers.factor, 1.0)
    group.add_argument(
        "--participants",
        type=numbers.participants,
        default=1,
        metavar="N|NAME,…",
        help="in lockstep, how many controllers have to join before time moves, or their names (default: 1)",
    )
    group.add_argument(
        "--participant-timeout",
        type=numbers.positive_or_for_ever,
        default=30.0,
        metavar="S",
        help="drop a controller that thinks for more than so many wall seconds; -1: never (default: %(default)g)",
    )
    group.add_argument(
        "--on-participant-loss",
        choices=["continue", "end"],
        default="continue",
        help="whether the run goes on when a controller was dropped (default: %(default)s)",
    )
    group.add_argument(
        "--planner-timeout",
        type=numbers.positive_or_for_ever,
        default=5.0,
        metavar="S",
        help="wall seconds that a planner outside may take for a path, while time stands in lockstep; -1: for ever "
        "(default: %(default)g)",
    )
    group.add_argument(
        "--step-size",
        type=numbers.step,
        default=0.1,
        metavar="SIM_S",
        help="what one step is, for step_simulation and simulate_steps (default: %(default)g)",
    )
    group.add_argument(
        "--duration",
        type=numbers.positive,
        default=math.inf,
        metavar="SIM_S",
        help=f"end after so much simulated time; with --real-time-factor 0 {TIME_STANDS}",
    )

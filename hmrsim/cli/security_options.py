"""Arguments that several commands of ``hmrsim security`` have."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Final

MAX_DAYS: Final = 36_500.0


VARIABLE: Final = "HMRSIM_SECURE"
"""The variable that stands for ``--secure``."""


def add_keystore(parser: argparse.ArgumentParser) -> None:
    """Add the keystore's folder."""
    parser.add_argument("keystore", type=Path, metavar="DIR", help="the folder of the keystore")


def add_days(parser: argparse.ArgumentParser) -> None:
    """Add how long certificates are valid."""
    parser.add_argument(
        "--days",
        type=days,
        default=365.0,
        metavar="N",
        help="how long the certificates are valid, in days (default: %(default)g)",
    )


def days(text: str) -> float:
    """Return a number of days."""
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not 0 < found <= MAX_DAYS:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of days greater than 0, and up to {MAX_DAYS:g}")
    return found


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add that the output is JSON."""
    parser.add_argument("--json", action="store_true", help="print one JSON object")

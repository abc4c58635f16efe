"""Argument types for numbers, with their limits."""

from __future__ import annotations

import argparse
import math

from hmrsim.settings import option
from hmrsim.settings.option import MAX_SECONDS, shortened


def positive(text: str) -> float:
    """Return a number of seconds, or of what they take, greater than 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{shortened(text)!r} is not a finite number")
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not greater than 0")
    if value > MAX_SECONDS:
        raise argparse.ArgumentTypeError(f"{shortened(text)} is greater than {MAX_SECONDS:g}")
    return value


def count(text: str) -> int:
    """Return a whole number greater than 0."""
    try:
        return option.count(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None

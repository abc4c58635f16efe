"""Argument types for numbers, with their limits."""

from __future__ import annotations

import argparse
import math
import re
from typing import Final

_MAX_FACTOR: Final = 1e6
_FOR_EVER: Final = -1
_NANOSECOND: Final = 1e-9
_PARTICIPANT: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def positive(text: str) -> float:
    """Return a number greater than 0."""
    value = number(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f"{text} is not greater than 0")
    return value


def not_negative(text: str) -> float:
    """Return a number of 0 or more."""
    value = number(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is less than 0")
    return value


def positive_or_for_ever(text: str) -> float:
    """Return a number greater than 0; infinite for -1."""
    return math.inf if number(text) == _FOR_EVER else positive(text)


def step(text: str) -> float:
    """Return a number of seconds, a nanosecond at least."""
    value = positive(text)
    if value < _NANOSECOND:
        raise argparse.ArgumentTypeError(f"{text} s is less than a nanosecond")
    return value


def or_for_ever(text: str) -> float:
    """Return a number of 0 or more, or -1."""
    value = number(text)
    if value < 0 and value != _FOR_EVER:
        raise argparse.ArgumentTypeError(f"{text} is less than 0; {_FOR_EVER} is for ever")
    return value


def factor(text: str) -> float:
    """Return a real-time factor: 0, or up to a million."""
    value = not_negative(text)
    if value > _MAX_FACTOR:
        raise argparse.ArgumentTypeError(f"{text} is greater than {_MAX_FACTOR:g}; 0 is as fast as possible")
    return value


def number(text: str) -> float:
    """Return a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not a finite number")
    return value


def count(text: str) -> int:
    """Return a whole number greater than 0."""
    if not text.isdecimal() or int(text) == 0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number greater than 0")
    return int(text)


def participants(text: str) -> int | tuple[str, ...]:
    """Return a whole number greater than 0, or names."""
    if text.isdecimal():
        return count(text)
    names = tuple(name.strip() for name in text.split(","))
    if not all(_PARTICIPANT.fullmatch(name) for name in names):
        raise argparse.ArgumentTypeError(f"{text!r} is neither a number nor names such as nurses,porters")
    return tuple(dict.fromkeys(names))

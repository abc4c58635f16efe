"""Quantities shared by all parts of a report."""

from __future__ import annotations

from typing import Any, Final

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

_DIGITS: Final = 9


def in_seconds(nanoseconds: int) -> float:
    """Return nanoseconds as seconds."""
    return nanoseconds / NANOSECONDS


def rounded(value: float) -> float:
    """Return a sum without the errors of binary arithmetic."""
    return round(value, _DIGITS) + 0.0


def as_text(value: Any) -> str:
    """Return a value if it is text, else an empty text."""
    return value if isinstance(value, str) else ""

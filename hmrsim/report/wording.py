"""Formatting of numbers for people."""

from __future__ import annotations

UNKNOWN = "\N{EN DASH}"
"""The text for unknown and missing values."""

_MINUTE, _HOUR = 60, 3600


def seconds(value: float | None) -> str:
    """Return a length of time."""
    if value is None:
        return UNKNOWN
    if value < _MINUTE:
        return f"{value:.1f} s"
    if value < _HOUR:
        return f"{int(value // _MINUTE)} min {int(value % _MINUTE):02d} s"
    return f"{int(value // _HOUR)} h {int(value % _HOUR // _MINUTE):02d} min"


def times(count: int, what: str = "") -> str:
    """Return a number with its noun."""
    if what:
        return f"{count:,} {what}{'' if count == 1 else 's'}"
    return "once" if count == 1 else f"{count:,} times"


def amount(value: float | None, unit: str = "") -> str:
    """Return a number of about four digits, and its unit."""
    if value is None:
        return UNKNOWN
    digits = 0 if abs(value) >= 1000 else 1  # noqa: PLR2004 - four digits
    return f"{value:,.{digits}f}{f' {unit}' if unit else ''}"


def share(value: float | None) -> str:
    """Return a share in percent."""
    if value is None:
        return UNKNOWN
    percent = 100 * value
    # Shares other than 0 and 1 are not rounded to these.
    if 0 < percent < 0.1 or 99.9 < percent < 100:  # noqa: PLR2004
        return "< 0.1 %" if percent < 1 else "> 99.9 %"
    return f"{percent:.1f} %".replace(".0 %", " %")

"""Formatting of measured numbers, of whatever unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from hmrsim.report.html import UNKNOWN

_LEAST, _MOST = 1e-4, 1e9


def figure(value: float | None, *, sign: bool = False, digits: int = 4) -> str:
    """Return a number with some significant digits, or with all before the point; *sign* shows a plus, too."""
    if value is None:
        return UNKNOWN
    plus = "+" if sign and value > 0 else ""
    if value == 0 or not math.isfinite(value):
        return f"{value + 0.0:g}"
    if not _LEAST <= abs(value) < _MOST:
        return f"{plus}{value:.3e}"
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:,.{decimals}f}"
    return plus + (text.rstrip("0").rstrip(".") if decimals else text)


def points(value: float | None) -> str:
    """Return a difference of two shares, in points of percent."""
    if value is None:
        return UNKNOWN
    text = f"{100 * value:+.1f}".removesuffix(".0")
    return "0 %" if text in {"+0", "-0"} else f"{text} %"


def levels(said: Mapping[str, Any]) -> str:
    """Return the levels of a scenario."""
    return ", ".join(f"{name}={level}" for name, level in said.items()) or UNKNOWN

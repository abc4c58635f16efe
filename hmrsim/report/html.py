"""The page around all reports: one HTML file without external parts, its colors, templates and number formats."""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any, Final

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from hmrsim.drawing import PALETTE, THEMES
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.trace.sections import restart_text


def page_around(title: str, body: Markup, *, script: str = "", style: str = "") -> str:
    """Return a whole page; *script* is the only one that it runs, and *style* is added to that of all reports."""
    page: str = (
        templates()
        .get_template("page.html")
        .render(
            title=title,
            body=body,
            script=Markup(script),  # noqa: S704 - ours
            script_hash=base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
            style=Markup(_palette() + part("page.css") + style),  # noqa: S704 - ours
        )
    )
    return page


@cache
def part(name: str, package: str = __package__) -> str:
    """Return the text of a file of a package."""
    return files(package).joinpath(name).read_text("utf-8")


def templates(package: str = __package__) -> Environment:
    """Return the templates of a package; those of all reports are found as well."""

    def load(name: str) -> str:
        return part(name, package) if files(package).joinpath(name).is_file() else part(name)

    environment = Environment(
        loader=FunctionLoader(load), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "seconds": seconds,
        "amount": amount,
        "share": share,
        "parts": parts,
        "svg": Markup,
        "restart": restart_text,
    }
    return environment


def _palette() -> str:
    """Return the palette as CSS, for both themes."""
    themes = {}
    for theme in THEMES:
        colors = {name.replace("_", "-"): color for name, color in PALETTE[theme].items()}
        colors |= {f"heat-{i}": color for i, color in enumerate(PALETTE["heat"][theme], 1)}
        themes[theme] = "".join(f"--{name}:{color};" for name, color in colors.items())
    states = "".join(f"--{state}:{color};" for state, color in PALETTE["states"].items())
    return (
        f":root{{color-scheme:light dark;{themes['light']}{states}}}\n"
        f"@media (prefers-color-scheme:dark){{:root{{{themes['dark']}}}}}\n"
        f"@media print{{:root{{color-scheme:light;{themes['light']}}}}}\n"
    )


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


_DIGITS: Final = 9


def parts(delay: Mapping[str, float] | None) -> str:
    """Return the parts of a lead time as shares, the longest first, without those that round to 0 %."""
    delay = delay or {}
    longest = sorted(delay.items(), key=lambda part: -part[1])
    whole = math.fsum(delay.values())
    shown = [f"{name} {share(time / whole)}" for name, time in longest if whole and round(100 * time / whole)]
    return ", ".join(shown) or UNKNOWN


def in_seconds(nanoseconds: int) -> float:
    """Return nanoseconds as seconds."""
    return nanoseconds / NANOSECONDS


def rounded(value: float) -> float:
    """Return a sum without the errors of binary arithmetic."""
    return round(value, _DIGITS) + 0.0


def as_text(value: Any) -> str:
    """Return a value if it is text, else an empty text."""
    return value if isinstance(value, str) else ""

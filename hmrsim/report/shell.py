"""What surrounds all reports: one page without external parts, its colours, and the templates of its bodies."""

from __future__ import annotations

import base64
import hashlib
from functools import cache
from importlib.resources import files

from jinja2 import Environment, FunctionLoader, StrictUndefined
from markupsafe import Markup

from hmrsim.drawing import PALETTE, THEMES
from hmrsim.report import wording
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
            style=Markup(_colours() + part("page.css") + style),  # noqa: S704 - ours
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
        "seconds": wording.seconds,
        "amount": wording.amount,
        "share": wording.share,
        "svg": Markup,
        "restart": restart_text,
    }
    return environment


def _colours() -> str:
    """Return the palette as CSS, for both themes."""
    themes = {}
    for theme in THEMES:
        colours = {name.replace("_", "-"): colour for name, colour in PALETTE[theme].items()}
        colours |= {f"heat-{i}": colour for i, colour in enumerate(PALETTE["heat"][theme], 1)}
        themes[theme] = "".join(f"--{name}:{colour};" for name, colour in colours.items())
    states = "".join(f"--{state}:{colour};" for state, colour in PALETTE["states"].items())
    return (
        f":root{{color-scheme:light dark;{themes['light']}{states}}}\n"
        f"@media (prefers-color-scheme:dark){{:root{{{themes['dark']}}}}}\n"
        f"@media print{{:root{{color-scheme:light;{themes['light']}}}}}\n"
    )

"""Maps and reports of runs in Jupyter: what these functions return is shown where it is the end of a cell.

::

    from hmrsim.notebook import draw, report
    from hmrsim.testing import simulation

    draw("cafe")
    with simulation("cafe", tree="waiter.py:serve") as run:
        run.to_the_end()
    report(run.trace)

Nothing of Jupyter is needed for that, or loaded.
"""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from hmrsim.drawing import Drawing
from hmrsim.report import of_trace, section_of
from hmrsim.report.page import page_of_sections
from hmrsim.world.model import World
from hmrsim.world_checks import load_world

__all__ = ["Page", "Picture", "draw", "report"]


@dataclass(frozen=True)
class Picture:
    """A picture that a notebook shows.

    Attributes:
        svg: The picture, as a document of SVG.
    """

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg


@dataclass(frozen=True)
class Page:
    """A page that a notebook shows in a separate frame, so that neither disturbs the other.

    Attributes:
        html: The page, as a document of HTML.
        height: The height of the frame in pixels.
    """

    html: str
    height: int

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts" '
            f'style="width: 100%; height: {self.height}px; border: 0"></iframe>'
        )


def draw(
    world: str | Path | World, *, theme: Literal["light", "dark"] = "light", width: int = 800, names: bool = True
) -> Picture:
    """Return the map of a world.

    Args:
        world: The name of a shipped world, the path of a file, or a world that was read.
        theme: Colors for a light or a dark background.
        width: In pixels.
        names: Whether names are written.

    Raises:
        WorldError: The world can't be read; it has all errors.
    """
    read = world if isinstance(world, World) else load_world(world).world
    return Picture(Drawing(read, theme, width=width, names=names).svg())


def report(trace: str | Path, *, height: int = 700) -> Page:
    """Return the report of a run, as ``hmrsim report`` writes it.

    Args:
        trace: The text of a trace, such as `hmrsim.testing.Run.trace`, or the path of one.
        height: The height of the frame in which it is shown, in pixels.

    Raises:
        TraceError: It is no trace.
    """
    text = trace.read_text(encoding="utf-8") if isinstance(trace, Path) else trace
    sources = of_trace(lambda: text.splitlines(keepends=True))
    sections = [section_of(source) for source in sources]
    return Page(page_of_sections(sections, [source.definition for source in sources]), height)

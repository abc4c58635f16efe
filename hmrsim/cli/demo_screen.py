"""Where a demo shows its mission: a live table with the log above it on a terminal, lines of text or JSON elsewhere."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import IO, TYPE_CHECKING, Final, Protocol

from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from hmrsim.cli.output import show_json, warn

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.cli.demo_story import Line, Story

_PERIOD: Final = 0.25
_STYLES: Final = {"world": "cyan", "tree": "yellow"}


class Audience(Protocol):
    """Whom a demo tells what happens."""

    def opened(self) -> AbstractContextManager[None]:
        """Return what has to be entered while the mission goes on."""

    def say(self, text: str) -> None:
        """Show a line that is no part of the mission."""

    def log(self, text: str) -> None:
        """Show a line of the log; from any thread."""

    def tell(self, line: Line) -> None:
        """Show what happened."""

    def refresh(self, story: Story) -> None:
        """Show how things stand now."""

    def summary(self, story: Story, wall_seconds: float, units: str, *, succeeded: bool) -> None:
        """Show the sum."""


class JsonLines:
    """Writes what happens as one JSON object a line, the sum as the last; all else goes to stderr."""

    def opened(self) -> AbstractContextManager[None]:
        """Return what does nothing."""
        return nullcontext()

    def say(self, text: str) -> None:
        """Show a line that is no part of the mission."""
        warn(text)

    def log(self, text: str) -> None:
        """Show a line of the log."""
        warn(text)

    def tell(self, line: Line) -> None:
        """Write what happened."""
        show_json(line.to_json())

    def refresh(self, story: Story) -> None:
        """Do nothing: programs want to know what happens, not how things stand."""

    def summary(self, story: Story, wall_seconds: float, _units: str, *, succeeded: bool) -> None:
        """Write the sum."""
        times = {"simulated_seconds": round(story.sim_time, 3), "wall_seconds": round(wall_seconds, 3)}
        show_json({"succeeded": succeeded, **times, "robots": story.to_json()})


class Screen:
    """Shows lines as they come, and on a terminal where everybody is.

    Args:
        out: Where to.
    """

    def __init__(self, out: IO[str]) -> None:
        self._console = Console(file=out, highlight=False)
        self._out = out
        self._live: Live | None = None
        self._next = 0.0

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Show the live table meanwhile, on a terminal."""
        if not self._console.is_terminal:
            yield
            return
        with Live(console=self._console, auto_refresh=False, transient=True, redirect_stdout=False) as self._live:
            yield
        self._live = None

    def say(self, text: str) -> None:
        """Show a line that is no part of the mission."""
        if self._live is None:
            print(text, file=self._out, flush=True)
        else:
            self._console.print(text, markup=False)

    def log(self, text: str) -> None:
        """Show a line of the log: above the live table, if there is one."""
        if self._live is None:
            warn(text)
        else:
            self._console.print(text, markup=False)

    def tell(self, line: Line) -> None:
        """Show what happened."""
        if self._live is None:
            print(line, file=self._out, flush=True)
        else:
            self._console.print(Text(str(line), style=_STYLES[line.source]))

    def refresh(self, story: Story) -> None:
        """Show what is new in the table, four times a second at most."""
        now = time.monotonic()
        if self._live is not None and now >= self._next:
            self._next = now + _PERIOD
            self._live.update(_now(story), refresh=True)

    def summary(self, story: Story, wall_seconds: float, units: str, *, succeeded: bool) -> None:
        """Show the sum."""
        table = Table(title="What the fleet did", title_justify="left")
        for heading in ("robot", "type"):
            table.add_column(heading)
        for heading in ("succeeded", "failed", f"distance ({units})"):
            table.add_column(heading, justify="right")
        table.add_column("items moved")
        for name, robot in story.robots.items():
            numbers = (str(robot.succeeded), str(robot.failed), f"{robot.distance:.1f}")
            table.add_row(name, robot.type, *numbers, ", ".join(robot.moved))
        self._console.print()
        self._console.print(table)
        verdict = "succeeded" if succeeded else "failed"
        self.say(f"the mission {verdict}: {story.sim_time:.1f} s of simulated time in {wall_seconds:.1f} s")


def _now(story: Story) -> Table:
    table = Table(title=f"hospital   {story.sim_time:.1f} s", title_justify="left")
    table.add_column("robot")
    table.add_column("type")
    table.add_column("does", min_width=24)
    table.add_column("carries", min_width=14)
    table.add_column("driven", justify="right", min_width=6)
    for name, robot in story.robots.items():
        table.add_row(name, robot.type, robot.does, robot.carries, f"{robot.distance:.1f}")
    return table

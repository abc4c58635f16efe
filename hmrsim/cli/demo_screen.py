"""The output of a demo: a live table with the log above it on a terminal, lines of text or JSON elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import IO, TYPE_CHECKING, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hmrsim.cli.demo_story import RobotSummary
from hmrsim.cli.output import show_json, warn
from hmrsim.cli.robot_table import Column, RobotTable

if TYPE_CHECKING:
    from hmrsim.cli.demo_story import Line, Story

_STYLES: Final = {"world": "cyan", "tree": "yellow"}
_COLUMNS: Final = (
    Column("robot", 8, 0),
    Column("type", 12, 4),
    Column("does", 24, 1),
    Column("driven", 7, 3, "right"),
    Column("carries", 14, 2),
)


class JsonLines:
    """Prints each line, and finally the summary, as a JSON object; everything else goes to stderr."""

    def opened(self, _story: Story) -> AbstractContextManager[object]:
        """Return a context that does nothing."""
        return nullcontext()

    def note(self, text: str) -> None:
        """Show a line that does not belong to the mission."""
        warn(text)

    def log(self, text: str) -> None:
        """Show a line of the log."""
        warn(text)

    def hint(self, _text: str) -> None:
        """Do nothing: a program does not look for what to try next."""

    def show(self, line: Line) -> None:
        """Print a line of the story."""
        show_json(line.to_json())

    def refresh(self) -> None:
        """Do nothing: JSON output has no live state."""

    def summary(self, story: Story, wall_seconds: float, _units: str, *, succeeded: bool) -> None:
        """Print the summary."""
        times = {"simulated_seconds": round(story.sim_time, 3), "wall_seconds": round(wall_seconds, 3)}
        show_json({"succeeded": succeeded, **times, "robots": story.to_json()})


class _MissionTable(RobotTable[RobotSummary]):
    """A table of the robots of a mission, which disappears at the end when the summary is printed."""

    def __init__(self, console: Console, story: Story) -> None:
        super().__init__(console, story.robots, _COLUMNS, transient=True)
        self._story = story

    def title(self) -> str:
        """Return the name of the world, and the time."""
        return f"hospital   {self._story.sim_time:.1f} s"

    def row(self, name: str, robot: RobotSummary) -> Sequence[str]:
        """Return the activity of a robot."""
        return name, robot.type, robot.does, f"{robot.distance:.1f}", robot.carries


class Screen:
    """Prints lines as they arrive, and shows the state of each robot on a terminal."""

    def __init__(self, out: IO[str]) -> None:
        self._console = Console(file=out, highlight=False)
        self._out = out
        self._table: _MissionTable | None = None

    @contextmanager
    def opened(self, story: Story) -> Iterator[None]:
        """Show the live table during the context, on a terminal."""
        if not self._console.is_terminal:
            yield
            return
        with _MissionTable(self._console, story) as self._table:
            yield
        self._table = None

    def note(self, text: str) -> None:
        """Show a line that does not belong to the mission."""
        if self._table is None:
            print(text, file=self._out, flush=True)
        else:
            self._table.print(text)

    def log(self, text: str) -> None:
        """Show a line of the log: above the live table, if there is one."""
        if self._table is None:
            warn(text)
        else:
            self._table.print(text)

    def hint(self, text: str) -> None:
        """Show what to try next."""
        self.note(text)

    def show(self, line: Line) -> None:
        """Show a line of the story, unless it is a detail."""
        if line.detail:
            return
        if self._table is None:
            print(line, file=self._out, flush=True)
        else:
            self._table.print(Text(str(line), style=_STYLES[line.source]))

    def refresh(self) -> None:
        """Refresh the table."""
        if self._table is not None:
            self._table.refresh()

    def summary(self, story: Story, wall_seconds: float, units: str, *, succeeded: bool) -> None:
        """Show the summary."""
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
        self.note(f"the mission {verdict}: {story.sim_time:.1f} s of simulated time in {wall_seconds:.1f} s")


Display = JsonLines | Screen
"""The output of a demo."""

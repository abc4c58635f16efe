"""A live table of robots for a terminal: one line per robot, as wide and as long as there is room."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, Generic, Literal, NamedTuple, Self, TypeVar

from rich import box
from rich.live import Live
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from rich.console import Console

Robot = TypeVar("Robot")

_PERIOD: Final = 0.25
_LINES_AROUND: Final = 5
"""Lines of the terminal that are not robots: title, heading and its rule, what is left out, the cursor's."""

_GAP: Final = 2
"""Columns of the terminal between two of the table."""

_ECHO: Final = 2
"""Columns of the terminal right of the table."""

_MAX_NAME: Final = 16
"""Maximum characters of a name; longer ones are truncated."""


class Column(NamedTuple):
    """A column of the table.

    Attributes:
        width: Characters that it needs; the last column takes all that is left.
        rank: If there is no room for all columns, those of the highest rank are omitted.
        justify: The alignment.
    """

    heading: str
    width: int
    rank: int
    justify: Literal["left", "right"] = "left"


class RobotTable(ABC, Generic[Robot]):
    """Shows the state of robots until it is closed.

    Args:
        robots: The robots by name; robots may be added and removed.
        transient: Whether the table disappears when it is closed; else the last one stays.
    """

    def __init__(
        self, console: Console, robots: Mapping[str, Robot], columns: Sequence[Column], *, transient: bool = False
    ) -> None:
        self._console = console
        self._robots = robots
        self._live = Live(console=console, auto_refresh=False, redirect_stdout=False, transient=transient)
        self._next = 0.0
        longest = max(map(len, robots), default=0)
        names = columns[0]._replace(width=min(_MAX_NAME, max(columns[0].width, longest)))
        self._columns = (names, *columns[1:])

    @abstractmethod
    def title(self) -> str:
        """Return the title."""

    @abstractmethod
    def row(self, name: str, robot: Robot) -> Sequence[str | Text]:
        """Return the cells of a robot, one for each column; the last ones may be omitted."""

    def __enter__(self) -> Self:
        """Begin to show."""
        self._live.start()
        return self

    def __exit__(self, *_error: object) -> None:
        """Show the table a last time, and stop."""
        self._live.update(self.table(), refresh=True)
        self._live.stop()

    def print(self, line: str | Text) -> None:
        """Show a line above the table; from any thread."""
        self._console.print(line, markup=False, highlight=False)

    def refresh(self) -> None:
        """Refresh the table, at most four times a second."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + _PERIOD
            self._live.update(self.table(), refresh=True)

    def table(self) -> Table:
        """Return the current table."""
        available = self._console.size.width - _ECHO
        table = Table(
            title=Text(self.title(), no_wrap=True, overflow="ellipsis"),
            title_justify="left",
            caption_justify="left",
            box=box.SIMPLE_HEAD,
            show_edge=False,
            pad_edge=False,
            padding=(0, 1, 0, 0),
            expand=True,
            # What the terminal echoes, such as ^C, stays on the last line, and the next table is where this one was.
            width=available,
        )
        columns = _fitting(self._columns, available)
        for column in columns:
            last = column is self._columns[-1]
            width, ratio = (None, 1) if last else (column.width, None)
            table.add_column(column.heading, justify=column.justify, width=width, ratio=ratio, no_wrap=True)
        room = max(1, self._console.size.height - _LINES_AROUND)
        robots = list(self._robots.items())
        for name, robot in robots[:room]:
            cells = zip(self._columns, self.row(name, robot), strict=False)
            table.add_row(*(cell for column, cell in cells if column in columns))
        if len(robots) > room:
            table.caption = Text(f"… and {len(robots) - room} more", no_wrap=True)
        return table


def _fitting(columns: Sequence[Column], width: int) -> list[Column]:
    """Return the columns for which a terminal has room: those of the lowest ranks, at least one."""
    fitting = list(columns)
    while len(fitting) > 1 and sum(column.width + _GAP for column in fitting) - _GAP > width:
        fitting.remove(max(fitting, key=lambda column: column.rank))
    return fitting

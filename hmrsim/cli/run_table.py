"""A live table of a simulator's robots, for a terminal."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, Self

from rich import box
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from hmrsim.actions import error_of
from hmrsim.errors import printable
from hmrsim.gateway import GoalChanged, Topic
from hmrsim.goal import GoalStatus

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.gateway import Event
    from hmrsim.robot import Robot
    from hmrsim_zenoh.host import Host

_PERIOD: Final = 0.25
_TRIES: Final = 5
_LINES_AROUND: Final = 5
"""Lines of the terminal that are not robots: title, heading and its rule, what is left out, the cursor's."""

_GAP: Final = 2
"""Columns of the terminal between two of the table."""

_STYLES: Final = {GoalStatus.SUCCEEDED: "green", GoalStatus.ABORTED: "red", GoalStatus.CANCELED: "yellow"}


class _Column(NamedTuple):
    """One thing that is shown of robots.

    Attributes:
        heading: What it is called.
        width: Characters that it needs.
        rank: Where there is no room for all columns, those of the highest rank are left out.
        justify: To which side.
    """

    heading: str
    width: int
    rank: int
    justify: Literal["left", "right"] = "left"


_LONGEST_NAME: Final = 16
"""Of a longer name the rest is left out."""

_COLUMNS: Final = (
    _Column("robot", 8, 0),
    _Column("type", 8, 6),
    _Column("x, y", 15, 4, "right"),
    _Column("yaw", 5, 7, "right"),
    _Column("does", 16, 1),
    _Column("remaining", 9, 3, "right"),
    _Column("carries", 12, 5),
    _Column("last goal", 21, 2),
)


class _Row(NamedTuple):
    """What is shown of one robot, a field a column."""

    name: str
    kind: str
    position: str = ""
    yaw: str = ""
    state: str = ""
    remaining: str = ""
    carrying: str = ""
    last: str | Text = ""


class RobotTable:
    """Shows where robots are and what they do, on stderr, until it is closed.

    It is a sink, too: it hears how goals end, and who wants the clock makes time move on between events.

    Args:
        host: What to look at.
        world: The world's name.
        console: Where to show it; stderr if None.
    """

    def __init__(self, host: Host, world: str, console: Console | None = None) -> None:
        self._host = host
        self._world = world
        self._console = console or Console(stderr=True)
        self._live = Live(console=self._console, auto_refresh=False, redirect_stdout=False)
        self._next = 0.0
        self._last: dict[str, Text] = {}
        longest = max((len(name) for name in host.simulator.robots), default=0)
        names = _COLUMNS[0]._replace(width=min(_LONGEST_NAME, max(_COLUMNS[0].width, longest)))
        self._columns = (names, *_COLUMNS[1:])

    def __enter__(self) -> Self:
        """Begin to show."""
        self._live.start()
        return self

    def __exit__(self, *_error: object) -> None:
        """Leave the last table on the terminal."""
        self._live.update(self.table(), refresh=True)
        self._live.stop()

    def emit(self, event: Event) -> None:
        """Remember how a goal ended; everything else the table looks up by itself."""
        if isinstance(event, GoalChanged) and event.status.terminal:
            self._last[event.robot] = _verdict(event)

    def wants(self, topic: Topic) -> bool:
        """Return whether it is the clock."""
        return topic is Topic.CLOCK

    def print(self, line: str) -> None:
        """Show a line above the table; from any thread."""
        self._console.print(line, markup=False, highlight=False)

    def refresh(self) -> None:
        """Show what is new, four times a second at most."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + _PERIOD
            self._live.update(self.table(), refresh=True)

    def table(self) -> Table:
        """Return the table as of now."""
        simulator, pacing = self._host.simulator, self._host.pacing
        factor = f"at {pacing.real_time_factor:g} x" if pacing.real_time_factor else "as fast as possible"
        lag = f"   {pacing.lag:.1f} s behind" if pacing.lag else ""
        heading = f"{printable(self._world)}   {simulator.now:.1f} s   {factor}{lag}"
        title = Text(heading, no_wrap=True, overflow="ellipsis")
        table = Table(
            title=title,
            title_justify="left",
            caption_justify="left",
            box=box.SIMPLE_HEAD,
            show_edge=False,
            pad_edge=False,
            padding=(0, 1, 0, 0),
            expand=True,
        )
        columns = _fitting(self._columns, self._console.size.width)
        for column in columns:
            last = column is self._columns[-1]
            width, ratio = (None, 1) if last else (column.width, None)
            table.add_column(column.heading, justify=column.justify, width=width, ratio=ratio, no_wrap=True)
        room = max(1, self._console.size.height - _LINES_AROUND)
        robots = list(simulator.robots.values())
        for robot in robots[:room]:
            cells = zip(self._columns, self._row(robot), strict=True)
            table.add_row(*(cell for column, cell in cells if column in columns))
        if len(robots) > room:
            table.caption = Text(f"… and {len(robots) - room} more", no_wrap=True)
        return table

    def _row(self, robot: Robot) -> _Row:
        """Return what a robot does; the simulation's thread may move it meanwhile, so look again if it did."""
        for _ in range(_TRIES):
            try:
                pose, remaining = robot.pose(), robot.distance_remaining
            except AttributeError:
                continue
            goal = self._host.simulator.dispatcher.goal_of(robot.name)
            return _Row(
                robot.name,
                robot.type,
                f"{pose.x:.2f} {pose.y:.2f}",
                f"{pose.yaw:.2f}",
                goal[0] if goal else "-",
                f"{remaining:.2f}" if remaining else "",
                _carried(robot),
                self._last.get(robot.name, ""),
            )
        return _Row(robot.name, robot.type)


def _fitting(columns: Sequence[_Column], width: int) -> list[_Column]:
    """Return the columns for which a terminal has room: at least one, those that matter most."""
    fitting = list(columns)
    while len(fitting) > 1 and sum(column.width + _GAP for column in fitting) - _GAP > width:
        fitting.remove(max(fitting, key=lambda column: column.rank))
    return fitting


def _verdict(event: GoalChanged) -> Text:
    """Return how a goal ended: why, if it went wrong."""
    why = error_of(event.result) if event.status is GoalStatus.ABORTED and event.result is not None else ""
    text = f"{event.status.name}: {printable(why)}" if why else f"{event.status.name} {event.action}"
    return Text(text, style=_STYLES.get(event.status, ""))


def _carried(robot: Robot) -> str:
    """Return the names of the items that a robot's components hold."""
    items = [getattr(component, "item", None) for component in robot.components.values()]
    return ", ".join(item.name for item in items if item is not None)

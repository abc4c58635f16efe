"""Live tables of robots on a terminal, with one line per robot."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, Generic, Literal, NamedTuple, Self, TypeVar

from rich import box
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from hmrsim.actions import error_of
from hmrsim.cli.event_log import EventLog, LogLines, log_policy
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink
    from hmrsim.robots.robot import Robot
    from hmrsim_zenoh.hosting.host import Host


RobotT = TypeVar("RobotT")

_PERIOD: Final = 0.25
_LINES_AROUND: Final = 5
"""Lines of the terminal around the robots: title, heading, rule, number of omitted robots, and the cursor."""

_GAP: Final = 2
"""Characters between two columns."""

_ECHO: Final = 2
"""Characters to the right of the table."""

_MAX_NAME: Final = 16
"""Maximum characters of a name; longer ones are truncated."""


class Column(NamedTuple):
    """A column of the table.

    Attributes:
        width: The width in characters; the last column takes the remaining width.
        rank: If there is no room for all columns, those with the highest rank are omitted.
        justify: The alignment.
    """

    heading: str
    width: int
    rank: int
    justify: Literal["left", "right"] = "left"


class RobotTable(Generic[RobotT]):
    """A live table of robots.

    Args:
        console: The terminal.
        robots: The robots by name, which may be added and removed.
        columns: The columns, of which the first has the names.
        title: Returns the title.
        row: Returns the cells of a robot, one for each column; the last ones may be omitted.
        transient: Whether the table disappears when it is closed.
    """

    def __init__(
        self,
        console: Console,
        robots: Mapping[str, RobotT],
        columns: Sequence[Column],
        title: Callable[[], str],
        row: Callable[[str, RobotT], Sequence[str | Text]],
        *,
        transient: bool = False,
    ) -> None:
        self._console = console
        self._robots = robots
        self._title, self._row = title, row
        self._live = Live(console=console, auto_refresh=False, redirect_stdout=False, transient=transient)
        self._next = 0.0
        longest = max(map(len, robots), default=0)
        names = columns[0]._replace(width=min(_MAX_NAME, max(columns[0].width, longest)))
        self._columns = (names, *columns[1:])

    def __enter__(self) -> Self:
        """Show the table."""
        self._live.start()
        return self

    def __exit__(self, *_error: object) -> None:
        """Show the table a last time, and close it."""
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
            title=Text(self._title(), no_wrap=True, overflow="ellipsis"),
            title_justify="left",
            caption_justify="left",
            box=box.SIMPLE_HEAD,
            show_edge=False,
            pad_edge=False,
            padding=(0, 1, 0, 0),
            expand=True,
            # The terminal's echo, such as ^C, fits on the last line, so that the next table replaces this one.
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
            cells = zip(self._columns, self._row(name, robot), strict=False)
            table.add_row(*(cell for column, cell in cells if column in columns))
        if len(robots) > room:
            table.caption = Text(f"… and {len(robots) - room} more", no_wrap=True)
        return table


def _fitting(columns: Sequence[Column], width: int) -> list[Column]:
    """Return the columns that fit into a width: those with the lowest ranks, at least one."""
    fitting = list(columns)
    while len(fitting) > 1 and sum(column.width + _GAP for column in fitting) - _GAP > width:
        fitting.remove(max(fitting, key=lambda column: column.rank))
    return fitting


_TRIES: Final = 5
_STYLES: Final = {GoalStatus.SUCCEEDED: "green", GoalStatus.ABORTED: "red", GoalStatus.CANCELED: "yellow"}
_HOST_COLUMNS: Final = (
    Column("robot", 8, 0),
    Column("type", 8, 6),
    Column("x, y", 15, 4, "right"),
    Column("yaw", 5, 7, "right"),
    Column("does", 16, 1),
    Column("remaining", 9, 3, "right"),
    Column("carries", 12, 5),
    Column("last goal", 21, 2),
)


class LastGoals:
    """A sink that records how each robot's last goal ended; it wants the clock, so that the displayed time advances."""

    def __init__(self) -> None:
        self.verdicts: dict[str, Text] = {}

    def emit(self, output: Output) -> None:
        """Record how a goal ended."""
        if isinstance(output, GoalChanged) and output.status.terminal:
            self.verdicts[output.robot] = _verdict(output)

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is the clock."""
        return topic is Topic.CLOCK


def host_table(host: Host, world: str, goals: LastGoals, console: Console) -> RobotTable[Robot]:
    """Return a live table of the robots of a host.

    Args:
        host: The host.
        world: The name of the world.
        goals: The sink with the last goals.
        console: The terminal.
    """

    def title() -> str:
        pacing = host.pacing
        factor = f"at {pacing.real_time_factor:g} x" if pacing.real_time_factor else "as fast as possible"
        lag = f"   {pacing.lag:.1f} s behind" if pacing.lag else ""
        return f"{printable(world)}   {host.simulator.now:.1f} s   {factor}{lag}"

    def row(name: str, robot: Robot) -> Sequence[str | Text]:
        # The simulation's thread may change the robot meanwhile; then it is read again.
        for _ in range(_TRIES):
            try:
                pose, remaining = robot.pose(), robot.motion.progress().length
            except AttributeError:
                continue
            goal = host.simulator.dispatcher.goal_of(name)
            items = [getattr(component, "item", None) for component in robot.components.values()]
            return (
                name,
                robot.type,
                f"{pose.x:.2f} {pose.y:.2f}",
                f"{pose.yaw:.2f}",
                goal[0] if goal else "-",
                f"{remaining:.2f}" if remaining else "",
                ", ".join(item.name for item in items if item is not None),
                goals.verdicts.get(name, ""),
            )
        return name, robot.type

    return RobotTable(console, host.simulator.robots, _HOST_COLUMNS, title, row)


class TableDisplay:
    """A live table of robots with log lines above it."""

    def __init__(self, world: str, level: int) -> None:
        self._world = world
        self._level = level
        self._goals = LastGoals()
        self.sinks: Sequence[Sink] = (self._goals, EventLog(Severity.WARNING, goals=False))
        self.on_wait: Sequence[Callable[[], None]] = ()
        self.preparations: Iterable[object] = ()

    @contextmanager
    def shown(self, host: Host) -> Iterator[Callable[[], None]]:
        """Show the table, and yield the function that refreshes it."""
        table = host_table(host, self._world, self._goals, Console(stderr=True))
        with table, LogLines(table.print, self._level):
            log_policy(host.simulator)
            yield table.refresh


def _verdict(event: GoalChanged) -> Text:
    why = error_of(event.result) if event.status is GoalStatus.ABORTED and event.result is not None else ""
    text = f"{event.status.name}: {printable(why)}" if why else f"{event.status.name} {event.action}"
    return Text(text, style=_STYLES.get(event.status, ""))

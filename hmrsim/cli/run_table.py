"""A live table of a simulator's robots, for a terminal."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final, NamedTuple, Self

from rich.console import Console
from rich.live import Live
from rich.table import Table

from hmrsim.gateway import Topic

if TYPE_CHECKING:
    from hmrsim.gateway import Event
    from hmrsim.robot import Robot
    from hmrsim_zenoh.host import Host

_PERIOD: Final = 0.25
_TRIES: Final = 5
_LINES_AROUND: Final = 6
"""Lines of the terminal that are not robots: title, header, borders, what is left out, the cursor's."""


class _Row(NamedTuple):
    """What is shown of one robot."""

    name: str
    kind: str
    x: str
    y: str
    yaw: str
    state: str
    remaining: str
    carrying: str


class RobotTable:
    """Shows where robots are and what they do, on stderr, until it is closed.

    It is a sink, too: who wants the clock makes time move on between events.

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

    def __enter__(self) -> Self:
        """Begin to show."""
        self._live.start()
        return self

    def __exit__(self, *_error: object) -> None:
        """Leave the last table on the terminal."""
        self._live.update(self.table(), refresh=True)
        self._live.stop()

    def emit(self, event: Event) -> None:
        """Ignore an event: the table looks by itself."""

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
        table = Table(title=f"{self._world}   {simulator.now:.1f} s   {factor}{lag}", title_justify="left")
        for heading, width in (("robot", 8), ("type", 8)):
            table.add_column(heading, min_width=width)
        for heading in ("x", "y", "yaw"):
            table.add_column(heading, justify="right", min_width=7)
        table.add_column("does", min_width=16)
        table.add_column("remaining", justify="right", min_width=9)
        table.add_column("carries", min_width=12)
        room = max(1, self._console.size.height - _LINES_AROUND)
        robots = list(simulator.robots.values())
        for robot in robots[:room]:
            table.add_row(*self._row(robot))
        if len(robots) > room:
            table.caption = f"and {len(robots) - room} more"
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
                f"{pose.x:.2f}",
                f"{pose.y:.2f}",
                f"{pose.yaw:.2f}",
                goal[0] if goal else "-",
                f"{remaining:.2f}" if remaining else "",
                _carried(robot),
            )
        return _Row(robot.name, robot.type, "", "", "", "", "", "")


def _carried(robot: Robot) -> str:
    """Return the names of the items that a robot's components hold."""
    items = [getattr(component, "item", None) for component in robot.components.values()]
    return ", ".join(item.name for item in items if item is not None)

"""The live table of ``hmrsim run``: the robots' places and activities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from rich.console import Console
from rich.text import Text

from hmrsim.actions import error_of
from hmrsim.cli.robot_table import Column, RobotTable
from hmrsim.errors import printable
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.robots.robot import Robot

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim_zenoh.hosting.host import Host

_TRIES: Final = 5
_STYLES: Final = {GoalStatus.SUCCEEDED: "green", GoalStatus.ABORTED: "red", GoalStatus.CANCELED: "yellow"}
_COLUMNS: Final = (
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
    """A sink that remembers how each robot's last goal ended; it wants the clock, so that the shown time advances."""

    def __init__(self) -> None:
        self.verdicts: dict[str, Text] = {}

    def emit(self, output: Output) -> None:
        """Remember how a goal ended."""
        if isinstance(output, GoalChanged) and output.status.terminal:
            self.verdicts[output.robot] = _verdict(output)

    def wants(self, topic: Topic) -> bool:
        """Return whether it is the clock."""
        return topic is Topic.CLOCK


class HostTable(RobotTable[Robot]):
    """Shows the robots of a host on stderr.

    Args:
        console: The console; stderr if None.
    """

    def __init__(self, host: Host, world: str, goals: LastGoals, console: Console | None = None) -> None:
        super().__init__(console or Console(stderr=True), host.simulator.robots, _COLUMNS)
        self._host = host
        self._world = world
        self._last = goals.verdicts

    def title(self) -> str:
        """Return the world's name, and the time."""
        pacing = self._host.pacing
        factor = f"at {pacing.real_time_factor:g} x" if pacing.real_time_factor else "as fast as possible"
        lag = f"   {pacing.lag:.1f} s behind" if pacing.lag else ""
        return f"{printable(self._world)}   {self._host.simulator.now:.1f} s   {factor}{lag}"

    def row(self, name: str, robot: Robot) -> Sequence[str | Text]:
        """Return the activity of a robot; read again if the simulation's thread has changed it meanwhile."""
        for _ in range(_TRIES):
            try:
                pose, remaining = robot.pose(), robot.distance_remaining
            except AttributeError:
                continue
            goal = self._host.simulator.dispatcher.goal_of(name)
            return (
                name,
                robot.type,
                f"{pose.x:.2f} {pose.y:.2f}",
                f"{pose.yaw:.2f}",
                goal[0] if goal else "-",
                f"{remaining:.2f}" if remaining else "",
                _carried(robot),
                self._last.get(name, ""),
            )
        return name, robot.type


def _verdict(event: GoalChanged) -> Text:
    """Return how a goal ended, and why if it failed."""
    why = error_of(event.result) if event.status is GoalStatus.ABORTED and event.result is not None else ""
    text = f"{event.status.name}: {printable(why)}" if why else f"{event.status.name} {event.action}"
    return Text(text, style=_STYLES.get(event.status, ""))


def _carried(robot: Robot) -> str:
    """Return the names of the items that a robot's components hold."""
    items = [getattr(component, "item", None) for component in robot.components.values()]
    return ", ".join(item.name for item in items if item is not None)

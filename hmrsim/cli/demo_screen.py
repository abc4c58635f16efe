"""The output of a demo: the story of its mission, as a live table with a log, as lines of text, or as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import IO, TYPE_CHECKING, Any, Final, NamedTuple

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hmrsim.cli.event_log import text_of
from hmrsim.cli.output import show_json, warn
from hmrsim.cli.robot_table import Column, RobotTable
from hmrsim.events import Severity
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.robots import ItemPicked, ItemPlaced
from hmrsim.history.occurrence import Occurrence
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.goal import GoalStatus
from hmrsim.report.story import Story as RunStory

if TYPE_CHECKING:
    from hmrsim.events import Event

_MARKS: Final = {"SUCCESS": "done", "FAILURE": "failed", "RUNNING": "begun"}


class Line(NamedTuple):
    """One line of the story.

    Attributes:
        sim_time: In simulated seconds; None if unknown.
        source: ``world`` for the simulator, ``tree`` for the controller.
        hands_over: Whether the robot's next line is expected from the other source.
        detail: Whether a short log leaves it out.
    """

    sim_time: float | None
    source: str
    robot: str
    text: str
    hands_over: bool = False
    detail: bool = False

    def to_json(self) -> dict[str, Any]:
        """Return the line as JSON values, with the time rounded to milliseconds."""
        time = None if self.sim_time is None else round(self.sim_time, 3)
        return {"sim_time": time, "source": self.source, "robot": self.robot, "text": self.text}

    def __str__(self) -> str:
        """Return the line as text."""
        time = "" if self.sim_time is None else f"{self.sim_time:.3f}"
        return f"{time:>9} | {self.source:<5} | {self.robot:<8} | {self.text}"


@dataclass
class RobotSummary:
    """The summary of one robot.

    Attributes:
        succeeded: Goals that succeeded.
        failed: Goals that ended otherwise.
        distance: The driven distance up to the current motion, in the world's unit.
        moved: The items that the robot has put down.
        carries: The item that the robot holds; empty for none.
        does: The running behavior of the robot's tree, or else the last one.
    """

    type: str
    succeeded: int = 0
    failed: int = 0
    distance: float = 0.0
    moved: list[str] = field(default_factory=list)
    carries: str = ""
    does: str = ""


class Story:
    """Turns the events and trees of a mission into lines, and sums them up by robot.

    Args:
        robots: The type of each robot, by name.
    """

    def __init__(self, robots: dict[str, str]) -> None:
        self.robots = {name: RobotSummary(kind) for name, kind in robots.items()}
        self.sim_time = 0.0
        self._run = RunStory()
        self._trees: dict[str, dict[str, str]] = {name: {} for name in robots}

    def on_event(self, at: float, event: Event) -> Iterator[Line]:
        """Process an event of the simulation; yield the lines to show."""
        self.sim_time = at
        self._run.take(Occurrence(round(at * NANOSECONDS), event))
        name = event.subject
        ended = False
        if (robot := self.robots.get(name)) is not None:
            ended = _follow(robot, event)
            if (track := self._run.robot_log.tracks.get(name)) is not None:
                robot.distance = track.distance
        elif getattr(event, "robot", ""):
            # The robot is not part of the mission.
            return
        if text := text_of(event):
            detail = not ended and event.severity in (Severity.DEBUG, Severity.INFO)
            yield Line(at, "world", name, text, hands_over=ended, detail=detail)

    def ticked(self, tree: dict[str, Any]) -> Iterator[Line]:
        """Process a ticked tree; yield a line for each behavior that began or ended."""
        robot = self.robots.get(tree.get("robot", ""))
        if robot is None:
            return
        before = self._trees[tree["robot"]]
        nodes = tree["nodes"]
        for node in _leaves(nodes):
            name, status = node["name"], node["status"]
            if status == "RUNNING":
                robot.does = name
            if before.get(name) != status and status in _MARKS:
                message = f": {node['message']}" if status == "FAILURE" and node["message"] else ""
                text = f"{name} {_MARKS[status]}{message}"
                begun, done = status == "RUNNING", status == "SUCCESS"
                yield Line(tree["sim_time"], "tree", tree["robot"], text, hands_over=begun, detail=done)
            before[name] = status
        if tree["status"] in ("SUCCESS", "FAILURE"):
            robot.does = f"mission {_MARKS[tree['status']]}"

    def to_json(self) -> dict[str, Any]:
        """Return the summary by robot."""
        return {
            name: {
                "type": robot.type,
                "succeeded": robot.succeeded,
                "failed": robot.failed,
                "distance": round(robot.distance, 3),
                "items_moved": robot.moved,
            }
            for name, robot in self.robots.items()
        }


def _follow(robot: RobotSummary, event: Event) -> bool:
    """Update the summary of a robot; return whether a goal has ended."""
    match event:
        case GoalStatusChanged():
            status = GoalStatus(event.status)
            robot.succeeded += status is GoalStatus.SUCCEEDED
            robot.failed += status.terminal and status is not GoalStatus.SUCCEEDED
            return status.terminal
        case ItemPicked():
            robot.carries = event.item
        case ItemPlaced():
            robot.carries = ""
            robot.moved.append(event.item)
    return False


def _leaves(nodes: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the behaviors without children."""
    for node, following in zip(nodes, (*nodes[1:], {"depth": 0}), strict=True):
        if following["depth"] <= node["depth"]:
            yield node


_OTHER: Final = {"tree": "world", "world": "tree"}


class CausalOrder:
    """Sorts the lines of the world and of the trees by cause and effect, then by time.

    The lines arrive over different paths, and the controller's clock is sampled, so neither their arrival nor their
    time gives the order. But a robot's behavior begins, then its goal executes, then the behavior ends: each line waits
    for its source's turn. Then it waits for earlier lines of other robots.

    Args:
        patience: The maximum wall seconds that a line waits for its turn.
        hold: The wall seconds after its arrival that a line waits for lines of earlier times. A line that arrives
            even later gets the time of the line before it.
    """

    def __init__(self, patience: float, hold: float) -> None:
        self._patience, self._hold = patience, hold
        self._waiting: list[tuple[float, Line]] = []
        self._turns: dict[str, str] = {}
        self._times: dict[str, float] = {}
        self._sorted: list[tuple[float, int, float, Line]] = []
        self._count = 0
        self._last = 0.0

    def add(self, line: Line, now: float) -> None:
        """Add a line that arrives *now*, in wall seconds."""
        self._waiting.append((now, line))

    def ready(self, now: float) -> Iterator[Line]:
        """Yield the lines whose turn it is *now*, in wall seconds; their times never decrease."""
        while (i := self._next(now)) is not None:
            arrival, line = self._waiting.pop(i)
            self._turns[line.robot] = _OTHER[line.source] if line.hands_over else line.source
            time = self._times[line.robot] = max(line.sim_time or 0.0, self._times.get(line.robot, 0.0))
            self._count += 1
            heappush(self._sorted, (time, self._count, arrival + self._hold, line))
        while self._sorted and self._sorted[0][2] <= now:
            time, _, _, line = heappop(self._sorted)
            self._last = max(self._last, time)
            yield line._replace(sim_time=self._last or None)

    def _next(self, now: float) -> int | None:
        """Return the index of the first line whose turn it is, else of one that has waited long enough, else None."""
        late: int | None = None
        for i, (arrival, line) in enumerate(self._waiting):
            if not line.robot or line.source == self._turns.get(line.robot, "tree"):
                return i
            if late is None and arrival + self._patience <= now:
                late = i
        return late


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


class Screen:
    """Prints lines as they arrive, and shows the state of each robot on a terminal."""

    def __init__(self, out: IO[str]) -> None:
        self._console = Console(file=out, highlight=False)
        self._out = out
        self._table: RobotTable[RobotSummary] | None = None

    @contextmanager
    def opened(self, story: Story) -> Iterator[None]:
        """Show the live table during the context, on a terminal."""
        if not self._console.is_terminal:
            yield
            return

        def title() -> str:
            return f"hospital   {story.sim_time:.1f} s"

        def row(name: str, robot: RobotSummary) -> Sequence[str]:
            return name, robot.type, robot.does, f"{robot.distance:.1f}", robot.carries

        # The table disappears at the end, when the summary is printed.
        with RobotTable(self._console, story.robots, _COLUMNS, title, row, transient=True) as self._table:
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
        """Redraw the table of robots with their current states."""
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

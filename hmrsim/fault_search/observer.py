"""Sinks that observe a run: features that guide the search, moments for anchors, battery draws and coverage."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import share_of, write_coverage
from hmrsim.events.faults import FaultBegan, FaultEnded, FaultMissed
from hmrsim.events.goals import SendGoalRejected
from hmrsim.events.robots import ChargingBegan, ChargingEnded
from hmrsim.events.simulation import ParticipantEvent
from hmrsim.experiments.replications import packed, unpacked
from hmrsim.fault_search.kinds import Draw, battery_of, share_at_start
from hmrsim.fault_search.schedule import Moment
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.goal import Cause, GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from hmrsim.interfaces.message import Message
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.trials.disturbances import Acted
    from hmrsim.world.model import World

DISTURBED: Final = "disturbance"
"""The first word of the line of a disturbance."""
_MAX_NTH: Final = 6
"""Maximum number of moments with the same key: a controller that retries without a limit makes thousands."""


class Observer(SelectiveSink):
    """A sink that records features and moments of a run, and all events as text for a *story*.

    Attributes:
        moments: The moments to which injections may be anchored, in order.
        begun: When faults began, in simulated seconds, by kind and subject.
        lines: The events as text, each with its time in seconds.
    """

    topics = frozenset({Topic.EVENTS})

    def __init__(self, *, story: bool = False) -> None:
        self.moments: list[Moment] = []
        self.begun: dict[tuple[str, str], list[float]] = {}
        self.lines: list[tuple[float, str]] = []
        self._story = story
        self._features: dict[str, None] = {}
        self._aborts: dict[str, None] = {}
        self._counts: defaultdict[tuple[str, str, str], int] = defaultdict(int)
        self._last_labels: dict[str, str] = {}
        self._last_fault = ""
        self._began: dict[str, float] = {}

    @property
    def aborts(self) -> tuple[str, ...]:
        """Why goals were aborted or rejected: action, cause and code, or action and reason."""
        return tuple(self._aborts)

    @property
    def features(self) -> tuple[str, ...]:
        """Features of the run: changes of goals and events, each alone, after the previous one, and after a fault."""
        return tuple(self._features)

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {GoalChanged: self._note_goal, EventStamped: self._note_event}
        return handlers.get(kind)

    def note_disturbance(self, acted: Acted) -> None:
        """Add a disturbance, which is not an event of the simulation, to the lines."""
        if self._story:
            self.lines.append((acted.at / NANOSECONDS, f"{DISTURBED}: {acted.disturbance.what}"))

    def _note_goal(self, change: GoalChanged) -> None:
        status, at = change.status, change.stamp / NANOSECONDS
        if status is GoalStatus.EXECUTING:
            self._began[change.goal_id] = at
            self._note_moment(at, "executing", "", change.robot, change.action)
        elif status.terminal:
            self._add_features(change.robot, f"{change.action}:{status.name}")
            if status is GoalStatus.ABORTED:
                why = f"{change.action}:{change.cause}/{code_of(change.result)}"
                self._features[why] = self._aborts[why] = None
            duration = at - self._began.pop(change.goal_id, at)
            self._note_moment(at, "ended", "", change.robot, change.action, duration)
        elif status is GoalStatus.CANCELING:
            self._add_features(change.robot, f"{change.action}:CANCELING")
        if change.cause == Cause.ENDED:
            # The goal ended with the simulation, when the story was over.
            return
        if self._story and (status.terminal or status is GoalStatus.ACCEPTED):
            event = change.accepted() if status is GoalStatus.ACCEPTED else change.event()
            self.lines.append((at, event.describe()))

    def _note_event(self, output: EventStamped) -> None:
        at, event = output.stamp / NANOSECONDS, output.event
        if not event.traced:
            return
        if self._story:
            self.lines.append((at, event.describe()))
        if isinstance(event, (FaultBegan, FaultEnded, FaultMissed)):
            if isinstance(event, FaultBegan):
                self._last_fault = event.fault
                self.begun.setdefault((event.fault, event.subject), []).append(at)
            return
        if isinstance(event, ParticipantEvent):
            return
        if isinstance(event, SendGoalRejected):
            self._aborts[f"{event.action}:rejected/{event.reason}"] = None
        robot = getattr(event, "robot", "")
        self._add_features(robot, event.kind)
        self._note_moment(at, "", event.kind, robot, "")

    def _add_features(self, robot: str, label: str) -> None:
        """Add a change by itself, after the robot's previous one, and after the last fault."""
        before, self._last_labels[robot] = self._last_labels.get(robot, ""), label
        features = self._features
        features[f"{robot}/{label}"] = None
        features[f"{robot}/{before}>{label}"] = None
        if self._last_fault:
            features[f"{self._last_fault}>{label}"] = None

    def _note_moment(self, at: float, goal: str, event: str, robot: str, action: str, duration: float = 0.0) -> None:
        key = (goal or event, robot, action)
        self._counts[key] += 1
        nth = self._counts[key]
        if nth <= _MAX_NTH:
            self.moments.append(Moment(at, goal, event, robot, action, nth, duration))


def code_of(result: Message | None) -> Any:
    """Return the error code of an action's result, of Nav2 or MoveIt; 0 if it has none."""
    code = getattr(result, "error_code", 0)
    return getattr(code, "val", code)


class BatteryDraws(SelectiveSink):
    """A sink that measures how much each robot draws from its battery."""

    topics = frozenset({Topic.EVENTS})

    def __init__(self, simulator: Simulator, world: World) -> None:
        self._simulator = simulator
        batteries = ((name, battery_of(world, name)) for name in world.robots)
        # The state of charge of each robot after its last charge, and at the start of each goal.
        self._charged = {name: share_at_start(battery) for name, battery in batteries if battery is not None}
        self._at_start: dict[str, float] = {}
        self._draws: dict[str, Draw] = {}

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {GoalChanged: self._note_goal, EventStamped: self._note_event}
        return handlers.get(kind)

    def finish(self) -> tuple[tuple[str, Draw], ...]:
        """End the run; return the largest draws of each robot with a battery."""
        for name in self._charged:
            self._note_draw(name, self._share(name))
        return tuple(self._draws.items())

    def _note_event(self, output: EventStamped) -> None:
        event = output.event
        if isinstance(event, ChargingBegan):
            self._note_draw(event.robot, event.percentage)
        elif isinstance(event, ChargingEnded):
            self._charged[event.robot] = event.percentage

    def _note_goal(self, change: GoalChanged) -> None:
        if change.robot not in self._charged:
            return
        share = self._share(change.robot)
        if change.status is GoalStatus.EXECUTING:
            self._at_start[change.goal_id] = share
        elif change.status.terminal and change.goal_id in self._at_start:
            drawn = self._at_start.pop(change.goal_id) - share
            draw = self._draws.get(change.robot, Draw())
            self._draws[change.robot] = draw._replace(goal=max(draw.goal, drawn))

    def _share(self, name: str) -> float:
        robot = self._simulator.robots.get(name)
        return 0.0 if robot is None or robot.energy is None else robot.energy.battery.share(robot.now)

    def _note_draw(self, robot: str, share: float) -> None:
        """Record how much the battery was discharged since its last charge, given the *share* that is left."""
        draw = self._draws.get(robot, Draw())
        self._draws[robot] = draw._replace(whole=max(draw.whole, self._charged.get(robot, 1.0) - share))


_FILE: Final = "coverage.json"
"""The name of the file in the folder of results."""


@lru_cache(maxsize=8)
def _seen(_check: str) -> dict[str, None]:
    """Return the keys of the coverage that this process has seen in runs of a check."""
    return {}


def new_coverage(check: str, coverage: TreeCoverage, keys: frozenset[str]) -> bytes:
    """Return the packed coverage of a run; empty if its keys add nothing to earlier runs in this process."""
    seen = _seen(check)
    if seen.keys() >= keys:
        return b""
    seen |= dict.fromkeys(keys)
    return packed(coverage)


class TotalCoverage:
    """The merged coverage of all runs, of which `new_coverage` returns what is new."""

    def __init__(self) -> None:
        self._all = TreeCoverage()

    def take(self, coverages: Iterable[bytes]) -> None:
        """Merge the results of `new_coverage`."""
        for coverage in coverages:
            if coverage:
                self._all.merge(unpacked(coverage))

    @property
    def share(self) -> str:
        """The covered share of the trees, as text; empty without a tree."""
        nodes = [node for tree in self._all.trees for node in self._all.nodes(tree)]
        return str(share_of(nodes)) if nodes else ""

    def never(self) -> tuple[str, ...]:
        """Return the outcomes that occurred in no run, a line for each node."""
        return tuple(
            f"{node.path}: never {' or '.join(words)}"
            for tree in self._all.trees
            for node in self._all.nodes(tree)
            if (words := node.never)
        )

    def write(self, folder: Path) -> None:
        """Write the file that ``bt-controller coverage`` reads, if there is a tree.

        Raises:
            OutputError: The file can't be written.
        """
        if self._all.trees:
            write_coverage("coverage", folder / _FILE, self._all)

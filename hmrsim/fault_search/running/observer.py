"""Sinks that observe a run: features that guide the search, moments for anchors, battery draws and coverage."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import share_of, write_coverage
from hmrsim.events.faults import FaultBegan, FaultEnded, FaultMissed
from hmrsim.events.goals import SendGoalRejected
from hmrsim.events.robots import ChargingBegan, ChargingEnded
from hmrsim.events.simulation import ParticipantEvent
from hmrsim.experiments.running.replications import packed, unpacked
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
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.trials.disturbances import Acted
    from hmrsim.world.model import World

DISTURBED: Final = "disturbance"
"""Begins the line of a disturbance."""
_MAX_NTH: Final = 6
"""Of the same change of the same action only the first ones are noted: a retry without a limit makes thousands."""


class Observer(SelectiveSink):
    """A sink that records features and moments of a run.

    Args:
        story: Whether to keep all events in words.

    Attributes:
        moments: The moments to which injections may be anchored, in order.
        begun: When faults have begun, in simulated seconds, by kind and subject.
        lines: The events in words, each with its time in seconds.
    """

    def __init__(self, *, story: bool = False) -> None:
        self.moments: list[Moment] = []
        self.begun: dict[tuple[str, str], list[float]] = {}
        self.lines: list[tuple[float, str]] = []
        self._story = story
        self._features: dict[str, None] = {}
        self._aborts: dict[str, None] = {}
        self._counts: Counter[tuple[str, str, str]] = Counter()
        self._last: dict[str, str] = {}
        self._fault = ""
        self._began: dict[str, float] = {}

    @property
    def aborts(self) -> tuple[str, ...]:
        """Why goals were aborted or rejected: action, cause and code, or action and reason."""
        return tuple(self._aborts)

    @property
    def features(self) -> tuple[str, ...]:
        """Features of the run: changes of goals and events, each alone, after the previous one, and after a fault."""
        return tuple(self._features)

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is wanted: events, and no samples."""
        return topic is Topic.EVENTS

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {GoalChanged: self._note_goal, EventStamped: self._note_event}
        return handlers.get(kind)

    def note_disturbance(self, acted: Acted) -> None:
        """Note a disturbance, which is no event of the simulation."""
        if self._story:
            self.lines.append((acted.at / NANOSECONDS, f"{DISTURBED}: {acted.disturbance.what}"))

    def _note_goal(self, change: GoalChanged) -> None:
        status, at = change.status, change.stamp / NANOSECONDS
        if status is GoalStatus.EXECUTING:
            self._began[change.goal_id] = at
            self._note_moment(at, "executing", "", change.robot, change.action)
        elif status.terminal:
            self._exercise(change.robot, f"{change.action}:{status.name}")
            if status is GoalStatus.ABORTED:
                why = f"{change.action}:{change.cause}/{code_of(change.result)}"
                self._features[why] = self._aborts[why] = None
            lasted = at - self._began.pop(change.goal_id, at)
            self._note_moment(at, "ended", "", change.robot, change.action, lasted)
        elif status is GoalStatus.CANCELING:
            self._exercise(change.robot, f"{change.action}:CANCELING")
        if change.cause == Cause.ENDED:
            # The end of the simulation ends it, after the run is complete.
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
                self._fault = event.fault
                self.begun.setdefault((event.fault, event.subject), []).append(at)
            return
        if isinstance(event, ParticipantEvent):
            return
        if isinstance(event, SendGoalRejected):
            self._aborts[f"{event.action}:rejected/{event.reason}"] = None
        robot = getattr(event, "robot", "")
        self._exercise(robot, event.kind)
        self._note_moment(at, "", event.kind, robot, "")

    def _exercise(self, robot: str, label: str) -> None:
        before, self._last[robot] = self._last.get(robot, ""), label
        features = self._features
        features[f"{robot}/{label}"] = None
        features[f"{robot}/{before}>{label}"] = None
        if self._fault:
            features[f"{self._fault}>{label}"] = None

    def _note_moment(self, at: float, goal: str, event: str, robot: str, action: str, lasted: float = 0.0) -> None:
        key = (goal or event, robot, action)
        self._counts[key] += 1
        nth = self._counts[key]
        if nth <= _MAX_NTH:
            self.moments.append(Moment(at, goal, event, robot, action, nth, lasted))


def code_of(result: Message | None) -> Any:
    """Return the error code of an action's result: Nav2's number, or the value of MoveIt's; 0 if there is none."""
    code = getattr(result, "error_code", 0)
    return getattr(code, "val", code)


class BatteryDraws(SelectiveSink):
    """A sink that measures how much each robot draws from its battery.

    Args:
        simulator: The simulator; it has not started.
        world: Its world.
    """

    def __init__(self, simulator: Simulator, world: World) -> None:
        self._simulator = simulator
        batteries = ((name, battery_of(world, name)) for name in world.robots)
        self._charged = {name: share_at_start(battery) for name, battery in batteries if battery is not None}
        self._begun: dict[str, tuple[str, float]] = {}
        self._draws: dict[str, Draw] = {}

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is wanted: events."""
        return topic is Topic.EVENTS

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self.emit if kind in (EventStamped, GoalChanged) else None

    def emit(self, output: Output) -> None:
        """Note how full a battery is when a goal or charging begins and ends."""
        if isinstance(output, GoalChanged):
            self._note_goal(output)
        elif isinstance(output, EventStamped):
            event = output.event
            if isinstance(event, ChargingBegan):
                self._note(event.robot, event.percentage)
            elif isinstance(event, ChargingEnded):
                self._charged[event.robot] = event.percentage

    def at_the_end(self) -> tuple[tuple[str, Draw], ...]:
        """Return what each robot with a battery has taken from it at most."""
        for name in self._charged:
            self._note(name, self._share(name))
        return tuple(self._draws.items())

    def _note_goal(self, change: GoalChanged) -> None:
        if change.robot not in self._charged:
            return
        share = self._share(change.robot)
        if change.status is GoalStatus.EXECUTING:
            self._begun[change.goal_id] = change.robot, share
        elif change.status.terminal and change.goal_id in self._begun:
            robot, before = self._begun.pop(change.goal_id)
            draw = self._draws.get(robot, Draw())
            self._draws[robot] = draw._replace(goal=max(draw.goal, before - share))

    def _share(self, name: str) -> float:
        robot = self._simulator.robots.get(name)
        return 0.0 if robot is None or robot.energy is None else robot.energy.battery.share(robot.now)

    def _note(self, robot: str, share: float) -> None:
        draw = self._draws.get(robot, Draw())
        self._draws[robot] = draw._replace(whole=max(draw.whole, self._charged.get(robot, 1.0) - share))


FILE: Final = "coverage.json"
"""The name of the file in the folder of results."""


class Novelty:
    """Keeps back the coverage of runs that have ticked nothing that was not ticked before, in this process."""

    def __init__(self) -> None:
        self._seen: dict[str, None] = {}

    def new_in(self, coverage: TreeCoverage) -> bytes:
        """Return the coverage of a run in few bytes; empty if it has nothing new."""
        keys = coverage.keys()
        if self._seen.keys() >= keys:
            return b""
        self._seen |= dict.fromkeys(keys)
        return packed(coverage)


class TotalCoverage:
    """The coverage of all runs together; only runs with new coverage are counted."""

    def __init__(self) -> None:
        self._all = TreeCoverage()

    def take(self, coverages: Iterable[bytes]) -> None:
        """Add what some runs have covered; an empty one has nothing new."""
        for coverage in coverages:
            if coverage:
                self._all.merge(unpacked(coverage))

    @property
    def share(self) -> str:
        """The covered share of the trees, in words; empty without a tree."""
        nodes = [node for tree in self._all.trees for node in self._all.nodes(tree)]
        return str(share_of(nodes)) if nodes else ""

    def never(self) -> tuple[str, ...]:
        """Return what no run has made the nodes of the trees do, a line for each node."""
        return tuple(
            f"{node.path}: never {' or '.join(words)}"
            for tree in self._all.trees
            for node in self._all.nodes(tree)
            if (words := node.never)
        )

    def write(self, folder: Path) -> None:
        """Write it as a file that ``bt-controller coverage`` reads, if there is a tree.

        Raises:
            OutputError: It can't be written.
        """
        if self._all.trees:
            write_coverage("coverage", folder / FILE, self._all)

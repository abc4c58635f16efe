"""The log of a run for its page: motions, goals, items, doors, events in words, and trees as they were ticked."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol

from pydantic import ValidationError

from hmrsim.actions import registry as actions
from hmrsim.drawing import Drawing
from hmrsim.engine.sim_time import stamp
from hmrsim.events import Event
from hmrsim.events.faults import FaultBegan, FaultEvent
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
from hmrsim.events.robots import (
    BatteryEmpty,
    BatteryEvent,
    DockQueued,
    MotionBegan,
    Stopped,
)
from hmrsim.events.simulation import Deleted, ParticipantEvent, Spawned, Teleported
from hmrsim.events.traffic import Waiting
from hmrsim.geometry import PlaceNames
from hmrsim.history.items import Items
from hmrsim.history.motion import INSTANT
from hmrsim.history.occurrence import BatterySeen, SceneSeen
from hmrsim.history.robots import Robots
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import Cause, GoalStatus
from hmrsim.report.compile import ReportInput, notes_of, report_of
from hmrsim.report.goals import target_of
from hmrsim.report.html import in_seconds
from hmrsim.report.model import Source
from hmrsim.report.sink import ReportSink
from hmrsim.report.story import Story
from hmrsim.run_page.poses import Poses
from hmrsim.timing.pacing import Watchers, unwatched

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Frame
    from hmrsim.history.occurrence import Occurrence
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.sinks import Sink
    from hmrsim.report.model import Report
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

_RUNNING: Final = "R"
"""The first letter of the status of a node that runs."""
MAX_LINES: Final = 20_000
"""The maximum number of events in words, and of ticks of a tree: what a controller that runs away does first."""
_WIDTH: Final = 560.0
"""The width of the map, in its own pixels."""
_WIDTH_OF_SPARSE: Final = 460.0
"""That of a sparse world, whose names are larger as a page scales them with the map."""
_COORDINATES: Final = re.compile(r"\([-+.e\d]+, [-+.e\d]+\)")
_SPARSE: Final = 20
"""The maximum number of points of a sparse world."""


class Line(NamedTuple):
    """A line of a run's log, which describes one event.

    Attributes:
        at: Seconds since the run began.
        subject: The robot, door or other entity that the event concerns; empty for the whole world.
    """

    at: float
    subject: str
    text: str
    severity: str


class Change(NamedTuple):
    """A value that holds from a time on.

    Attributes:
        at: Seconds since the run began.
        line: The number of lines up to the event that changed it.
    """

    at: float
    line: int
    value: Any


class Happening(NamedTuple):
    """An event by which runs are compared: any but faults, and controllers that come and go.

    Attributes:
        at: Nanoseconds since the run began.
        line: The number of lines before it.
        told: Whether it is a line itself.
    """

    at: int
    event: Event
    line: int
    told: bool


class TreeNode(Protocol):
    """A node of a behavior tree after a tick."""

    @property
    def depth(self) -> int:
        """The depth of the node; 0 for the root."""

    @property
    def kind(self) -> str:
        """The kind of the node, such as its class."""

    @property
    def name(self) -> str:
        """The name of the node in the tree."""

    @property
    def ports(self) -> str:
        """The values of its ports in words; empty if it has none."""

    @property
    def status(self) -> Any:
        """The status of the node, whose value is a word such as ``SUCCESS``."""

    @property
    def message(self) -> str:
        """The feedback message of the node's last tick."""


class Tick(NamedTuple):
    """A tree after a tick that has changed it.

    Attributes:
        at: Seconds since the run began.
        line: The number of lines before it.
        shape: The index of its nodes among those that the tree has had.
        statuses: The first letter of each node's status; ``I`` for a node that is not active.
        messages: The feedback messages, by the index of the node.
    """

    at: float
    line: int
    shape: int
    statuses: str
    messages: Mapping[int, str]


class Tree:
    """The tree of a robot, or of a fleet, over time.

    Attributes:
        shapes: The nodes that it has had, each with its depth, kind, name and ports.
        ticks: The ticks that have changed something.
    """

    def __init__(self) -> None:
        self.shapes: list[tuple[tuple[int, str, str, str], ...]] = []
        self.ticks: list[Tick] = []

    def note(self, at: float, line: int, nodes: Sequence[TreeNode]) -> None:
        """Record the nodes after a tick."""
        shape = tuple((node.depth, node.kind, node.name, node.ports) for node in nodes)
        if not self.shapes or self.shapes[-1] != shape:
            self.shapes.append(shape)
        statuses = "".join(str(node.status.value)[0] for node in nodes)
        messages = {i: node.message for i, node in enumerate(nodes) if node.message}
        tick = Tick(at, line, len(self.shapes) - 1, statuses, messages)
        if not self.ticks or (self.ticks[-1][2:] != tick[2:] and len(self.ticks) < MAX_LINES):
            self.ticks.append(tick)

    def running(self) -> Iterator[tuple[str, str]]:
        """Yield name and message of each leaf that runs after the last tick."""
        tick = self.ticks[-1]
        nodes = self.shapes[tick.shape]
        for i, ((depth, _, name, _), status) in enumerate(zip(nodes, tick.statuses, strict=True)):
            is_leaf = i + 1 == len(nodes) or nodes[i + 1][0] <= depth
            if is_leaf and status == _RUNNING:
                yield name, tick.messages.get(i, "")


class _Sink(ReportSink):
    """A sink that also passes on the goals that are sent."""

    def __init__(
        self, simulator: Simulator, take: Callable[[Occurrence], object], sent: Callable[[SendGoal], object]
    ) -> None:
        super().__init__(simulator, take)
        self._sent = sent

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Pass on a goal, and the time."""
        if isinstance(command, SendGoal):
            self._sent(command)
        super().commanded(command, by, now)


class RunLog:
    """Follows a run; make one for each run, and pass `watch` as the factory of a further sink.

    Attributes:
        world: The world of the run, once it is watched.
        lines: Its events in words, in order.
        happenings: Its events by which it is compared with another run, in order.
        faults: The times, in seconds, and numbers of the lines with which faults begin.
        trees: The trees of its robots, by robot.
        poses: The poses of its robots, by name.
        queues: The robots at a dock when another one began to queue for it, by the robot that queues and its time in
            nanoseconds.
        stuck: Why robots that execute goals do not go on at its end, in words.
    """

    def __init__(self) -> None:
        self.lines: list[Line] = []
        self.happenings: list[Happening] = []
        self.faults: list[tuple[float, int]] = []
        self.trees: dict[str, Tree] = defaultdict(Tree)
        self.poses: dict[str, Poses] = {}
        self._queued: list[tuple[str, int]] = []
        self.queues: dict[tuple[str, int], tuple[str, ...]] = {}
        self.stuck: list[str] = []
        self._story = Story()
        self._simulator: Simulator | None = None
        self._sink: ReportSink | None = None
        self._places = PlaceNames({})
        self._names: dict[str, str] = {}
        self._targets: dict[str, str] = {}
        self._executing: dict[str, dict[str, str]] = defaultdict(dict)
        self._changes: dict[str, dict[str, list[Change]]] = defaultdict(lambda: defaultdict(list))
        self._event_at = self._event_line = 0
        self._report: Report | None = None
        self._last = 0
        timeline = self._story.timeline
        timeline.on(SceneSeen, self._see)
        timeline.on(MotionBegan, lambda at, event: self._poses(event.robot).move(at, event))
        timeline.on((Stopped, Waiting, BatteryEmpty), lambda at, event: self._poses(event.robot).halt(at, event.at))
        timeline.on((Teleported, Spawned), self._put)
        timeline.derive_goals()
        timeline.on(DockQueued, lambda at, event: self._queued.append((event.robot, at)))
        timeline.on(Deleted, lambda _at, event: self._change("gone", event.entity, True))

    @property
    def world(self) -> World:
        """The world of the run."""
        if self._simulator is None:
            raise AssertionError
        return self._simulator.world

    @property
    def watched(self) -> bool:
        """True if the run has begun: a run whose controller can't be loaded has not."""
        return self._simulator is not None

    @property
    def sparse(self) -> bool:
        """True if there is room for large names on the map, and for names of items."""
        return len(self.world.points) <= _SPARSE

    @property
    def width(self) -> float:
        """The width of the map, in its own pixels."""
        return _WIDTH_OF_SPARSE if self.sparse else _WIDTH

    @cached_property
    def frame(self) -> Frame:
        """The window of the map."""
        return Drawing(self.world, width=self.width, legend=False).frame

    def watch(self, simulator: Simulator, _pacing: object = None) -> list[Sink]:
        """Return the sinks that follow a simulator, which has not started."""
        self._simulator = simulator
        self._places = PlaceNames(simulator.world.points)
        self._names = {f"({x:g}, {y:g})": self._places.of((x, y)) for x, y in simulator.world.points.values()}
        doors, lanes, items = self._story.doors, self._story.lanes, Items(self._story.timeline, simulator.world)
        doors.watch_all(lambda door: self._change("door", door, doors.is_(door, "open")))
        lanes.watch_all(lambda lane: self._change("lane", "-".join(lane), lanes.is_closed(lane)))
        items.watch_all(lambda item: self._change("item", item, items[item].carrier or items[item].at))
        robots = Robots(self._story.timeline, simulator.world)
        robots.watch_all(lambda robot: self._change("state", robot, robots.state_of(robot)))
        self._sink = _Sink(simulator, self._take, self._note_sent)
        return [self._sink]

    def watchers(self, further: Watchers = unwatched) -> Watchers:
        """Return a function that makes the sinks of a run: further ones, and those of this log."""
        return lambda simulator, pacing: [*further(simulator, pacing), *self.watch(simulator)]

    def note_tick(self, robot: str, at: float | None, nodes: Sequence[TreeNode]) -> None:
        """Record the nodes of a tree after a tick at a simulated time, in seconds."""
        self.trees[robot].note((at or 0.0) + in_seconds(self._story.timeline.offset), len(self.lines), nodes)

    def report(self) -> Report:
        """Return the report of the run, which ends by that."""
        if self._report is None:
            if self._simulator is None or self._sink is None:
                raise AssertionError
            self._sink.weigh_all()
            self._story.end(stamp(self._simulator.now))
            source = Source(kind="trace", exact=True, complete=True, notes=tuple(notes_of(self._story)))
            report = report_of(ReportInput(self._story, source, {}, {"name": self.world.name}))
            targets = self._targets
            goals = (
                goal.model_copy(update={"target": targets.get(goal.goal_id, goal.target)}) for goal in report.goals
            )
            self._report = report.model_copy(update={"goals": tuple(goals)})
        return self._report

    @property
    def quiet_from(self) -> float:
        """The seconds from the start of the run to its last change."""
        moved = [poses.frames[-1].at for poses in self.poses.values() if poses.frames]
        return in_seconds(max([self._last, *moved]))

    @property
    def changed_until(self) -> float:
        """The seconds from the start of the run to the last change of a goal, robot, item, door or lane."""
        moved = [in_seconds(poses.frames[-1].at) for poses in self.poses.values() if poses.frames]
        return max(
            moved + [changes[-1].at for known in self._changes.values() for changes in known.values()], default=0.0
        )

    def awaited(self) -> list[str]:
        """Return the leaves of the trees that run after the last tick."""
        return [
            f"the tree of {robot} runs {name!r}{f' ({message})' if message else ''}"
            for robot, tree in self.trees.items()
            for name, message in tree.running()
        ]

    def changes(self, kind: str) -> dict[str, list[Change]]:
        """Return the changes of each ``item``, ``door`` or ``lane``, or of robots' ``state``, ``goals`` or ``gone``."""
        return dict(sorted(self._changes[kind].items()))

    def describe(self, event: Event) -> str:
        """Return an event as a sentence, with the names of places."""
        return f"{event.subject} {self._text(event)}".lstrip()

    def _note_sent(self, command: SendGoal) -> None:
        """Record what a goal asks for, which the event of its rejection does not say."""
        if command.goal_id and command.goal is not None:
            self._targets[command.goal_id] = self._target(command)

    def _target(self, event: GoalAccepted | SendGoal) -> str:
        """Return what a goal asks for in a few words: fields that have no default, with the name of the first point."""
        action, asked = actions().get(event.action), event.goal
        if action is not None:
            with suppress(ValidationError):
                asked = action.goal.model_validate(asked).model_dump(mode="json", exclude_defaults=True)
        # A pose at the origin is the default, too.
        target, at = target_of(asked or event.goal)
        return target if at is None else target.replace(f"({at[0]:g}, {at[1]:g})", self._places.of(at), 1)

    def _stuck(self) -> list[str]:
        if self._simulator is None:
            raise AssertionError
        return [*map(self._with_places, self._simulator.roster.admission.causes.stuck().values())]

    def _text(self, event: Event) -> str:
        text = event.text({"goal": lambda _goal: self._target_of(event), "point": self._point})
        if isinstance(event, GoalStatusChanged | SendGoalRejected) and (target := self._targets.get(event.goal_id)):
            what, colon, why = text.partition(":")
            text = f"{what} ({target}){colon}{why}"
        return self._with_places(text)

    def _with_places(self, text: str) -> str:
        """Return a text with the names of places instead of their coordinates."""
        return _COORDINATES.sub(lambda match: self._names.get(match[0], match[0]), text)

    def _target_of(self, event: Event) -> str:
        if not isinstance(event, GoalAccepted):
            return ""
        if event.goal_id not in self._targets:
            self._targets[event.goal_id] = self._target(event)
        return self._targets[event.goal_id]

    def _point(self, at: Any) -> str:
        return self._places.of((float(at[0]), float(at[1])))

    def _poses(self, robot: str) -> Poses:
        known = self.poses.get(robot)
        if known is None:
            known = self.poses[robot] = Poses(1.0 / self.frame.scale)
        return known

    def _take(self, occurrence: Occurrence) -> None:
        event = occurrence.event
        if self._queued and not isinstance(event, BatterySeen):
            # The battery is read within the event of the queue, which is recorded after it.
            self._note_queues()
        if isinstance(event, GoalStatusChanged) and event.cause == Cause.ENDED:
            # It ended with the simulation, when the run was over; until now, its robot may have waited.
            self.stuck = self.stuck or self._stuck()
            return
        told = isinstance(event, Event) and len(self.lines) < MAX_LINES and _is_told(event)
        self._event_at, self._event_line = occurrence.at, len(self.lines) + told
        self._story.take(occurrence)
        if not isinstance(event, Event):
            return
        at = occurrence.at + self._story.timeline.offset
        self._follow_goals(event)
        if not isinstance(event, FaultEvent | ParticipantEvent):
            self.happenings.append(Happening(at, event, len(self.lines), told))
        if not isinstance(event, ParticipantEvent | BatteryEvent):
            self._last = at
        if told:
            if isinstance(event, FaultBegan):
                self.faults.append((in_seconds(at), len(self.lines)))
            self.lines.append(Line(round(in_seconds(at), 6), event.subject, self._text(event), event.severity.value))

    def _change(self, kind: str, name: str, value: Any) -> None:
        """Record a value that holds from now on, unless it is that of the last record; None if it is gone."""
        changes, now = self._changes[kind][name], self._story.now
        if value != (changes[-1].value if changes else None):
            # A change between two events, such as at the end of a motion, comes before the second one.
            between = now + INSTANT < self._event_at + self._story.timeline.offset
            changes.append(Change(in_seconds(now), len(self.lines) if between else self._event_line, value))

    def _follow_goals(self, event: Event) -> None:
        """Record the goals that a robot executes, in words."""
        if isinstance(event, GoalAccepted):
            goals = self._executing[event.robot]
            goals[event.goal_id] = f"{event.action} {self._target_of(event)}".strip()
        elif isinstance(event, GoalStatusChanged) and GoalStatus(event.status).terminal:
            goals = self._executing[event.robot]
            goals.pop(event.goal_id, None)
        else:
            return
        self._change("goals", event.robot, [*goals.values()])

    def _note_queues(self) -> None:
        """Record the robots ahead of those that joined a queue with the last event, which has only their place."""
        if self._simulator is not None:
            for name, at in self._queued:
                robot = self._simulator.robots.get(name)
                holders = self._simulator.roster.admission.causes.blockers(robot) if robot is not None else ()
                self.queues[name, at] = tuple(sorted(each.name for each in holders))
        self._queued.clear()

    def _put(self, at: int, event: Teleported | Spawned) -> None:
        name = event.entity
        if name in self.poses or (isinstance(event, Spawned) and event.type != "item"):
            self._poses(name).put(at, *event.at, getattr(event, "yaw", None))
            self._change("gone", name, False)

    def _see(self, at: int, scene: SceneSeen) -> None:
        poses = {robot["name"]: robot["pose"] for robot in scene.fields["robots"]}
        for name, pose in poses.items():
            self._poses(name).put(at, *pose)
        for name in self.poses:
            self._change("gone", name, name not in poses)


def _is_told(event: Event) -> bool:
    """Return whether an event has a line."""
    if isinstance(event, GoalStatusChanged):
        return event.traced and GoalStatus(event.status).terminal
    return event.traced or isinstance(event, GoalAccepted)

"""The conditions that participants in lockstep wait for.

A condition is looked at when it is set, and with each message of its topic, as a subscriber would get it. The instant
at which the level of a battery will be reached is computed, and computed again with each change of its load.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Final

from hmrsim.engine.sim_time import end_of_instant
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.protocol.commands import InterestChanged, Read
from hmrsim.protocol.goal import Refused
from hmrsim.protocol.outputs import EventStamped, FeedbackSent, GoalChanged, Sampled
from hmrsim.protocol.topics import Topic, Watching
from hmrsim.timing.battery_levels import BatteryLevels, is_level

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Watch
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.battery_levels import ConditionId

MAX_WATCHED: Final = 10_000
"""The conditions of a participant."""


class Conditions:
    """The conditions of all participants.

    Args:
        on_met: Called when one is met.

    Attributes:
        watched: The conditions of each participant that has any, by name.
        topics: The topics whose messages have to be looked at, as of the last `refresh`.
        met: The names of each participant's conditions that were met and not yet reported to it.
        changed: Whether conditions were added or removed since the last `refresh`.
    """

    def __init__(self, simulator: Simulator, on_met: Callable[[], None]) -> None:
        self._simulator = simulator
        self._on_met = on_met
        # Those that need a topic's messages, by topic, and by robot or, of events, by kind; empty for any kind.
        self._compared: dict[tuple[Topic, str], dict[ConditionId, Watch]] = {}
        # Those on the level of a battery, by robot.
        self._levels: dict[str, dict[ConditionId, Watch]] = {}
        self.watched: dict[str, dict[str, Watch]] = {}
        self.met: dict[str, dict[str, None]] = {}
        self.changed = False
        # The number of conditions that need a topic's messages, and the topics that are subscribed to.
        self._needed: defaultdict[Topic, int] = defaultdict(int)
        self.topics: frozenset[Topic] = frozenset()
        # The batteries that are watched, when each reaches a level next, and these times in order.
        self._batteries: dict[str, BatteryLevels] = {}
        self._next: dict[str, float] = {}
        self._heap: list[tuple[float, str]] = []

    @property
    def due(self) -> float:
        """When a battery reaches a level that a condition is about, in simulated seconds; infinite if none does."""
        heap = self._heap
        while heap and self._next.get(heap[0][1]) != heap[0][0]:
            heapq.heappop(heap)
        return heap[0][0] if heap else math.inf

    def take_met(self, participant: str) -> tuple[str, ...]:
        """Return the conditions of a participant that were met, by name, and forget them."""
        # In what order they were met at one instant could depend on who else subscribes.
        return tuple(sorted(self.met.pop(participant, ())))

    def watch(self, participant: str, watch: Watch) -> Watching | Refused:
        """Watch a condition until it is met; it may be met at once."""
        names = self.watched.get(participant, {})
        if watch.name not in names and len(names) >= MAX_WATCHED:
            return Refused("watch", watch.name, f"{participant!r} watches {MAX_WATCHED} conditions; there are no more")
        try:
            found = list(self._current(watch))
        except LookupError as error:
            return Refused("key", watch.robot, str(error))
        self.unwatch(participant, watch.name)
        ours = participant, watch.name
        if any(map(watch.holds, found)):
            self._note_met(ours)
            return Watching(watching=True)
        self.watched.setdefault(participant, {})[watch.name] = watch
        if _needs_messages(watch):
            self._compared.setdefault(_place(watch), {})[ours] = watch
            self._needed[watch.topic] += 1
            self.changed = True
        if _has_levels(watch):
            self._levels.setdefault(watch.robot, {})[ours] = watch
            self._watch_level(ours, watch)
        return Watching(watching=True)

    def unwatch(self, participant: str, name: str) -> Watching:
        """Watch a condition no longer."""
        names = self.watched.get(participant, {})
        if watch := names.pop(name, None):
            ours = participant, name
            if _needs_messages(watch):
                self._needed[watch.topic] -= 1
                self.changed = True
                place = _place(watch)
                del self._compared[place][ours]
                if not self._compared[place]:
                    del self._compared[place]
            if _has_levels(watch):
                self._unwatch_level(ours, watch.robot)
            if not names:
                del self.watched[participant]
        if met := self.met.get(participant):
            met.pop(name, None)
            if not met:
                del self.met[participant]
        return Watching(watching=False)

    def drop(self, participant: str) -> None:
        """Forget all conditions of a participant."""
        for name in list(self.watched.get(participant, ())):
            self.unwatch(participant, name)
        self.met.pop(participant, None)

    def refresh(self) -> None:
        """Subscribe to exactly the topics that conditions need now."""
        self.changed = False
        wanted = frozenset(topic for topic, number in self._needed.items() if number)
        if wanted != self.topics:
            self.topics = wanted
            self._simulator.submit(InterestChanged())

    def follow(self) -> None:
        """Follow the robots that were added, removed or reconnected."""
        for robot in self._levels:
            self._observe(robot)

    def look(self) -> None:
        """Look at the batteries that reach a level now."""
        now = self._simulator.now
        while self.due <= end_of_instant(now):
            _, robot = heapq.heappop(self._heap)
            levels = self._batteries[robot]
            state = levels.energy.state()
            for ours, watch in levels.take(now):
                if watch.holds(state):
                    self._meet(ours)
                else:
                    levels.add(ours, watch, now)
            if robot in self._batteries:
                self._expect(robot, looked=True)

    def emit(self, output: Output) -> None:
        """Check the conditions on the topic of an output."""
        match output:
            case Sampled(topic, robot, message):
                self._compare((topic, robot), message)
            case FeedbackSent(robot, action, goal_id, feedback):
                self._compare((Topic.FEEDBACK, robot), {"goal_id": goal_id, "feedback": feedback}, action)
            case EventStamped(at, event):
                self._compare_event(event.kind, at, lambda: event)
            case GoalChanged():
                self._compare_event(GoalStatusChanged.kind, output.stamp, output.event)

    def _compare_event(self, kind: str, at: int, event: Callable[[], Event]) -> None:
        places = [place for place in ((Topic.EVENTS, kind), (Topic.EVENTS, "")) if place in self._compared]
        if places:
            message = {"stamp": Time.from_nanoseconds(at), "kind": kind, **event().as_dict()}
            for place in places:
                self._compare(place, message)

    def _compare(self, place: tuple[Topic, str], message: object, action: str = "") -> None:
        for ours, watch in list(self._compared.get(place, {}).items()):
            if watch.action == action and watch.holds(message):
                self._meet(ours)

    def _meet(self, ours: ConditionId) -> None:
        self.unwatch(*ours)
        self._note_met(ours)

    def _note_met(self, ours: ConditionId) -> None:
        participant, name = ours
        self.met.setdefault(participant, {})[name] = None
        self._on_met()

    def _current(self, watch: Watch) -> Iterator[object]:
        """Yield the latest message of a condition's topic, or the present feedback of its action.

        Raises:
            LookupError: There is no such topic.
        """
        simulator = self._simulator
        if watch.topic is Topic.EVENTS or watch.robot in simulator.dispatcher.cut_off:
            return
        if watch.topic is Topic.FEEDBACK:
            if watch.robot not in simulator.robots:
                raise LookupError(f"no robot {watch.robot!r}")
            for each in simulator.dispatcher.feedback.current():
                if (each.robot, each.action) == (watch.robot, watch.action):
                    yield {"goal_id": each.goal_id, "feedback": each.feedback}
            return
        match simulator.readings.read(Read(watch.topic, watch.robot)):
            case Sampled(message=message):
                yield message
            case Refused(message=why):
                raise LookupError(why)

    def _watch_level(self, ours: ConditionId, watch: Watch) -> None:
        robot = watch.robot
        if robot not in self._batteries:
            self._observe(robot)
            return
        due = self._batteries[robot].add(ours, watch, self._simulator.now)
        if due < self._next[robot]:
            self._expect_at(robot, due)

    def _unwatch_level(self, ours: ConditionId, robot: str) -> None:
        del self._levels[robot][ours]
        if robot in self._batteries:
            self._batteries[robot].remove(ours)
        if not self._levels[robot]:
            del self._levels[robot]
            self._ignore(robot)

    def _observe(self, robot: str) -> None:
        """Learn of each change of a battery's load."""
        self._ignore(robot)
        there = self._simulator.robots.get(robot)
        if there is None or there.energy is None or robot in self._simulator.dispatcher.cut_off:
            return
        levels = self._batteries[robot] = BatteryLevels(there.energy, partial(self._expect, robot))
        for ours, watch in self._levels[robot].items():
            levels.add(ours, watch, self._simulator.now)
        self._expect(robot)

    def _ignore(self, robot: str) -> None:
        if levels := self._batteries.pop(robot, None):
            levels.close()
            self._next.pop(robot, None)

    def _expect(self, robot: str, *, looked: bool = False) -> None:
        """Compute when a battery is to be looked at next; now, too, unless it was *looked* at just now."""
        self._expect_at(robot, self._batteries[robot].due(self._simulator.now, looked=looked))

    def _expect_at(self, robot: str, due: float) -> None:
        self._next[robot] = due
        if due < math.inf:
            heapq.heappush(self._heap, (due, robot))
            # The events under way end there.
            env = self._simulator.env
            env.horizon = min(env.horizon, end_of_instant(max(due, env.now)))


def _place(watch: Watch) -> tuple[Topic, str]:
    """Return a condition's topic, and its robot or the kind of events that it is about; empty for any."""
    kinds = [each.value for each in watch.comparisons if each[:2] == (("kind",), "==")]
    return watch.topic, watch.robot or (kinds[0] if kinds and isinstance(kinds[0], str) else "")


def _has_levels(watch: Watch) -> bool:
    return watch.topic is Topic.BATTERY_STATE and any(map(is_level, watch.comparisons))


def _needs_messages(watch: Watch) -> bool:
    """Return whether it does not do to compute when a condition is met."""
    return not (_has_levels(watch) and all(map(is_level, watch.comparisons)))

"""The conditions that participants in lockstep wait for.

A condition is looked at when it is set, and with each message of its topic, as a subscriber would get it. The level of
a battery is a formula of time between two changes of its load: so the instant is computed at which it will be reached,
and computed again with each change.
"""

from __future__ import annotations

import heapq
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Final

from hmrsim.engine.sim_time import end_of_instant, stamp
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time
from hmrsim.protocol.answers import Refused
from hmrsim.protocol.commands import InterestChanged, Read
from hmrsim.protocol.conditions import ORDERS, Watching
from hmrsim.protocol.outputs import EventStamped, FeedbackSent, GoalChanged, Sampled
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.protocol.conditions import Comparison, Watch
    from hmrsim.protocol.outputs import Output
    from hmrsim.robots.power import Energy
    from hmrsim.simulation.simulator import Simulator

MAX_WATCHED: Final = 10_000
"""The conditions of a participant."""

_Id = tuple[str, str]
"""A participant, and what it calls a condition."""

_SHARE: Final = ("percentage",)
_LEVELS: Final = (_SHARE, ("charge",))
"""The fields of a battery's state whose values are computed for any time."""

_FALLING: Final = ("<", "<=")


class Conditions:
    """The conditions of all participants.

    Args:
        on_met: Called when one is met.
    """

    def __init__(self, simulator: Simulator, on_met: Callable[[], None]) -> None:
        self._simulator = simulator
        self._on_met = on_met
        # By topic, and by robot or, of events, by kind; empty for any kind.
        self._all: dict[tuple[Topic, str], dict[_Id, Watch]] = {}
        self._names: dict[str, dict[str, Watch]] = {}
        self._met: dict[str, list[str]] = {}
        # How many conditions need a topic's messages, and the topics of which that was told.
        self._needed: Counter[Topic] = Counter()
        self._topics: frozenset[Topic] = frozenset()
        # The batteries that are watched, when each reaches a level next, and these times in order.
        self._batteries: dict[str, tuple[Energy, Callable[[], None]]] = {}
        self._next: dict[str, float] = {}
        self._heap: list[tuple[float, str]] = []

    def __bool__(self) -> bool:
        """Return whether there is a condition."""
        return bool(self._names)

    @property
    def met(self) -> tuple[str, ...]:
        """The participants that were not told of a condition that was met."""
        return tuple(self._met)

    @property
    def due(self) -> float:
        """When a battery reaches a level that a condition is about, in simulated seconds; infinite if none does."""
        heap = self._heap
        while heap and self._next.get(heap[0][1]) != heap[0][0]:
            heapq.heappop(heap)
        return heap[0][0] if heap else math.inf

    def wants(self, topic: Topic) -> bool:
        """Return whether messages of a topic have to be looked at."""
        return topic in self._topics

    def take_met(self, participant: str) -> tuple[str, ...]:
        """Return the conditions of a participant that were met, by name, and forget them."""
        # In what order they were met at one instant could depend on who else subscribes.
        return tuple(sorted(self._met.pop(participant, ())))

    def watch(self, participant: str, watch: Watch) -> Watching | Refused:
        """Watch a condition until it is met; it may be met at once."""
        names = self._names.get(participant, {})
        if watch.name not in names and len(names) >= MAX_WATCHED:
            return Refused("watch", watch.name, f"{participant!r} watches {MAX_WATCHED} conditions; there are no more")
        try:
            found = list(self._current(watch))
        except LookupError as error:
            return Refused("key", watch.robot, str(error))
        self.unwatch(participant, watch.name)
        self._names.setdefault(participant, {})[watch.name] = watch
        self._all.setdefault(_place(watch), {})[participant, watch.name] = watch
        self._needed[watch.topic] += _needs_messages(watch)
        if any(map(watch.holds, found)):
            self._meet((participant, watch.name))
        elif watch.topic is Topic.BATTERY_STATE:
            if watch.robot in self._batteries:
                self._expect(watch.robot, [watch])
            else:
                self._observe(watch.robot)
        return Watching(watching=True)

    def unwatch(self, participant: str, name: str) -> Watching:
        """Watch a condition no longer."""
        names = self._names.get(participant, {})
        if watch := names.pop(name, None):
            place = _place(watch)
            self._needed[watch.topic] -= _needs_messages(watch)
            del self._all[place][participant, name]
            if not self._all[place]:
                del self._all[place]
                self._ignore(place)
            if not names:
                del self._names[participant]
        if name in (met := self._met.get(participant, [])):
            met.remove(name)
        return Watching(watching=False)

    def drop(self, participant: str) -> None:
        """Forget all conditions of a participant."""
        for name in list(self._names.get(participant, ())):
            self.unwatch(participant, name)
        self._met.pop(participant, None)

    def refresh(self) -> None:
        """Have the topics published that are looked at now, and no others."""
        wanted = frozenset(topic for topic, number in self._needed.items() if number)
        if wanted != self._topics:
            self._topics = wanted
            self._simulator.submit(InterestChanged())

    def follow(self) -> None:
        """Take note that robots have come or gone, or can be reached again."""
        for topic, robot in list(self._all):
            if topic is Topic.BATTERY_STATE:
                self._observe(robot)

    def look(self) -> None:
        """Look at the batteries that reach a level now."""
        while self.due <= end_of_instant(self._simulator.now):
            _, robot = heapq.heappop(self._heap)
            energy, _ = self._batteries[robot]
            state = energy.state()
            for ours, watch in list(self._all.get((Topic.BATTERY_STATE, robot), {}).items()):
                if watch.holds(state):
                    self._meet(ours)
            if robot in self._batteries:
                self._expect(robot, looked=True)

    def emit(self, output: Output) -> None:
        """Look at a message."""
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
        places = [place for place in ((Topic.EVENTS, kind), (Topic.EVENTS, "")) if place in self._all]
        if places:
            message = {"stamp": Time.from_nanoseconds(at), "kind": kind, **event().as_dict()}
            for place in places:
                self._compare(place, message)

    def _compare(self, place: tuple[Topic, str], message: object, action: str = "") -> None:
        for ours, watch in list(self._all.get(place, {}).items()):
            # Where it does to compute, messages that others have subscribed to make no difference.
            if watch.action == action and _needs_messages(watch) and watch.holds(message):
                self._meet(ours)

    def _meet(self, ours: _Id) -> None:
        self.unwatch(*ours)
        participant, name = ours
        self._met.setdefault(participant, []).append(name)
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

    def _observe(self, robot: str) -> None:
        """Learn of each change of a battery's load."""
        self._ignore((Topic.BATTERY_STATE, robot))
        there = self._simulator.robots.get(robot)
        if there is None or there.energy is None or robot in self._simulator.dispatcher.cut_off:
            return
        changed = partial(self._expect, robot)
        self._batteries[robot] = there.energy, changed
        there.energy.observe(changed)
        changed()

    def _ignore(self, place: tuple[Topic, str]) -> None:
        topic, robot = place
        if topic is Topic.BATTERY_STATE and robot in self._batteries:
            energy, changed = self._batteries.pop(robot)
            energy.ignore(changed)
            self._next.pop(robot, None)

    def _expect(self, robot: str, added: Iterable[Watch] | None = None, *, looked: bool = False) -> None:
        """Compute when a battery is to be looked at next; now, too, unless it was *looked* at just now.

        Only the conditions that were *added* are new, if any are given.
        """
        energy, _ = self._batteries[robot]
        watches = self._all[Topic.BATTERY_STATE, robot].values() if added is None else added
        levels = [each for watch in watches for each in watch.comparisons if _is_level(each)]
        due = _next_due(energy, levels, self._simulator.now, looked=looked)
        if added is not None:
            due = min(due, self._next.get(robot, math.inf))
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


def _is_level(comparison: Comparison) -> bool:
    return comparison.path in _LEVELS and comparison.operator in ORDERS


def _needs_messages(watch: Watch) -> bool:
    """Return whether it does not do to compute when a condition is met."""
    return watch.topic is not Topic.BATTERY_STATE or not all(map(_is_level, watch.comparisons))


def _next_due(energy: Energy, comparisons: Iterable[Comparison], now: float, *, looked: bool) -> float:
    """Return from when on the first of some comparisons of a battery's level holds: now, or after whole nanoseconds.

    Infinite if none ever does as things are; those that hold now don't count if they were *looked* at.
    """
    present: dict[tuple[str, ...], float] = {path: _level(energy, path, now) for path in _LEVELS}
    nearest: dict[tuple[tuple[str, ...], str], float] = {}
    for path, operator, value in comparisons:
        if not isinstance(value, (int, float)):
            continue
        if ORDERS[operator](present[path], value):
            if not looked:
                return now
            continue
        # A level that rises or falls reaches the nearest value first.
        near = max if operator in _FALLING else min
        nearest[path, operator] = near(value, nearest.get((path, operator), value))
    dues = (_reached(energy, path, operator, value, now) for (path, operator), value in nearest.items())
    return min(dues, default=math.inf)


def _level(energy: Energy, path: tuple[str, ...], seconds: float) -> float:
    battery = energy.battery
    return battery.share(seconds) if path == _SHARE else battery.ampere_hours(battery.charge(seconds))


def _reached(energy: Energy, path: tuple[str, ...], operator: str, value: float, now: float) -> float:
    """Return from when on a comparison holds that does not hold now; infinite if it never does as things are."""
    battery = energy.battery
    flow, charge = battery.flow(now), battery.charge(now)
    level = value * battery.usable if path == _SHARE else battery.energy(value)
    ahead = 0.0 <= level <= charge if flow < 0.0 else flow > 0.0 and charge <= level <= battery.usable
    reached = battery.reaches(level) if ahead else math.inf
    if reached == math.inf:
        return math.inf
    # The first instant is two nanoseconds long: within it time does not advance.
    instant = stamp(now)
    high = max(math.ceil(reached * NANOSECONDS), instant + 1)
    holds = ORDERS[operator]
    return _first(lambda at: holds(_level(energy, path, at / NANOSECONDS), value), instant, high) / NANOSECONDS


def _first(holds: Callable[[int], bool], low: int, high: int) -> float:
    """Return the first whole number above *low* at which a condition holds, which is about *high*, if there is one."""
    step = 1
    while not holds(high):
        low, high, step = high, high + step, step * 2
        if step > NANOSECONDS:
            return math.inf
    low = max(low, high - 8) if not holds(max(low, high - 8)) else low
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high

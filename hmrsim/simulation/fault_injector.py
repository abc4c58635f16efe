"""The injection of faults from the world file and from clients.

Faults begin at a time, or some time after an event. Time does not advance only to begin a fault, but it does advance to
end one. Random times and effects depend only on the seed, the subject and the kind of fault, so that other parts of the
world don't change them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, Final, TypeVar

from simpy import Timeout

from hmrsim.components.battery import Battery
from hmrsim.diagnostics import Finding
from hmrsim.distributions import Distribution, latest
from hmrsim.engine.internal_errors import BUGS
from hmrsim.events.faults import FaultBegan, FaultEnded, FaultMissed
from hmrsim.faults import Case, FaultType, Spell
from hmrsim.faults import registry as faults
from hmrsim.simulation.anchors import Anchors
from hmrsim.world_checks.faults import There, flaws, missing

if TYPE_CHECKING:
    import random

    from hmrsim.engine.chance import Chance
    from hmrsim.engine.environment import Alarm, Environment
    from hmrsim.engine.internal_errors import InternalErrors
    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.faults import AnyFault, Occurrence
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.entities import Roster
    from hmrsim.world.model import World

R = TypeVar("R")
V_co = TypeVar("V_co", covariant=True)


class InternalFault(Spell):
    """A mark on a robot that a bug has affected, without further effect.

    Attributes:
        robot: The robot's name.
        error: The source and the exception.
    """

    robot: str
    error: str


MOST_AT_ONCE: Final = 100
"""Maximum active faults of a kind on one subject, as the effect of each depends on all others."""

_MAX_DIGITS: Final = 10
"""Numbers with this many digits are not reused in the names of faults."""

_INTERNAL: Final = FaultType(name="internal_error", settings=InternalFault, begin=lambda _case: lambda: None)


@dataclass(eq=False)
class InjectedFault:
    """A fault that is scheduled, active, or over.

    Attributes:
        settings: The settings as requested, with distributions.
        drawn: The settings of the current occurrence, with a number drawn from each distribution.
        times: Random numbers for its times.
        effects: Random numbers for its effects.
        draw: Returns the value of a field for the next occurrence.
        since: When it last began, in simulated seconds.
        end: Ends it; None while it is not active.
        alarm: Begins it; None if it is not scheduled.
        timer: Ends it when its duration is over; None if it has no duration or is not active.
    """

    name: str
    fault: AnyFault
    settings: Any
    drawn: Any
    times: random.Random
    effects: random.Random
    draw: Callable[[str, Any], float]
    since: float = 0.0
    end: Callable[[], None] | None = None
    alarm: Alarm | None = None
    timer: Timeout | None = None

    def draw_all(self) -> None:
        """Draw the value of each random field for the next occurrence."""
        values = {
            field: self.draw(field, value)
            for field, value in sorted(self.settings.__dict__.items())
            if isinstance(value, Distribution)
        }
        if values:
            self.drawn = self.settings.model_copy(update=values)

    def began(self) -> FaultBegan:
        """Return the event that reports its beginning."""
        return FaultBegan(self.fault.name, self.name, self._reported())

    def ended(self) -> FaultEnded:
        """Return the event that reports its end."""
        return FaultEnded(self.fault.name, self.name, self._reported())

    def missed(self, why: str) -> FaultMissed:
        """Return the event that reports why it does not begin."""
        return FaultMissed(self.fault.name, self.name, self._reported(), why)

    def _reported(self) -> dict[str, Any]:
        """Return the settings for events."""
        settings: Occurrence = self.drawn
        return settings.model_dump(mode="json", exclude_none=True, exclude={"name"})


class FaultInjector:
    """Schedules, begins and ends the faults of a simulation.

    Args:
        errors: Handles the errors that faults raise.
        listen: Called with `anchors` when the topics that they need change.

    Attributes:
        known: The active and scheduled faults, by name.
        anchors: Waits for the events after which some faults begin.
    """

    def __init__(
        self,
        env: Environment,
        roster: Roster,
        chance: Chance,
        publisher: EventPublisher,
        errors: InternalErrors,
        *,
        listen: Callable[[Anchors], None],
    ) -> None:
        self.known: dict[str, InjectedFault] = {}
        self.anchors = Anchors(listen)
        self._env = env
        self._roster = roster
        self._chance = chance
        self._publisher = publisher
        self._errors = errors
        self._seed = 0
        self._count: defaultdict[tuple[str, str], int] = defaultdict(int)
        self._reserved: set[str] = set()
        self._next: dict[str, int] = {}
        self._active: dict[int, InjectedFault] = {}
        # The active faults by subject and kind: a client may inject thousands.
        self._by_subject: dict[tuple[str, str], dict[int, InjectedFault]] = {}

    def begin(self, world: World, seed: int) -> None:
        """Schedule the future faults of a world; no faults may be active or scheduled."""
        self._seed = seed
        self._count.clear()
        self._next.clear()
        now = self._env.now
        listed = [
            (faults()[fault.type], faults()[fault.type].settings.model_validate(fault.model_extra or {}))
            for fault in world.faults
        ]
        self._reserved = {settings.name for _, settings in listed if settings.name}
        for kind, settings in listed:
            if settings.at is None or latest(settings.at) >= now:
                self._schedule(self._add(kind, settings))

    def end(self) -> None:
        """Clear all faults, active or scheduled."""
        for injected in [*self.known.values()]:
            self._clear(injected)

    def end_all_on(self, name: str) -> None:
        """End the faults of a robot that is about to be removed; recurring ones stay scheduled for its name."""
        for injected in [active for active in self._active.values() if active.settings.subject == name]:
            self._finish(injected)

    def active_on(self, name: str) -> list[str]:
        """Return the kinds of fault that are active on a robot or a door."""
        return sorted({injected.fault.name for injected in self._active.values() if injected.settings.subject == name})

    def inject(self, fault: AnyFault, settings: Occurrence) -> str | list[Finding]:
        """Inject a fault at its time or after its event, or now if it has neither.

        Returns:
            Its name, or the reasons why it is impossible.
        """
        problems = [*flaws(fault, settings, self._there(), now=self._env.now, names=self.known)]
        at_once = settings.at is None and settings.mean_time_between is None and settings.when is None
        if at_once and (full := self._full(fault, settings)):
            problems.append(Finding((), full))
        if problems:
            return problems
        injected = self._add(fault, settings)
        if at_once:
            injected.draw_all()
            self._begin(injected)
        else:
            self._schedule(injected)
        return injected.name

    def mark(self, robot: str, error: str) -> None:
        """Mark a robot that a bug has affected, once per error, until the mark is cleared."""
        mark = InternalFault(robot=robot, error=error)
        if robot in self._roster.robots and all(injected.settings != mark for injected in self._active.values()):
            self._begin(self._add(_INTERNAL, mark))

    def clear(self, name: str) -> None:
        """Clear the fault of this name, active or scheduled."""
        self._clear(self.known[name])

    def _add(self, fault: AnyFault, settings: Occurrence) -> InjectedFault:
        key = _key(fault, settings)
        self._count[key] += 1
        seed = "/".join((str(self._seed), *key, str(self._count[key])))
        name = settings.name or self._free_name(fault)
        times, effects = self._chance.stream(seed), self._chance.stream(f"{seed}/what")
        injected = InjectedFault(name, fault, settings, settings, times, effects, self._drawer(key))
        self.known[name] = injected
        return injected

    def _drawer(self, key: tuple[str, str]) -> Callable[[str, Any], float]:
        """Return the function that draws the values of the fault that was added last with this subject and kind."""
        subject, use = key[0], f"{key[1]}/{self._count[key]}"
        return lambda field, value: self._chance.draw(value, subject, f"{use}/{field}")

    def _free_name(self, fault: AnyFault) -> str:
        """Return the name of the fault's kind with the lowest free number."""
        for number in count(self._next.get(fault.name, 1)):
            name = f"{fault.name}_{number}"
            if name not in self.known and name not in self._reserved:
                self._next[fault.name] = number + 1
                return name
        raise AssertionError("unreachable")

    def _forget(self, injected: InjectedFault) -> None:
        """Forget a fault and free its name."""
        del self.known[injected.name]
        kind, _, number = injected.name.rpartition("_")
        if kind in self._next and number.isdecimal() and len(number) < _MAX_DIGITS:
            self._next[kind] = min(self._next[kind], max(1, int(number)))

    def _schedule(self, injected: InjectedFault) -> None:
        """Schedule the next occurrence of a fault, or wait for its event."""
        injected.draw_all()
        settings, now = injected.drawn, self._env.now
        if settings.when is not None:
            self.anchors.add(injected.name, settings.when, partial(self._begin_in, injected, settings.when.after))
            return
        between = settings.mean_time_between
        delay = injected.times.expovariate(1.0 / between) if between else max(0.0, (settings.at or 0.0) - now)
        self._begin_in(injected, delay)

    def _begin_in(self, injected: InjectedFault, delay: float) -> None:
        injected.alarm = self._env.alarm(delay, partial(self._begin_if_possible, injected))

    def _begin_if_possible(self, injected: InjectedFault) -> None:
        """Begin a fault that is due, or report that it was missed, for instance because its subject is gone."""
        injected.alarm = None
        flaw = next(missing(injected.fault, injected.settings, self._there()), None)
        why = flaw.message if flaw is not None else self._full(injected.fault, injected.settings)
        if not why:
            self._begin(injected)
            return
        self._publisher.publish(lambda: injected.missed(why))
        self._reschedule_or_forget(injected)

    def _full(self, fault: AnyFault, settings: Occurrence) -> str:
        """Return why no more faults of a kind can begin on a subject; empty if they can."""
        if len(self._by_subject.get(_key(fault, settings), ())) < MOST_AT_ONCE:
            return ""
        return f"{MOST_AT_ONCE} faults of type {fault.name!r} are active on {settings.subject!r}; there can be no more"

    def _begin(self, injected: InjectedFault) -> None:
        injected.since = self._env.now
        self._publisher.publish(injected.began)
        case = Case(
            injected.name,
            injected.drawn,
            self._roster,
            injected.effects,
            partial(self._concurrent, injected),
            partial(self._env.call_soon, partial(self._finish, injected)),
        )
        end = self._guarded(injected, partial(injected.fault.begin, case))
        if end is None or not injected.fault.lasts:
            self._publisher.publish(injected.ended)
            self._reschedule_or_forget(injected)
            return
        injected.end = end
        self._active[id(injected)] = injected
        self._by_subject.setdefault(_key(injected.fault, injected.settings), {})[id(injected)] = injected
        seconds = self._duration(injected)
        if seconds is not None:
            injected.timer = Timeout(self._env, seconds)
            injected.timer.callbacks = [lambda _event: self._time_out(injected)]

    def _duration(self, injected: InjectedFault) -> float | None:
        """Return for how many seconds a fault lasts from now; None for no end."""
        settings = injected.drawn
        seconds: float | None = settings.duration
        if settings.mean_duration is not None:
            seconds = injected.times.expovariate(1.0 / settings.mean_duration)
        elif settings.until is not None:
            seconds = max(0.0, settings.until - self._env.now)
        return seconds

    def _time_out(self, injected: InjectedFault) -> None:
        injected.timer = None
        self._end(injected)
        self._reschedule_or_forget(injected)

    def _finish(self, injected: InjectedFault) -> None:
        """End a fault before its time, unless it is over already."""
        if injected.end is None:
            return
        if injected.timer is not None:
            self._env.abandon(injected.timer)
        self._time_out(injected)

    def _reschedule_or_forget(self, injected: InjectedFault) -> None:
        """Schedule a recurring fault again; forget any other."""
        if injected.settings.mean_time_between is None:
            self._forget(injected)
        else:
            self._schedule(injected)

    def _clear(self, injected: InjectedFault) -> None:
        """Forget a fault, and unschedule or end it."""
        self._forget(injected)
        self.anchors.remove(injected.name)
        if injected.alarm is not None:
            self._env.cancel(injected.alarm)
        if injected.timer is not None:
            self._env.abandon(injected.timer)
        if injected.end is not None:
            self._end(injected)

    def _end(self, injected: InjectedFault) -> None:
        del self._active[id(injected)]
        key = _key(injected.fault, injected.settings)
        del self._by_subject[key][id(injected)]
        if not self._by_subject[key]:
            del self._by_subject[key]
        end, injected.end = injected.end, None
        if end is not None:
            self._guarded(injected, end)
        self._publisher.publish(injected.ended)

    def _guarded(self, injected: InjectedFault, call: Callable[[], R]) -> R | None:
        """Call a fault's function and return its result; report an error and return None if it raises one."""
        try:
            return call()
        except BUGS as bug:
            self._errors.handle(f"fault {injected.fault.name}", bug)
            return None

    def _concurrent(self, injected: InjectedFault) -> Sequence[Any]:
        """Return the settings of the other active faults of the same kind and subject."""
        others = self._by_subject.get(_key(injected.fault, injected.settings), {}).values()
        return [other.drawn for other in others if other is not injected]

    def _there(self) -> There:
        """Return the subjects that faults may affect now."""
        roster = self._roster
        return There(
            robots=_ByRobot(roster.robots, lambda robot: robot.components),
            lanes=roster.admission.graph.lanes.numbers,
            doors=self._fixtures("door"),
            docks=self._fixtures("dock"),
            lifts=self._fixtures("lift"),
            items=roster.items,
            cells=_ByRobot(roster.robots, _cells),
        )

    def _fixtures(self, kind: str) -> list[str]:
        return [fixture.name for fixture in self._roster.fixtures.values() if fixture.kind == kind]


def _key(fault: AnyFault, settings: Occurrence) -> tuple[str, str]:
    """Return the subject of a fault and the name of its kind."""
    return settings.subject, fault.name


class _ByRobot(Mapping[str, V_co]):
    """A property of robots by name, in order of names, evaluated on access."""

    def __init__(self, robots: Mapping[str, Robot], what: Callable[[Robot], V_co]) -> None:
        self._robots = robots
        self._what = what

    def __getitem__(self, name: str) -> V_co:
        return self._what(self._robots[name])

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._robots))

    def __len__(self) -> int:
        return len(self._robots)


def _cells(robot: Robot) -> int | None:
    """Return the number of cells of a robot's battery; None without one."""
    battery = robot.components.get("battery")
    return battery.settings.cells if isinstance(battery, Battery) else None

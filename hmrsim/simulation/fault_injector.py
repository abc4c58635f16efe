"""The schedule of faults: those of a world file and those that are injected, and how they end.

Faults begin at a time, or some time after an event. They begin only if time goes on that far for other reasons; time
does go on until they end. Random times and effects
depend on the seed, the subject and the kind of fault alone, so that other parts of the world do not change them.
"""

from __future__ import annotations

from collections import Counter
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
    """The mark of a robot that a bug has hit, without further effect.

    Attributes:
        robot: The robot's name.
        error: The source and the exception.
    """

    robot: str
    error: str


MOST_AT_ONCE: Final = 100
"""Faults of a kind that are active on one subject: what each of them does depends on all others."""

_MAX_DIGITS: Final = 10
"""Digits of a number that is given to a fault in its name are fewer."""

_INTERNAL: Final = FaultType(name="internal_error", settings=InternalFault, begin=lambda _case: lambda: None)


@dataclass(eq=False)
class InjectedFault:
    """One fault that is scheduled, active, or over.

    Attributes:
        settings: The settings as requested, with distributions.
        drawn: The same for the present occurrence, with numbers.
        times: Random numbers for its times.
        what: Random numbers for its effects.
        draw: Returns the value of a field for the next occurrence.
        since: When it began the last time, in simulated seconds.
        end: Ends it; None while it is not active.
        alarm: Begins it; None if it is not scheduled.
        over: Ends it at its time; None if it has none.
    """

    name: str
    fault: AnyFault
    settings: Any
    drawn: Any
    times: random.Random
    what: random.Random
    draw: Callable[[str, Any], float]
    since: float = 0.0
    end: Callable[[], None] | None = None
    alarm: Alarm | None = None
    over: Timeout | None = None

    def draw_all(self) -> None:
        """Give each field that is left to chance its value for the next occurrence."""
        random = {
            field: self.draw(field, value)
            for field, value in sorted(self.settings.__dict__.items())
            if isinstance(value, Distribution)
        }
        if random:
            self.drawn = self.settings.model_copy(update=random)

    def began(self) -> FaultBegan:
        """Return the event that says that it begins."""
        return FaultBegan(self.fault.name, self.name, self._said())

    def ended(self) -> FaultEnded:
        """Return the event that says that it is over."""
        return FaultEnded(self.fault.name, self.name, self._said())

    def missed(self, why: str) -> FaultMissed:
        """Return the event that says why it does not begin."""
        return FaultMissed(self.fault.name, self.name, self._said(), why)

    def _said(self) -> dict[str, Any]:
        settings: Occurrence = self.drawn
        return settings.model_dump(mode="json", exclude_none=True, exclude={"name"})


class FaultInjector:
    """All faults of a simulation.

    Args:
        errors: Handles what faults raise because of a bug.
        listen: Called with `anchors` when they want other topics than before.

    Attributes:
        known: Those that are active or scheduled, by name.
        anchors: Counts the events after which some of them begin.
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
        self._count: Counter[tuple[str, str]] = Counter()
        self._reserved: set[str] = set()
        self._next: dict[str, int] = {}
        self._active: dict[int, InjectedFault] = {}
        # The same by subject and kind: a client may inject thousands on one robot.
        self._by_subject: dict[tuple[str, str], dict[int, InjectedFault]] = {}

    def begin(self, world: World, seed: int) -> None:
        """Schedule the faults of a world, from now on; none may be active or scheduled."""
        self._seed = seed
        self._count.clear()
        self._next.clear()
        now = self._env.now
        stated = [
            (faults()[fault.type], faults()[fault.type].settings.model_validate(fault.model_extra or {}))
            for fault in world.faults
        ]
        self._reserved = {settings.name for _, settings in stated if settings.name}
        for kind, settings in stated:
            if settings.at is None or latest(settings.at) >= now:
                self._schedule(self._add(kind, settings))

    def end(self) -> None:
        """Clear all faults, active or scheduled."""
        for injected in [*self.known.values()]:
            self._clear(injected)

    def end_all_on(self, name: str) -> None:
        """End the faults of a robot that is about to be removed; they may begin again on another of its name."""
        for injected in [each for each in self._active.values() if each.settings.subject == name]:
            if injected.over is not None:
                self._env.abandon(injected.over)
                injected.over = None
            self._end(injected)
            self._after(injected)

    def active_on(self, name: str) -> list[str]:
        """Return the kinds of fault that are active on a robot or a door."""
        return sorted({injected.fault.name for injected in self._active.values() if injected.settings.subject == name})

    def inject(self, fault: AnyFault, settings: Occurrence) -> str | list[Finding]:
        """Inject a fault at its time or after its event, or now if it has neither.

        Returns:
            Its name, or why it is impossible.
        """
        found = [*flaws(fault, settings, self._there(), now=self._env.now, names=self.known)]
        at_once = settings.at is None and settings.mean_time_between is None and settings.when is None
        if at_once and (full := self._full(fault, settings)):
            found.append(Finding((), full))
        if found:
            return found
        injected = self._add(fault, settings)
        if at_once:
            injected.draw_all()
            self._begin(injected)
        else:
            self._schedule(injected)
        return injected.name

    def mark(self, robot: str, error: str) -> None:
        """Mark a robot that a bug has hit, until that is cleared; once for each error."""
        mark = InternalFault(robot=robot, error=error)
        if robot in self._roster.robots and all(injected.settings != mark for injected in self._active.values()):
            self._begin(self._add(_INTERNAL, mark))

    def clear(self, name: str) -> None:
        """Clear the fault of this name, active or scheduled."""
        self._clear(self.known[name])

    def _add(self, fault: AnyFault, settings: Occurrence) -> InjectedFault:
        whose = _whose(fault, settings)
        self._count[whose] += 1
        seed = "/".join((str(self._seed), *whose, str(self._count[whose])))
        name = settings.name or self._free_name(fault)
        times, what = self._chance.stream(seed), self._chance.stream(f"{seed}/what")
        injected = InjectedFault(name, fault, settings, settings, times, what, self._drawer(whose))
        self.known[name] = injected
        return injected

    def _drawer(self, whose: tuple[str, str]) -> Callable[[str, Any], float]:
        subject, use = whose[0], f"{whose[1]}/{self._count[whose]}"
        return lambda field, value: self._chance.draw(value, subject, f"{use}/{field}")

    def _free_name(self, fault: AnyFault) -> str:
        """Return the name with the least number that no fault has."""
        for number in count(self._next.get(fault.name, 1)):
            name = f"{fault.name}_{number}"
            if name not in self.known and name not in self._reserved:
                self._next[fault.name] = number + 1
                return name
        raise AssertionError

    def _forget(self, injected: InjectedFault) -> None:
        """Forget a fault; its name is free again."""
        del self.known[injected.name]
        kind, _, number = injected.name.rpartition("_")
        if kind in self._next and number.isdecimal() and len(number) < _MAX_DIGITS:
            self._next[kind] = min(self._next[kind], max(1, int(number)))

    def _schedule(self, injected: InjectedFault) -> None:
        injected.draw_all()
        settings, now = injected.drawn, self._env.now
        if settings.when is not None:
            self.anchors.add(injected.name, settings.when, partial(self._begin_in, injected, settings.when.after))
            return
        between = settings.mean_time_between
        delay = injected.times.expovariate(1.0 / between) if between else max(0.0, (settings.at or 0.0) - now)
        self._begin_in(injected, delay)

    def _begin_in(self, injected: InjectedFault, delay: float) -> None:
        injected.alarm = self._env.alarm(delay, partial(self._ring, injected))

    def _ring(self, injected: InjectedFault) -> None:
        """Begin a fault that is due, if its subject exists."""
        injected.alarm = None
        flaw = next(missing(injected.fault, injected.settings, self._there()), None)
        why = flaw.message if flaw is not None else self._full(injected.fault, injected.settings)
        if not why:
            self._begin(injected)
            return
        self._publisher.publish(lambda: injected.missed(why))
        self._after(injected)

    def _full(self, fault: AnyFault, settings: Occurrence) -> str:
        """Return why no other fault of a kind can begin on a subject, or ""."""
        if len(self._by_subject.get(_whose(fault, settings), ())) < MOST_AT_ONCE:
            return ""
        return f"{MOST_AT_ONCE} faults of type {fault.name!r} are active on {settings.subject!r}; there can be no more"

    def _begin(self, injected: InjectedFault) -> None:
        injected.since = self._env.now
        self._publisher.publish(injected.began)
        case = Case(
            injected.name,
            injected.drawn,
            self._roster,
            injected.what,
            partial(self._concurrent, injected),
            partial(self._env.call_soon, partial(self._finish, injected)),
        )
        end = self._guarded(injected, partial(injected.fault.begin, case))
        if end is None or not injected.fault.lasts:
            self._publisher.publish(injected.ended)
            self._after(injected)
            return
        injected.end = end
        self._active[id(injected)] = injected
        self._by_subject.setdefault(_whose(injected.fault, injected.settings), {})[id(injected)] = injected
        seconds = self._seconds(injected)
        if seconds is not None:
            injected.over = Timeout(self._env, seconds)
            injected.over.callbacks = [lambda _event: self._time_out(injected)]

    def _seconds(self, injected: InjectedFault) -> float | None:
        """Return how long a fault lasts from now on; None for ever."""
        settings = injected.drawn
        seconds: float | None = settings.duration
        if settings.mean_duration is not None:
            seconds = injected.times.expovariate(1.0 / settings.mean_duration)
        elif settings.until is not None:
            seconds = max(0.0, settings.until - self._env.now)
        return seconds

    def _time_out(self, injected: InjectedFault) -> None:
        injected.over = None
        self._end(injected)
        self._after(injected)

    def _finish(self, injected: InjectedFault) -> None:
        """End a fault before its time; one that is over by now is passed over."""
        if injected.end is None:
            return
        if injected.over is not None:
            self._env.abandon(injected.over)
        self._time_out(injected)

    def _after(self, injected: InjectedFault) -> None:
        """Schedule a recurring fault again, or forget one that does not recur."""
        if injected.settings.mean_time_between is None:
            self._forget(injected)
        else:
            self._schedule(injected)

    def _clear(self, injected: InjectedFault) -> None:
        self._forget(injected)
        self.anchors.remove(injected.name)
        if injected.alarm is not None:
            self._env.cancel(injected.alarm)
        if injected.over is not None:
            self._env.abandon(injected.over)
        if injected.end is not None:
            self._end(injected)

    def _end(self, injected: InjectedFault) -> None:
        del self._active[id(injected)]
        whose = _whose(injected.fault, injected.settings)
        del self._by_subject[whose][id(injected)]
        if not self._by_subject[whose]:
            del self._by_subject[whose]
        end, injected.end = injected.end, None
        if end is not None:
            self._guarded(injected, end)
        self._publisher.publish(injected.ended)

    def _guarded(self, injected: InjectedFault, call: Callable[[], R]) -> R | None:
        """Return what a fault's function returns; None if it has a bug."""
        try:
            return call()
        except BUGS as bug:
            self._errors.handle(f"fault {injected.fault.name}", bug)
            return None

    def _concurrent(self, injected: InjectedFault) -> Sequence[Any]:
        """Return the settings of the other faults of a kind that are active on the same subject."""
        others = self._by_subject.get(_whose(injected.fault, injected.settings), {}).values()
        return [other.drawn for other in others if other is not injected]

    def _there(self) -> There:
        """Return what a fault may affect now."""
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


def _whose(fault: AnyFault, settings: Occurrence) -> tuple[str, str]:
    """Return what a fault affects, and the name of its kind."""
    return settings.subject, fault.name


class _ByRobot(Mapping[str, V_co]):
    """Something that all robots have, in order of their names; found out for those that are asked for."""

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
    battery = robot.components.get("battery")
    return battery.settings.cells if isinstance(battery, Battery) else None

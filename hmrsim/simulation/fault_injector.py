"""When what goes wrong: the faults of a world file, those that somebody injects, and how they end.

Faults begin only if time goes on that far for other reasons; that they end may be waited for. What is left to chance
depends on the seed, the subject and the kind of fault alone, so that nothing far away changes it.
"""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any

from simpy import Timeout

from hmrsim.components.battery import Battery
from hmrsim.events.faults import FaultBegan, FaultEnded, FaultMissed
from hmrsim.faults import Case
from hmrsim.faults import registry as faults
from hmrsim.world_checks.faults import There, flaws

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from hmrsim.diagnostics import Finding
    from hmrsim.engine.environment import Alarm, Environment
    from hmrsim.engine.subscriptions import Happenings
    from hmrsim.faults import AnyFault, Occurrence
    from hmrsim.simulation.entities import Roster
    from hmrsim.world.model import World


@dataclass(eq=False)
class Mishap:
    """One fault: it is to come, goes on, or is over.

    Attributes:
        name: Its name.
        fault: What goes wrong.
        settings: To whom, and when.
        when: Chance, as far as it says when.
        what: Chance, as far as it says what comes of it.
        since: When it began the last time, in simulated seconds.
        end: Ends it; None while it does not go on.
        alarm: Lets it begin; None when that is not to come.
        over: When it ends by itself; None if it does not.
    """

    name: str
    fault: AnyFault
    settings: Any
    when: random.Random
    what: random.Random
    since: float = 0.0
    end: Callable[[], None] | None = None
    alarm: Alarm | None = None
    over: Timeout | None = None

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
        settings: Occurrence = self.settings
        return settings.model_dump(mode="json", exclude_none=True, exclude={"name"})


class Mishaps:
    """All faults of a simulation.

    Args:
        env: Its clock and events.
        roster: To whom they happen.
        happened: Tells of them.

    Attributes:
        known: Those that go on or are to come, by name.
    """

    def __init__(self, env: Environment, roster: Roster, happened: Happenings) -> None:
        self.known: dict[str, Mishap] = {}
        self._env = env
        self._roster = roster
        self._happened = happened
        self._seed = 0
        self._count: Counter[tuple[str, str]] = Counter()
        roster.leaving = self._put_right_at
        self._reserved: set[str] = set()
        self._active: list[Mishap] = []

    # --- all of them ----------------------------------------------------------------------------------------------

    def begin(self, world: World, seed: int) -> None:
        """Let happen what a world says, from now on; nothing may go on, or be to come."""
        self._seed = seed
        self._count.clear()
        said = [
            (faults()[fault.type], faults()[fault.type].settings.model_validate(fault.model_extra or {}))
            for fault in world.faults
        ]
        self._reserved = {settings.name for _, settings in said if settings.name}
        for kind, settings in said:
            if settings.at is None or settings.at >= self._env.now:
                self._schedule(self._add(kind, settings))

    def end(self) -> None:
        """Put right everything, and let nothing more go wrong."""
        for mishap in [*self.known.values()]:
            self._drop(mishap)

    def _put_right_at(self, name: str) -> None:
        """Put right what goes on at a robot that is about to be taken out; it may happen to another of its name."""
        for mishap in [each for each in self._active if each.settings.subject == name]:
            if mishap.over is not None:
                self._env.abandon(mishap.over)
                mishap.over = None
            self._put_right(mishap)
            self._after(mishap)

    def hitting(self, name: str) -> list[str]:
        """Return what kinds of fault go on at a robot or a door."""
        return sorted({mishap.fault.name for mishap in self._active if mishap.settings.subject == name})

    # --- one of them ----------------------------------------------------------------------------------------------

    def inject(self, fault: AnyFault, settings: Occurrence) -> str | list[Finding]:
        """Let something go wrong at its time, or now if it has none; return its name, or why it can't be."""
        found = [*flaws(fault, settings, self._there(), now=self._env.now, names=self.known)]
        if found:
            return found
        mishap = self._add(fault, settings)
        if settings.at is None and settings.mean_time_between is None:
            self._begin(mishap)
        else:
            self._schedule(mishap)
        return mishap.name

    def clear(self, name: str) -> None:
        """Put right what goes wrong by this name; what is to come is called off."""
        self._drop(self.known[name])

    def _add(self, fault: AnyFault, settings: Occurrence) -> Mishap:
        whose = (settings.subject, fault.name)
        self._count[whose] += 1
        chance = "/".join((str(self._seed), *whose, str(self._count[whose])))
        made = (f"{fault.name}_{number}" for number in count(1))
        name = settings.name or next(name for name in made if name not in {*self.known, *self._reserved})
        # Seeds no key, but a game of chance that can be played again.
        mishap = Mishap(name, fault, settings, random.Random(chance), random.Random(f"{chance}/what"))
        self.known[name] = mishap
        return mishap

    def _schedule(self, mishap: Mishap) -> None:
        settings, now = mishap.settings, self._env.now
        between = settings.mean_time_between
        delay = mishap.when.expovariate(1.0 / between) if between else max(0.0, (settings.at or 0.0) - now)
        mishap.alarm = self._env.alarm(delay, partial(self._ring, mishap))

    def _ring(self, mishap: Mishap) -> None:
        """Let happen what is due, if to whom it is to happen is there."""
        mishap.alarm = None
        missing = next(iter(flaws(mishap.fault, mishap.settings, self._there())), None)
        if missing is None:
            self._begin(mishap)
            return
        self._happened.publish(lambda: mishap.missed(missing.message))
        self._after(mishap)

    def _begin(self, mishap: Mishap) -> None:
        mishap.since = self._env.now
        self._happened.publish(mishap.began)
        case = Case(mishap.name, mishap.settings, self._roster, mishap.what, partial(self._fellows, mishap))
        end = mishap.fault.begin(case)
        if not mishap.fault.lasts:
            self._happened.publish(mishap.ended)
            self._after(mishap)
            return
        mishap.end = end
        self._active.append(mishap)
        seconds = self._seconds(mishap)
        if seconds is not None:
            mishap.over = Timeout(self._env, seconds)
            mishap.over.callbacks = [lambda _event: self._is_over(mishap)]

    def _seconds(self, mishap: Mishap) -> float | None:
        """Return how long it lasts from now on; None for ever."""
        settings = mishap.settings
        seconds: float | None = settings.duration
        if settings.mean_duration is not None:
            seconds = mishap.when.expovariate(1.0 / settings.mean_duration)
        elif settings.until is not None:
            seconds = max(0.0, settings.until - self._env.now)
        return seconds

    def _is_over(self, mishap: Mishap) -> None:
        mishap.over = None
        self._put_right(mishap)
        self._after(mishap)

    def _after(self, mishap: Mishap) -> None:
        """Have a fault happen again some time, or forget it."""
        if mishap.settings.mean_time_between is None:
            del self.known[mishap.name]
        else:
            self._schedule(mishap)

    def _drop(self, mishap: Mishap) -> None:
        del self.known[mishap.name]
        if mishap.alarm is not None:
            self._env.put_off(mishap.alarm)
        if mishap.over is not None:
            self._env.abandon(mishap.over)
        if mishap.end is not None:
            self._put_right(mishap)

    def _put_right(self, mishap: Mishap) -> None:
        self._active.remove(mishap)
        end, mishap.end = mishap.end, None
        if end is not None:
            end()
        self._happened.publish(mishap.ended)

    def _fellows(self, mishap: Mishap) -> Sequence[Any]:
        """Return the settings of the other faults of a kind that go on at the same subject."""
        return [
            other.settings
            for other in self._active
            if other is not mishap and (other.fault, other.settings.subject) == (mishap.fault, mishap.settings.subject)
        ]

    def _there(self) -> There:
        """Return who and what a fault may happen to now."""
        roster, batteries = self._roster, {}
        for name, robot in sorted(roster.robots.items()):
            if isinstance(battery := robot.components.get("battery"), Battery):
                batteries[name] = battery.settings.cells
        doors = [fixture.name for fixture in roster.fixtures.values() if fixture.kind == "door"]
        return There(
            robots={name: robot.components for name, robot in sorted(roster.robots.items())},
            lanes=roster.passage.graph.lanes.numbers,
            doors=doors,
            cells=batteries,
        )

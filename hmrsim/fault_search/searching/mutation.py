"""Changing a schedule by a little: something more, something else, another moment, another duration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import random
    from collections.abc import Callable, Sequence

    from hmrsim.fault_search.schedules.thing import Schedule, Thing
    from hmrsim.fault_search.searching.guide import Kept
    from hmrsim.fault_search.space.menu import Menu

_TRIES: Final = 8
_FRESH: Final = 0.8
"""How often something begins at a moment that came about only by what went wrong before."""
_FACTORS: Final = (0.25, 0.5, 2.0, 4.0)


class Mutator:
    """Changes schedules.

    Args:
        menu: What can happen.
        at_most: How many things a schedule has at most.
        durations: Seconds that things last.
    """

    def __init__(self, menu: Menu, at_most: int, durations: Sequence[float]) -> None:
        self._menu, self._at_most, self._durations = menu, at_most, durations
        self._ways: tuple[tuple[float, Callable[[Kept, Kept, random.Random], Schedule | None]], ...] = (
            (0.65, self._more),
            (0.1, self._both),
            (0.1, self._instead),
            (0.08, self._elsewhen),
            (0.07, self._longer),
        )

    def changed(self, kept: Kept, other: Kept, rng: random.Random) -> Schedule | None:
        """Return a schedule that differs from one by a little; *other* is one more that was found worth keeping."""
        for _ in range(_TRIES):
            way = rng.choices([way for _, way in self._ways], [weight for weight, _ in self._ways])[0]
            schedule = way(kept, other, rng)
            if schedule and schedule != kept.schedule and len(schedule) <= self._at_most:
                return schedule
        return None

    def fresh(self, kept: Kept, rng: random.Random) -> Thing | None:
        """Return something that begins at a moment of a run, rather at one that only this run had."""
        moments = kept.fresh if kept.fresh and rng.random() < _FRESH else kept.moments
        return self._menu.any(moments, rng)

    def _more(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        thing = self.fresh(kept, rng)
        return without_twins((*kept.schedule, thing)) if thing else None

    def _both(self, kept: Kept, other: Kept, _rng: random.Random) -> Schedule:
        return without_twins((*kept.schedule, *other.schedule))

    def _instead(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        thing = self.fresh(kept, rng)
        if thing is None or not kept.schedule:
            return None
        number = rng.randrange(len(kept.schedule))
        return without_twins((*kept.schedule[:number], thing, *kept.schedule[number + 1 :]))

    def _elsewhen(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        anchored = [i for i, thing in enumerate(kept.schedule) if thing.anchor]
        if not anchored or not kept.moments:
            return None
        number = rng.choice(anchored)
        thing = kept.schedule[number]
        robot = thing.said.get("robot")
        moments = [moment for moment in kept.moments if robot in (None, moment.robot)]
        if not moments:
            return None
        moved = thing.replaced(when=rng.choice(moments).anchor())
        return without_twins((*kept.schedule[:number], moved, *kept.schedule[number + 1 :]))

    def _longer(self, kept: Kept, _other: Kept, rng: random.Random) -> Schedule | None:
        lasting = [i for i, thing in enumerate(kept.schedule) if "duration" in thing.said]
        if not lasting:
            return None
        number = rng.choice(lasting)
        thing = kept.schedule[number]
        most = max(self._durations) * 2
        seconds = min(most, round(thing.said["duration"] * rng.choice(_FACTORS), 3))
        return (*kept.schedule[:number], thing.replaced(duration=seconds), *kept.schedule[number + 1 :])


def without_twins(schedule: Schedule) -> Schedule:
    """Return a schedule in which nothing is there twice, and of each robot or demand one thing is changed at most.

    Two changes of a robot, such as a small battery and a low speed, may be too much where each alone can be borne.
    """
    found: dict[str, Thing] = {}
    parts: dict[tuple[str, ...], None] = {}
    for thing in schedule:
        changed = [tuple(path.lstrip("~").split(".")[:2]) for path in thing.said.get("change", ())]
        if not any(part in parts for part in changed):
            found.setdefault(thing.key, thing)
            parts |= dict.fromkeys(changed)
    return tuple(found.values())

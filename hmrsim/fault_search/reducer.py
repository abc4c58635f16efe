"""Reduction of a failing case to the smallest one that fails for the same reason.

It leaves out injections, then parts of the world, and then makes values simpler.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Any, Final, TypeVar

from hmrsim.components.battery import BatterySettings
from hmrsim.fault_search.run import NOT_RUN, Outcome
from hmrsim.fault_search.schedule import CHANGE
from hmrsim.fault_search.summary import Reduced

if TYPE_CHECKING:
    from hmrsim.fault_search.evaluator import Evaluator
    from hmrsim.fault_search.run import Failure
    from hmrsim.fault_search.schedule import Case, Injection
    from hmrsim.world.model import World

T = TypeVar("T")
Fails = Callable[[Sequence[Sequence[T]]], Sequence[bool]]
"""A function that returns for each candidate, a selection of the parts in order, whether it fails as the whole does."""


class Reducer:
    """Reduces failing cases to minimal ones.

    Args:
        definition: The world of the check, as in a native file.
        nominal: The outcome of the run without faults.
        over: Called before each batch of runs; returns whether time is up, which ends the reduction.
        until: The last moment for runs, by the monotonic clock.
        names: The names in the properties; their objects stay, since the properties need them.
        world: The world of the check, to reduce changes of it; None to leave changes as they are.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        definition: Mapping[str, Any],
        nominal: Outcome,
        over: Callable[[], bool] = lambda: False,
        until: float = math.inf,
        names: Collection[str] = (),
        world: World | None = None,
    ) -> None:
        self._evaluator, self._definition, self._nominal, self._over = evaluator, definition, nominal, over
        self._until, self._names, self._world = until, names, world

    def reduce(self, case: Case, failure: Failure) -> Reduced:
        """Return the smallest case that fails for the same reason as a given one."""
        begun = self._evaluator.runs
        case = self._fewer_injections(case, failure)
        case = self._smaller_world(case, failure)
        # Simpler values may need fewer injections, and those may have even simpler values.
        while True:
            before = case
            case = self._simpler_values(case, failure)
            case = self._fewer_injections(case, failure)
            if case.key == before.key:
                break
        schedule = case.schedule
        each_left_out = [case.with_schedule((*schedule[:i], *schedule[i + 1 :])) for i in range(len(schedule))]
        known = self._evaluator.outcomes(each_left_out, self._until)
        without = (*known, *[Outcome(NOT_RUN)] * (len(schedule) - len(known)))
        return Reduced(case, without, self._evaluator.runs - begun)

    def _fail(self, cases: Sequence[Case], failure: Failure) -> list[bool]:
        outcomes = self._evaluator.outcomes(cases, self._until)
        return [failure in outcome.failures for outcome in outcomes] + [False] * (len(cases) - len(outcomes))

    def _fewer_injections(self, case: Case, failure: Failure) -> Case:
        def fails(candidates: Sequence[Sequence[Any]]) -> list[bool]:
            if self._over():
                return [False] * len(candidates)
            return self._fail([case.with_schedule(tuple(each)) for each in candidates], failure)

        return case.with_schedule(tuple(needed(case.schedule, fails)))

    def _smaller_world(self, case: Case, failure: Failure) -> Case:
        if failure in self._nominal.failures:
            # In a world without its mission, a controller fails at once, even after it was fixed.
            return case
        whole = next(iter(self._evaluator.outcomes([case], self._until)), None)
        if whole is None:
            return case
        for keys in ROUNDS:
            definition = self._definition if case.definition is None else case.definition
            parts = parts_of(definition, keys)
            named = [part for part in parts if is_named(definition, part, self._names)]
            free = [part for part in parts if part not in named]

            def fails(
                candidates: Sequence[Sequence[Part]],
                case: Case = case,
                definition: Mapping[str, Any] = definition,
                keys: Sequence[str] = keys,
                named: Sequence[Part] = named,
            ) -> list[bool]:
                if self._over():
                    return [False] * len(candidates)
                worlds = [restricted(definition, keys, [*named, *kept]) for kept in candidates]
                return self._fail_in(worlds, case, failure, whole)

            kept = needed(free, fails)
            if len(kept) < len(free):
                case = replace(case, definition=restricted(definition, keys, [*named, *kept]))
        definition = self._definition if case.definition is None else case.definition
        tidy = tidied(definition, self._names)
        return replace(case, definition=tidy) if self._fail_in([tidy], case, failure, whole)[0] else case

    def _fail_in(self, worlds: Sequence[Mapping[str, Any]], case: Case, failure: Failure, whole: Outcome) -> list[bool]:
        """Return for each world whether a case fails there because of its schedule.

        Without the schedule, the run has to end as in the whole world: a world in which the mission is impossible says
        nothing about the schedule. With the schedule, the run has to end as in the whole world, and goals may only be
        aborted or rejected for the same reasons: otherwise it fails because of a missing object, such as a dock.
        """
        cases = [replace(case, definition=world) for world in worlds]
        failed = [
            failure in outcome.failures and outcome.ending == whole.ending and {*outcome.aborts} <= {*whole.aborts}
            for outcome in self._evaluator.outcomes(cases, self._until)
        ]
        failed += [False] * (len(cases) - len(failed))
        if not case.schedule:
            return failed
        failing = [each.with_schedule(()) for each, fails in zip(cases, failed, strict=True) if fails]
        sound = iter([self._is_sound(outcome) for outcome in self._evaluator.outcomes(failing, self._until)])
        return [fails and next(sound, False) for fails in failed]

    def _is_sound(self, outcome: Outcome) -> bool:
        """Return whether a run without faults ends as in the whole world, without further failures."""
        return {*outcome.failures} <= {*self._nominal.failures} and outcome.ending == self._nominal.ending

    def _simpler_values(self, case: Case, failure: Failure) -> Case:
        number = 0
        while number < len(case.schedule) and not self._over():
            injections = [*simpler(case.schedule[number], self._world)]
            before, after = case.schedule[:number], case.schedule[number + 1 :]
            cases = [case.with_schedule((*before, injection, *after)) for injection in injections]
            failing = next((i for i, failed in enumerate(self._fail(cases, failure)) if failed), None)
            if failing is None:
                number += 1
            else:
                case = cases[failing]
        return case


def needed(parts: Sequence[T], fails: Fails[T]) -> list[T]:
    """Return a 1-minimal selection of parts that fail together: none of them can be left out.

    All parts have to fail together. When time is over, *fails* may return False for all candidates.
    """
    kept = [*parts]
    if kept and fails([[]])[0]:
        return []
    pieces = 2
    while len(kept) > 1:
        pieces = min(pieces, len(kept))
        chunks = _chunks(kept, pieces)
        candidates = [] if pieces == 2 else [*chunks]  # noqa: PLR2004 - of two, each is the other's complement
        complements = [[part for chunk in chunks[:i] + chunks[i + 1 :] for part in chunk] for i in range(pieces)]
        verdicts = fails([*candidates, *complements])
        failing = next((i for i, failed in enumerate(verdicts) if failed), None)
        if failing is None:
            if pieces >= len(kept):
                break
            pieces *= 2
        elif failing < len(candidates):
            kept, pieces = [*candidates[failing]], 2
        else:
            kept, pieces = complements[failing - len(candidates)], max(2, pieces - 1)
    return kept


def _chunks(parts: Sequence[T], count: int) -> list[list[T]]:
    """Return parts in a number of pieces of about the same length, in order."""
    ends = [round(len(parts) * i / count) for i in range(count + 1)]
    return [[*parts[start:end]] for start, end in pairwise(ends)]


_SECONDS: Final = (1.0, 5.0, 10.0, 30.0, 60.0)
"""The durations to try, which are easy to read."""
_FACTORS: Final = (0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 1.2, 1.5, 2.0, 5.0, 10.0, 100.0)
"""The factors to try for a change of a robot's own value, the smallest change first, down and up."""
_ROBOTS: Final = re.compile(r"robots\.(\"[^\"]+\"|[^.]+)\.(base\.speed|components\.battery\.(capacity|initial_charge))")
_EARLIER: Final = 10
"""The number of the last event of its kind that is tried as an earlier anchor."""


def simpler(injection: Injection, world: World | None = None) -> Iterator[Injection]:
    """Yield the injection with one value made simpler, the simplest first; with *world*, also smaller changes of it."""
    if world is not None and injection.family == CHANGE:
        yield from _smaller_changes(injection, world)
    when = dict(injection.anchor)
    for spec in _anchors(when):
        yield injection.replaced(when=spec)
    if injection.spec.get("count", 1) > 1:
        yield injection.replaced(count=1)
    for name in ("duration", "restart_after"):
        seconds = injection.spec.get(name)
        if isinstance(seconds, (int, float)):
            yield from (injection.replaced(**{name: each}) for each in _SECONDS if each < seconds)


def _smaller_changes(injection: Injection, world: World) -> Iterator[Injection]:
    """Yield smaller changes of a robot's own values, the smallest first."""
    changed = injection.spec[CHANGE]
    own = {path: value for path in changed if (value := _own(path, world)) is not None}
    if not own or not all(isinstance(changed[path], (int, float)) for path in own):
        return
    path = next(iter(own))
    factor = changed[path] / own[path]
    for smaller in (each for each in _FACTORS if (1.0 < each < factor) or (factor < each < 1.0)):
        values = {key: float(f"{own[key] * smaller:.4g}") if key in own else value for key, value in changed.items()}
        yield injection.replaced(change=values)


def _own(path: str, world: World) -> float | None:
    """Return a robot's own value at a path, its speed or a value of its battery; None for other paths."""
    match = _ROBOTS.fullmatch(path)
    robot = world.robots.get(match[1].strip('"')) if match else None
    if match is None or robot is None:
        return None
    kind = world.robot_type(robot)
    if match[2] == "base.speed":
        return world.speed(kind.base)
    battery = BatterySettings.model_validate(kind.components.get("battery") or {})
    return battery.capacity if match[3] == "capacity" else battery.initial_charge


def _anchors(when: dict[str, Any]) -> Iterator[dict[str, Any]]:
    after = when.get("after", 0.0)
    if after:
        yield {key: value for key, value in when.items() if key != "after"}
        for digits in (0, 1):
            rounded = round(after, digits)
            if rounded not in (0.0, after):
                yield {**when, "after": rounded}
    nth = when.get("nth", 1)
    if nth > 1:
        yield {key: value for key, value in when.items() if key != "nth"}
    # At an earlier event, the injection may be enough alone.
    yield from ({**when, "nth": earlier} for earlier in range(2, min(nth, _EARLIER)))


Part = tuple[str, Any]
"""A key of a world, and the name of an entry of its mapping, or the index of one in its list."""
_NAMED: Final = ("robots", "items", "lifts", "doors", "docks", "places")
_LISTED: Final = ("demand", "faults", "walls", "lanes")
ROUNDS: Final = (("robots",), ("demand", "items", "faults"), ("lifts", "doors", "docks", "places", "walls"), ("lanes",))
"""The keys whose entries are left out in one round, in this order."""
_NAMED_ROBOTS: Final = 4
"""The maximum number of robots that are named in the text about what was left out."""


def parts_of(definition: Mapping[str, Any], keys: Iterable[str]) -> list[Part]:
    """Return the parts of a world under some keys, in order."""
    found: list[Part] = []
    for key in keys:
        entries = definition.get(key) or ()
        found += [(key, name) for name in (entries if key in _NAMED else range(len(entries)))]
    return found


def left_out(definition: Mapping[str, Any], reduced: Mapping[str, Any]) -> str:
    """Return in words what a reduced world lacks, such as "2 of 3 robots (ann, bob), 1 of 20 lanes"."""
    texts = []
    for key in (*chain.from_iterable(ROUNDS), "waypoints"):
        before, after = definition.get(key) or (), reduced.get(key) or ()
        if number := len(before) - len(after):
            missing = [name for name in before if name not in after] if key == "robots" else []
            names = f" ({', '.join(missing)})" if 0 < len(missing) <= _NAMED_ROBOTS else ""
            texts.append(f"{number} of {len(before)} {'entries of demand' if key == 'demand' else key}{names}")
    return ", ".join(texts)


def restricted(definition: Mapping[str, Any], keys: Iterable[str], kept: Iterable[Part]) -> dict[str, Any]:
    """Return a world reduced to the kept entries, without waypoints that no lane reaches."""
    parts = dict.fromkeys(kept)
    world = dict(definition)
    for key in keys:
        if key in world:
            world[key] = _entries(key, world[key], parts)
            if not world[key]:
                del world[key]
    return world


def _entries(key: str, entries: Any, kept: Mapping[Part, None]) -> Any:
    if key in _LISTED:
        return [entry for i, entry in enumerate(entries) if (key, i) in kept]
    return {name: entry for name, entry in entries.items() if (key, name) in kept}


def is_named(definition: Mapping[str, Any], part: Part, names: Collection[str]) -> bool:
    """Return whether the name of a part is among *names*, or the part is a lane between two of them."""
    key, entry = part
    if key == "lanes":
        return {*_ends(definition[key][entry])} <= {*names}
    return key in _NAMED and entry in names


def tidied(definition: Mapping[str, Any], names: Collection[str] = ()) -> dict[str, Any]:
    """Return a world without isolated waypoints and unused robot types; waypoints in *names* stay."""
    touched = {end for lane in definition.get("lanes", ()) for end in _ends(lane)}
    touched |= {stop for lift in (definition.get("lifts") or {}).values() for stop in lift.get("stops", ())}
    at = {each.get("at") for key in _NAMED for each in (definition.get(key) or {}).values() if _is_named(each)}
    types = {robot.get("type") for robot in (definition.get("robots") or {}).values()}
    world = dict(definition)
    for key, wanted in (("waypoints", touched | at | {*names}), ("robot_types", types)):
        if key in world:
            world[key] = {name: entry for name, entry in world[key].items() if name in wanted}
            if not world[key]:
                del world[key]
    return world


def _is_named(entry: Any) -> bool:
    return isinstance(entry, Mapping) and isinstance(entry.get("at"), str)


def _ends(lane: Any) -> tuple[str, str]:
    return (lane["from"], lane["to"]) if isinstance(lane, Mapping) else (lane[0], lane[1])

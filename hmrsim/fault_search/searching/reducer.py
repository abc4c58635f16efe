"""The smallest case that fails for the same reason: fewer injections, then a smaller world, then simpler values."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.fault_search.results.summary import Reduced
from hmrsim.fault_search.running.single import NOT_RUN, Outcome
from hmrsim.fault_search.searching.shrinking import ROUNDS, Part, is_named, parts_of, restricted, simpler, tidied

if TYPE_CHECKING:
    from hmrsim.fault_search.running.evaluator import Evaluator
    from hmrsim.fault_search.running.single import Failure
    from hmrsim.fault_search.schedule import Case, Schedule
    from hmrsim.world.model import World


class Reducer:
    """Reduces failing cases to minimal ones.

    Args:
        evaluator: Runs cases.
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
        """Return the smallest case that fails as a case does."""
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
        left_out = _each_left_out(case)
        known = self._evaluator.outcomes(left_out, self._until)
        without = (*known, *[Outcome(NOT_RUN)] * (len(left_out) - len(known)))
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
            cases = [case.with_schedule(_with(case.schedule, number, injection)) for injection in injections]
            failing = next((i for i, failed in enumerate(self._fail(cases, failure)) if failed), None)
            if failing is None:
                number += 1
            else:
                case = cases[failing]
        return case


def _with(schedule: Schedule, number: int, injection: Any) -> Schedule:
    return (*schedule[:number], injection, *schedule[number + 1 :])


def _each_left_out(case: Case) -> list[Case]:
    schedule = case.schedule
    return [case.with_schedule((*schedule[:i], *schedule[i + 1 :])) for i in range(len(schedule))]


T = TypeVar("T")

Fails = Callable[[Sequence[Sequence[T]]], Sequence[bool]]
"""Returns for each candidate, which is a selection of the parts in order, whether it fails as the whole does."""


def needed(parts: Sequence[T], fails: Fails[T]) -> list[T]:
    """Return a 1-minimal selection of parts that fail together: none of them can be left out.

    Args:
        parts: All parts, which fail together.
        fails: Tests candidates; when time is over, it may return False for all of them.
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

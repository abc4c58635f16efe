"""Fault search: schedules a second, and runs until two faults are found that only together break a controller."""

from __future__ import annotations

import statistics
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks._pairs import PAIRS, PORTERS, WORLD
from benchmarks._report import Row
from benchmarks._spread import Spread
from hmrsim.fault_search.campaign import Campaign, Options, limited
from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.schedule import Case
from hmrsim.trials.batches import factory_of

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.search import Strategy
    from hmrsim.fault_search.summary import Summary

QUICK: dict[str, Any] = {"schedules": 32, "rounds": 1, "pairs": 1, "seeds": 1, "most": 32}

_HERE = Path(__file__).parent


def run(*, schedules: int = 600, rounds: int = 3, pairs: int = 6, seeds: int = 2, most: int = 1_500) -> list[Row]:
    """Return how many schedules a second are run, and how many runs two ways to search take.

    Args:
        schedules: Of the hospital, in a turn.
        rounds: How often.
        pairs: How many pairs of faults are looked for.
        seeds: Searches for each pair of faults and each way.
        most: Runs after which a search is given up.
    """
    make, workers = factory_of("pool", 2)
    hospital = _check({"world": "hospital", "controller": {"tree": "bt_controller.examples.hospital:mission"}})
    with Evaluator(hospital, make, workers) as evaluator:
        rates = [_rate(hospital, evaluator, schedules, seed) for seed in range(rounds)]
        taken: dict[Strategy, list[int]] = {"guided": [], "random": []}
        for first, second in PAIRS[:pairs]:
            for seed in range(seeds):
                for strategy, runs in taken.items():
                    runs.append(_runs(evaluator, first, second, seed, strategy, most))
    guided, chance = (statistics.median(runs) for runs in taken.values())
    ratio = guided / chance
    return [
        Row("the hospital, two workers", Spread.of(rates), "schedules/s", at_least=100.0),
        Row("pairs of faults, guided", Spread.of(taken["guided"]), "runs until found", ratio, ratio_at_most=0.5),
        Row("pairs of faults, at random", Spread.of(taken["random"]), "runs until found", 1.0),
    ]


def _check(said: dict[str, Any]) -> Check:
    return check_at(CheckFile.model_validate(said), _HERE)


def _rate(check: Check, evaluator: Evaluator, schedules: int, seed: int) -> float:
    check = _with(check, seed=seed, budget=_budget(schedules))
    _searched(check, evaluator, "guided", runs=32)
    began = time.monotonic()
    summary = _searched(check, evaluator, "guided", runs=schedules)
    return summary.tried.runs / (time.monotonic() - began)


def _runs(evaluator: Evaluator, first: str, second: str, seed: int, strategy: Strategy, most: int) -> int:
    """Return after how many runs a pair of faults was found; at most *most*."""
    controller = {"python": f"_pairs.py:mission(first='{first}', second='{second}', porter={seed % PORTERS})"}
    summary = _searched(
        _check({"world": WORLD, "controller": controller, "seed": seed}), evaluator, strategy, runs=most
    )
    return summary.findings[0].run if summary.findings else most


def _searched(check: Check, evaluator: Evaluator, strategy: Strategy, *, runs: int) -> Summary:
    check = _with(check, budget=_budget(runs))
    evaluator.take(check)
    nominal = evaluator.outcomes([Case()])[0]
    check = limited(check, nominal)
    evaluator.take(check)
    return Campaign(check, evaluator, nominal, Options(strategy=strategy, first_only=True, reduce=False)).run()


def _with(check: Check, **said: Any) -> Check:
    return replace(check, file=check.file.model_copy(update=said))


def _budget(runs: int) -> Any:
    return CheckFile.model_validate({"world": "", "controller": {"python": "-"}, "budget": {"runs": runs}}).budget

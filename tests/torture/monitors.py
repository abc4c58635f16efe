"""Compare our monitor of Signal Temporal Logic with an independent one: `python -m tests.torture.monitors --help`.

Each case is a random formula and a random trace. It is a finding if robustness differs from that of mstlo at any time
at which both are certain, or if mstlo is certain of more times.
"""

# ruff: noqa: T201 - printing is what a command does

from __future__ import annotations

import argparse
import importlib
import math
import sys
import time
from dataclasses import dataclass
from random import Random
from typing import TYPE_CHECKING, Any, Final

from hmrsim.properties.temporal import (
    Above,
    Always,
    And,
    Eventually,
    Formula,
    Implies,
    Not,
    OnlineMonitor,
    Or,
    Until,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

SIGNALS: Final = ("x", "y", "z")

_GRID: Final = 8
"""Parts of a second in which times are whole numbers, so that sums of them are exact."""
_CLOSE: Final = 1e-9


@dataclass(frozen=True)
class Case:
    """A formula, and samples of all signals: their times in eighths of a second, and their values."""

    formula: Formula
    samples: tuple[tuple[int, tuple[float, ...]], ...]


def case(random: Random) -> Case:
    formula = _formula(random, depth=random.randint(0, 4))
    at, samples = 0, []
    for _ in range(random.randint(1, 40)):
        samples.append((at, tuple(float(random.randint(-9, 9)) for _ in SIGNALS)))
        at += random.choice((1, 1, 2, 3, 8, 20))
    return Case(formula, tuple(samples))


def _formula(random: Random, depth: int) -> Formula:
    if depth == 0:
        # Values are whole, and bounds are not, so that none is met exactly.
        return Above(random.choice(SIGNALS), random.randint(-5, 5) + 0.5)
    start = random.choice((0, 0, 1, 3, 8))
    end = start + random.choice((0, 1, 4, 10, 40))
    left, right = (_formula(random, random.randint(0, depth - 1)) for _ in range(2))
    kinds = (
        Not(left),
        And(left, right),
        Or(left, right),
        Implies(left, right),
        Always(start, end, left),
        Eventually(start, end, left),
        Until(start, end, left, right),
    )
    return random.choice(kinds)


Steps = list[tuple[float, float]]
"""Times and the values from then on, each unlike the one before."""


def ours(case: Case) -> tuple[Steps, float]:
    """Return the robustness by our monitor, and until when it is certain."""
    monitor = OnlineMonitor(case.formula, SIGNALS)
    found: Steps = []
    for at, values in case.samples:
        found += monitor.update(at, values)
    return _steps(found), monitor.known


def theirs(case: Case, mstlo: Any) -> tuple[Steps, float]:
    """Return the robustness by mstlo, and until when it is certain."""
    made = _theirs(case.formula, mstlo.Formula)
    monitor = mstlo.Monitor(made, semantics="DelayedQuantitative", signal_interpolation="ZeroOrderHold")
    used = [(i, name) for i, name in enumerate(SIGNALS) if name in {*case.formula.signals()}]
    batch = {name: [(values[i], at / _GRID) for at, values in case.samples] for i, name in used}
    found = [(at * _GRID, value) for at, value in monitor.update_batch(batch).verdicts()]
    return _steps(found), found[-1][0] if found else -math.inf


def _theirs(formula: Formula, make: Any) -> Any:
    parts = [_theirs(part, make) for part in formula.parts]
    match formula:
        case Above(signal, bound):
            return make.gt(signal, bound)
        case Always(start, end) | Eventually(start, end) | Until(start, end):
            return _MADE[type(formula)](make)(start / _GRID, end / _GRID, *parts)
    return _MADE[type(formula)](make)(*parts)


_MADE: Final[dict[type[Formula], Callable[[Any], Any]]] = {
    Not: lambda make: make.not_,
    And: lambda make: make.and_,
    Or: lambda make: make.or_,
    Implies: lambda make: make.implies,
    Always: lambda make: make.always,
    Eventually: lambda make: make.eventually,
    Until: lambda make: make.until,
}


def _steps(found: Sequence[tuple[float, float]]) -> Steps:
    steps: Steps = []
    for at, value in found:
        if not steps or abs(steps[-1][1] - value) > _CLOSE:
            steps.append((float(at), value))
    return steps


def difference(case: Case, mstlo: Any) -> str:
    """Return how the two monitors differ, in a line; empty if they agree."""
    (mine, known), (others, last) = ours(case), theirs(case, mstlo)
    until = min(known, last)
    mine, others = ([step for step in steps if step[0] <= until] for steps in (mine, others))
    if mine != others:
        return f"robustness {mine}, by mstlo {others}"
    return f"known up to {known}, by mstlo up to {last}" if last > known else ""


def main(argv: Sequence[str] | None = None) -> int:
    """Compare, and return 1 if there is a finding."""
    parser = argparse.ArgumentParser(prog="python -m tests.torture.monitors", description=__doc__)
    parser.add_argument("--count", type=int, default=100_000, help="how many cases; %(default)s by default")
    parser.add_argument("--seed", type=int, default=1, help="of the first case; %(default)s by default")
    args = parser.parse_args(argv)
    mstlo = importlib.import_module("mstlo_python")

    began, findings = time.monotonic(), 0
    for number in range(args.seed, args.seed + args.count):
        made = case(Random(number))
        if said := difference(made, mstlo):
            findings += 1
            print(f"case {number}: {made.formula}: {said}")
    print(f"{args.count} cases in {time.monotonic() - began:.0f} s, {findings} findings")
    return bool(findings)


if __name__ == "__main__":
    sys.exit(main())

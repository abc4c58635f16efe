"""First fleets: orders served on small random fleets, as new users draw them, by one plain dispatcher.

Fleets are those that `hmrsim world generate` writes; the dispatcher is that of `benchmarks/_dispatched.py`. Only fleets
count whose orders can all be served, as a search over configurations of robots shows.

``python -m benchmarks.first_fleets --seeds 0:200 --policy planned --failures`` shows what goes wrong.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, NamedTuple

from benchmarks._dispatched import LIMIT, Outcome, dispatched
from benchmarks._report import Row
from hmrsim.random_fleets.generator import random_fleet
from hmrsim.random_fleets.oracle import Verdict, solve
from hmrsim.world.model import World

QUICK: dict[str, Any] = {"seeds": 4}

_POLICIES = ("reserve", "priority", "planned")


class _Run(NamedTuple):
    """What came of one fleet under one policy; no outcome if it was not run."""

    seed: int
    policy: str
    verdict: Verdict
    outcome: Outcome | None


class _Job(NamedTuple):
    """A fleet to run under some policies, if it is solvable or need not be."""

    seed: int
    policies: tuple[str, ...]
    solvable: bool
    patience: float | None
    limit: float


def run(seeds: int = 200, policies: Sequence[str] = _POLICIES) -> list[Row]:
    """Measure the fleets of so many seeds under each policy."""
    rows: list[Row] = []
    found = [*_runs(range(seeds), policies)]
    for policy in policies:
        outcomes = [run.outcome for run in found if run.policy == policy and run.outcome is not None]
        served, total = (sum(getattr(each, name) for each in outcomes) for name in ("served", "total"))
        rows += [
            Row(f"{policy}: orders served", 100.0 * served / max(1, total), f"% of {total:,}"),
            Row(f"{policy}: flawless fleets", _share(outcomes), f"% of {len(outcomes)}"),
            Row(f"{policy}: aborted goals", sum(len(each.aborted) for each in outcomes), "goals"),
            Row(f"{policy}: robots at rest that touch", sum(len(each.touching) for each in outcomes), "pairs"),
            Row(f"{policy}: robots that wait at the end", sum(len(each.waiting) for each in outcomes), "robots"),
            Row(f"{policy}: longest instant", 1e3 * max(each.longest[0] for each in outcomes), "ms"),
            Row(f"{policy}: processor time", sum(each.took for each in outcomes) / len(outcomes), "s a fleet"),
        ]
    return rows


def _share(outcomes: Sequence[Outcome]) -> float:
    return 100.0 * sum(each.flawless for each in outcomes) / max(1, len(outcomes))


def fleet(seed: int, policy: str, patience: float | None = 60.0) -> World:
    """Return the world of a seed under a policy."""
    return World.model_validate(random_fleet(seed) | {"traffic": {"policy": policy, "patience": patience}})


def _runs(
    seeds: Iterable[int],
    policies: Sequence[str],
    *,
    solvable: bool = True,
    patience: float | None = 60.0,
    limit: float = LIMIT,
) -> Iterable[_Run]:
    """Yield the runs of seeds in order, on all cores; with *solvable* of those only that are sure to be."""
    jobs = [_Job(seed, tuple(policies), solvable, patience, limit) for seed in seeds]
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        for runs in pool.map(_run_seed, jobs):
            yield from runs


def _run_seed(job: _Job) -> list[_Run]:
    # It is the same under each policy.
    verdict = solve(fleet(job.seed, job.policies[0]), any_robot=False) if job.solvable else Verdict("unknown")
    is_run = verdict.answer == "solvable" or not job.solvable
    return [
        _Run(
            job.seed,
            policy,
            verdict,
            dispatched(fleet(job.seed, policy, job.patience), job.limit) if is_run else None,
        )
        for policy in job.policies
    ]


def _described(run: _Run, *, details: bool) -> str:
    outcome = run.outcome
    if outcome is None:
        return f"{run.seed:5} {run.policy:9} not run: {run.verdict.answer}, {run.verdict.why}"
    line = (
        f"{run.seed:5} {run.policy:9} {outcome.served:2}/{outcome.total:2} served, {len(outcome.aborted):2} aborted,"
        f" {len(outcome.touching)} touching, {len(outcome.waiting)} waiting, {outcome.deadlocks} deadlocks,"
        f" longest instant {1e3 * outcome.longest[0]:.0f} ms at {outcome.longest[1]:.0f} s,"
        f" {outcome.took:.2f} s in all, makespan {outcome.makespan:.0f} s, ended at {outcome.ended:.0f} s"
    )
    if not details:
        return line
    told = [("aborted", outcome.aborted), ("touching", outcome.touching), ("waiting", outcome.waiting)]
    return "\n".join([line, *(f"        {what}: {text}" for what, texts in told for text in texts)])


def main(argv: Sequence[str] | None = None) -> None:
    """Run some seeds, and print what came of each of them."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.first_fleets", description="Run random fleets.")
    parser.add_argument("--seeds", default="0:100", metavar="A:B", help="from A up to B, or one seed")
    parser.add_argument("--policy", nargs="+", default=_POLICIES, choices=_POLICIES)
    parser.add_argument("--patience", type=float, default=60.0, metavar="S", help="0 for no limit (60)")
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="S", help="end each run at this simulated time")
    parser.add_argument("--all", action="store_true", help="run fleets that may be unsolvable, too, without the search")
    parser.add_argument("--failures", action="store_true", help="print the runs that failed only")
    parser.add_argument(
        "--details", action="store_true", help="print each aborted goal, and which robots touch or wait"
    )
    args = parser.parse_args(argv)
    first, colon, last = args.seeds.partition(":")
    seeds = range(int(first), int(last) if colon else int(first) + 1)
    found: list[_Run] = []
    for run in _runs(seeds, args.policy, solvable=not args.all, patience=args.patience or None, limit=args.limit):
        found.append(run)
        if not (args.failures and (run.outcome is None or run.outcome.flawless)):
            print(_described(run, details=args.details), flush=True)
    for policy in args.policy:
        print(_summary(policy, [run for run in found if run.policy == policy]))


def _summary(policy: str, runs: Sequence[_Run]) -> str:
    outcomes = [run.outcome for run in runs if run.outcome is not None]
    served, total = (sum(getattr(each, name) for each in outcomes) for name in ("served", "total"))
    flawless = sum(each.flawless for each in outcomes)
    return (
        f"{policy}: {served} of {total} orders served ({100 * served / max(1, total):.1f} %), {flawless} of"
        f" {len(outcomes)} fleets flawless, {sum(len(each.aborted) for each in outcomes)} goals aborted,"
        f" {sum(len(each.touching) for each in outcomes)} pairs touch,"
        f" {sum(len(each.waiting) for each in outcomes)} robots wait at the end, longest instant"
        f" {1e3 * max((each.longest[0] for each in outcomes), default=0.0):.0f} ms,"
        f" {sum(each.took for each in outcomes):.1f} s of processor time"
    )


if __name__ == "__main__":
    main()

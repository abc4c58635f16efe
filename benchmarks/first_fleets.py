"""First fleets: orders served on small random fleets, as new users draw them, by one plain dispatcher.

Fleets are those that `hmrsim map generate` writes; the dispatcher is that of `benchmarks/_dispatched.py`. Only fleets
count whose orders can all be served: because a run under one of the policies did so, or as a search over configurations
of robots shows.

``python -m benchmarks.first_fleets --seeds 0:200 --policy planned --failures`` shows what goes wrong. A search takes
longer than the runs: ``--cache FILE`` keeps its verdicts.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks._dispatched import LIMIT, Outcome, dispatched
from benchmarks._report import Row, put
from hmrsim.random_fleets.generator import random_fleet
from hmrsim.random_fleets.oracle import Verdict, solve
from hmrsim.world.model import World

QUICK: dict[str, Any] = {"seeds": 4}

_POLICIES = ("reserve", "priority", "planned")


class _Run(NamedTuple):
    """The outcome of one fleet under one policy."""

    seed: int
    policy: str
    outcome: Outcome


class _Runs(NamedTuple):
    """The outcomes of one fleet under each policy, and whether its orders can be delivered."""

    verdict: Verdict
    searched: bool
    runs: list[_Run]


class _Job(NamedTuple):
    """A fleet to run under some policies.

    Attributes:
        verdict: Whether it is solvable; None if a search has to find out where no run shows it.
    """

    seed: int
    policies: tuple[str, ...]
    verdict: Verdict | None
    patience: float | None = 60.0
    limit: float = LIMIT


class Verdicts:
    """The verdicts of seeds, in a file that grows with each new one.

    A verdict counts as long as the generator makes the same world of the seed.

    Args:
        path: The file; None to keep nothing.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path
        self._known: dict[str, dict[str, Any]] = {}
        self._written = 0.0
        if path is not None and path.exists():
            self._known = json.loads(path.read_text(encoding="utf-8"))

    def get(self, seed: int) -> Verdict | None:
        """Return the verdict of a seed; None if it is not known."""
        entry = self._known.get(f"{seed}", {})
        return Verdict(**entry["verdict"]) if entry.get("world") == _digest(seed) else None

    def add(self, seed: int, verdict: Verdict) -> None:
        """Keep the verdict of a seed."""
        self._known[f"{seed}"] = {"world": _digest(seed), "verdict": asdict(verdict)}
        if time.monotonic() > self._written + _PAUSE:
            self.write()

    def write(self) -> None:
        """Write the file, whole or not at all."""
        if self._path is not None:
            whole = self._path.with_name(f"{self._path.name}.part")
            whole.write_text(json.dumps(self._known, indent=1) + "\n", encoding="utf-8")
            whole.replace(self._path)
            self._written = time.monotonic()


_PAUSE = 5.0
"""Wall seconds between two times that verdicts are written."""


def _digest(seed: int) -> str:
    return hashlib.sha256(json.dumps(random_fleet(seed)).encode()).hexdigest()[:16]


def run(seeds: int = 200, policies: Sequence[str] = _POLICIES, cache: Path | None = None) -> list[Row]:
    """Measure the fleets of so many seeds under each policy."""
    verdicts = Verdicts(cache)
    jobs = [_Job(seed, tuple(policies), verdicts.get(seed)) for seed in range(seeds)]
    runs = [each.runs for each in _runs(jobs) if each.verdict.answer == "solvable"]
    solvable = len(runs)
    rows = [Row("solvable fleets", 100.0 * solvable / seeds, f"% of {seeds}")]
    for number, policy in enumerate(policies):
        # The runs of a seed are in the order of the policies.
        outcomes = [of_seed[number].outcome for of_seed in runs]
        served, total = (sum(getattr(each, name) for each in outcomes) for name in ("served", "total"))
        rows += [
            Row(f"{policy}: orders served", 100.0 * served / max(1, total), f"% of {total:,}"),
            Row(f"{policy}: flawless fleets", _share(outcomes), f"% of {len(outcomes)}"),
            Row(f"{policy}: aborted goals", sum(len(each.aborted) for each in outcomes), "goals"),
            Row(f"{policy}: robots at rest that touch", sum(len(each.touching) for each in outcomes), "pairs"),
            Row(f"{policy}: robots that wait at the end", sum(len(each.waiting) for each in outcomes), "robots"),
            Row(f"{policy}: longest instant", 1e3 * max((each.longest[0] for each in outcomes), default=0.0), "ms"),
            Row(f"{policy}: processor time", _mean([each.took for each in outcomes]), "s a fleet"),
        ]
    return rows


def _mean(values: Sequence[float]) -> float:
    return sum(values) / max(1, len(values))


def _share(outcomes: Sequence[Outcome]) -> float:
    return 100.0 * sum(each.flawless for each in outcomes) / max(1, len(outcomes))


def fleet(seed: int, policy: str, patience: float | None = 60.0) -> World:
    """Return the world of a seed under a policy."""
    return World.model_validate(random_fleet(seed) | {"traffic": {"policy": policy, "patience": patience}})


def _runs(jobs: Sequence[_Job], processes: int | None = None) -> Iterable[_Runs]:
    """Yield the runs of jobs in order, on all cores."""
    with ProcessPoolExecutor(processes or os.cpu_count()) as pool:
        yield from pool.map(_run_seed, jobs)


def _run_seed(job: _Job) -> _Runs:
    runs = [
        _Run(job.seed, policy, dispatched(fleet(job.seed, policy, job.patience), job.limit)) for policy in job.policies
    ]
    if any(run.outcome.served == run.outcome.total for run in runs):
        return _Runs(Verdict("solvable", why="a run served all orders"), False, runs)
    # It is the same under each policy.
    searched = job.verdict is None
    verdict = job.verdict or solve(World.model_validate(random_fleet(job.seed)), any_robot=False)
    return _Runs(verdict, searched, runs)


def _described(run: _Run, *, details: bool) -> str:
    outcome = run.outcome
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
    args = _parser().parse_args(argv)
    first, colon, last = args.seeds.partition(":")
    seeds = range(int(first), int(last) if colon else int(first) + 1)
    verdicts = Verdicts(args.cache)
    jobs = [
        _Job(
            seed,
            tuple(args.policy),
            Verdict("unknown") if args.all else verdicts.get(seed),
            args.patience or None,
            args.limit,
        )
        for seed in seeds
    ]
    found: list[_Run] = []
    for seed, fleet_runs in zip(seeds, _runs(jobs, args.processes), strict=True):
        if fleet_runs.searched:
            verdicts.add(seed, fleet_runs.verdict)
        if not args.all and fleet_runs.verdict.answer != "solvable":
            if not args.failures:
                print(f"{seed:5} does not count: {fleet_runs.verdict.answer}, {fleet_runs.verdict.why}", flush=True)
            continue
        for run in fleet_runs.runs:
            found.append(run)
            if not (args.failures and run.outcome.flawless):
                print(_described(run, details=args.details), flush=True)
    verdicts.write()
    for policy in args.policy:
        print(_summary(policy, [run for run in found if run.policy == policy]))
    if args.write:
        put(args.write, "first_fleets", _table(args.policy, found))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.first_fleets", description="Run random fleets.")
    parser.add_argument("--seeds", default="0:100", metavar="A:B", help="from A up to B, or one seed")
    parser.add_argument("--policy", nargs="+", default=_POLICIES, choices=_POLICIES)
    parser.add_argument("--patience", type=float, default=60.0, metavar="S", help="0 for no limit (60)")
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="S", help="end each run at this simulated time")
    parser.add_argument("--all", action="store_true", help="run fleets that may be unsolvable, too, without the search")
    parser.add_argument(
        "--cache", type=Path, metavar="FILE", help="read verdicts of the search there, and add new ones"
    )
    parser.add_argument("--processes", type=int, metavar="N", help="how many at once (one for each core)")
    parser.add_argument("--write", type=Path, metavar="FILE", help="put a table of policies into this document")
    parser.add_argument("--failures", action="store_true", help="print the runs that failed only")
    parser.add_argument(
        "--details", action="store_true", help="print each aborted goal, and which robots touch or wait"
    )
    return parser


def _summary(policy: str, runs: Sequence[_Run]) -> str:
    outcomes = [run.outcome for run in runs]
    served, total = (sum(getattr(each, name) for each in outcomes) for name in ("served", "total"))
    flawless = sum(each.flawless for each in outcomes)
    return (
        f"{policy}: {served} of {total} orders served ({100 * served / max(1, total):.1f} %), {flawless} of"
        f" {len(outcomes)} fleets flawless, {sum(len(each.aborted) for each in outcomes)} goals aborted,"
        f" {sum(len(each.touching) for each in outcomes)} pairs touch,"
        f" {sum(len(each.waiting) for each in outcomes)} robots wait at the end, longest instant"
        f" {1e3 * max((each.longest[0] for each in outcomes), default=0.0):.0f} ms,"
        f" {sum(each.took for each in outcomes):.1f} s of processor time\n"
        f"  failed: {_failed(runs)}"
    )


def _table(policies: Sequence[str], runs: Sequence[_Run]) -> str:
    """Return a row for each policy, in Markdown."""
    heads = ("policy", "orders delivered", "fleets with every order delivered", "aborted goals")
    lines = [f"| {' | '.join(heads)} |", "|---|---:|---:|---:|"]
    for policy in policies:
        outcomes = [run.outcome for run in runs if run.policy == policy]
        served, total = (sum(getattr(each, name) for each in outcomes) for name in ("served", "total"))
        whole = sum(each.served == each.total for each in outcomes)
        aborted = sum(len(each.aborted) for each in outcomes)
        share = 100.0 * served / max(1, total)
        cells = f"`{policy}`", f"{served:,} of {total:,} ({share:.1f} %)", f"{whole} of {len(outcomes)}", f"{aborted:,}"
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _failed(runs: Sequence[_Run]) -> str:
    """Return the seeds that failed, by how: lost orders, robots that touch, robots that wait."""
    failed: dict[str, list[str]] = {}
    for run in runs:
        outcome = run.outcome
        if not outcome.flawless:
            signs = "l" * (outcome.served < outcome.total) + "t" * bool(outcome.touching) + "w" * bool(outcome.waiting)
            failed.setdefault(signs, []).append(f"{run.seed}")
    return "; ".join(f"{signs} {' '.join(seeds)}" for signs, seeds in sorted(failed.items())) or "none"


if __name__ == "__main__":
    main()

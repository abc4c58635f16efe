"""Search for the bugs that are planted in controllers, and let their correct twins run.

::

    python -m tests.torture.planted --budget 5m
    python -m tests.torture.planted --twins 2500

A table says of each bug whether it was found with default settings, after how long, and how small its schedule is;
of each twin, whether there was a false alarm.
"""

from __future__ import annotations

import argparse
import os
import statistics
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

from hmrsim.fault_search.campaign import Campaign, Options, limited
from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.schedule import Case
from hmrsim.trials.batches import factory_of
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.summary import Summary

HOME = Path(__file__).parents[1] / "planted"


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def catalogue() -> dict[str, Any]:
    found: dict[str, Any] = yaml.safe_load((HOME / "catalogue.yaml").read_text("utf-8"))
    return found


def check_of(entry: dict[str, Any], which: str, **search: Any) -> Check:
    """Return the check of a bug or of its twin, as a user would write it."""
    said = {"world": entry["world"], "controller": entry[which], "space": entry.get("space", {})}
    said |= {"limits": entry.get("limits", {}), **search}
    if entry.get("properties"):
        said["properties"] = entry["properties"]
    return check_at(CheckFile.model_validate(said), HOME)


def patient(entry: dict[str, Any], which: str) -> Check:
    """Return the check of a bug or of its twin, without time limits for slow machines."""
    return check_of(entry, which, limits={"wall": PATIENCE, **entry.get("limits", {})})


def recovering(entry: dict[str, Any], seconds: float) -> dict[str, Any]:
    """Return an entry whose controller has to recover."""
    said = yaml.safe_load((HOME / entry["properties"]).read_text("utf-8")) if entry.get("properties") else {}
    built_in = {**said.get("built_in", {}), "recovers": {"within": seconds}}
    return {**entry, "properties": {**said, "built_in": built_in}}


def searched(check: Check, evaluator: Evaluator, strategy: str = "guided", *, first_only: bool = True) -> Summary:
    """Return the result of a search."""
    evaluator.take(check)
    nominal = evaluator.outcomes([Case()])[0]
    check = limited(check, nominal)
    evaluator.take(check, nominal)
    return Campaign(check, evaluator, nominal, Options(strategy=strategy, first_only=first_only)).run()


def main() -> int:
    """Search; return 1 if a bug was not found, or if a twin failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[], help="these bugs only")
    parser.add_argument("--budget", default="5m", help="for each bug")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--strategy", choices=("guided", "random"), default="guided")
    parser.add_argument("--twins", type=int, default=0, help="schedules for each twin, and no search for bugs")
    parser.add_argument("--recovers", metavar="SECONDS", type=float, help="also ask for the property `recovers`")
    parser.add_argument("-j", "--jobs", type=int, default=2)
    args = parser.parse_args()
    # Commands find the programs of this environment.
    os.environ["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    make, workers = factory_of("pool", args.jobs)
    entries = {name: entry for name, entry in catalogue().items() if not args.only or name in args.only}
    if args.recovers:
        entries = {name: recovering(entry, args.recovers) for name, entry in entries.items()}
    first = next(iter(entries.values()))
    with Evaluator(check_of(first, "bug"), make, workers) as evaluator:
        return _twins(args, entries, evaluator) if args.twins else _bugs(args, entries, evaluator)


def _bugs(args: argparse.Namespace, entries: dict[str, Any], evaluator: Evaluator) -> int:
    found, sizes = [], []
    for name, entry in entries.items():
        began = time.monotonic()
        summary = searched(
            check_of(entry, "bug", budget=args.budget, seed=args.seed), evaluator, args.strategy, first_only=True
        )
        seconds = time.monotonic() - began
        if not summary.findings:
            say(f"{name:32} NOT FOUND in {summary.tried.runs} runs, {seconds:.1f} s")
            continue
        finding = summary.findings[0]
        minimal = all(finding.failure not in outcome.failures for outcome in finding.without)
        things = "; ".join(thing.describe() for thing in finding.schedule) or "without any fault"
        say(
            f"{name:32} {finding.seconds:6.1f} s {finding.run:5} runs  reduced {finding.reducing:6.1f} s  "
            f"{len(finding.schedule)} {'minimal' if minimal else 'NOT MINIMAL'}  {finding.failure}  <- {things}"
        )
        found.append(finding.seconds)
        sizes.append(len(finding.schedule))
    if found:
        small = sum(size <= 2 for size in sizes) / len(sizes)
        say(
            f"{len(found)} of {len(entries)} found; median {statistics.median(found):.1f} s, worst {max(found):.1f} s;"
            f" {small:.0%} with at most 2 things"
        )
    return int(len(found) < len(entries))


def _twins(args: argparse.Namespace, entries: dict[str, Any], evaluator: Evaluator) -> int:
    alarms = runs = 0
    for name, entry in entries.items():
        check = check_of(entry, "twin", budget={"time": args.budget, "runs": args.twins}, seed=args.seed)
        began = time.monotonic()
        summary = searched(check, evaluator, args.strategy, first_only=False)
        runs += summary.tried.runs
        alarms += summary.tried.failed
        said = f"{summary.tried.runs} schedules, {time.monotonic() - began:.1f} s, {dict(summary.tried.endings)}"
        say(f"{name:32} {summary.tried.failed} alarms in {said}")
        for finding in summary.findings:
            things = "; ".join(thing.describe() for thing in finding.schedule) or "without any fault"
            say(f"    {finding.failure}: {finding.text}  <- {things}")
    say(f"{alarms} alarms in {runs} schedules")
    return int(alarms > 0)


if __name__ == "__main__":
    sys.exit(main())

"""``hmrsim check --repro``: repeat a failure that a search has found."""

from __future__ import annotations

import argparse
import hashlib
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import show_result, warn
from hmrsim.cli.recording import recorded
from hmrsim.cli.trace_file import difference_from
from hmrsim.errors import CheckError, Problem
from hmrsim.fault_search.file.reading import read_repro
from hmrsim.fault_search.results.finding import by_begin
from hmrsim.fault_search.results.story import LONG, events_of
from hmrsim.fault_search.running.outcome import Failure
from hmrsim.fault_search.running.single import Wanted, run_case
from hmrsim.fault_search.schedules.case import Case
from hmrsim.program.memory import collect_rarely
from hmrsim.program.outputs import check_outputs
from hmrsim.settings.run import RunSettings
from hmrsim.trials.endings import ERROR

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.file.reading import Repro
    from hmrsim.fault_search.running.outcome import Outcome


def repeat(args: argparse.Namespace) -> int:
    """Repeat a failure; return the exit code: 1 if the run fails, in the same or another way."""
    check_outputs([("--record", args.record)], [args.repro])
    if args.folder is not None and not args.folder.is_dir():
        raise WrongUse(f"--folder {args.folder}: no such folder")
    repro = read_repro(args.repro, args.folder)
    # The file may come from someone else, and it names a program that is run.
    warn(f"{args.repro}: runs {repro.check.file.controller.described}")
    collect_rarely()
    with ExitStack() as stack:
        wanted = Wanted(trace=True, story=True)
        if args.record:
            further = stack.enter_context(recorded(args.record, RunSettings(clock="lockstep")))
            wanted = Wanted(trace=True, story=True, further=further)
        outcome = run_case(_compared(repro.check), repro.case, wanted)
    if outcome.ending == ERROR:
        raise CheckError([Problem(str(args.repro), "", f"can't be repeated: {outcome.cause}")])
    show_result(_facts(repro, outcome), _lines(args, repro, outcome), as_json=args.json)
    return ExitCode.FAILED if outcome.failure else ExitCode.DONE


def _compared(check: Check) -> Check:
    """Return the check with its run without faults, which is made here if a property compares runs with it."""
    if not check.compares:
        return check
    nominal = run_case(check, Case())
    return replace(check, reference=nominal.items if nominal.ending == "succeeded" else None)


def _trace_of(path: Path, folder: Path | None) -> str:
    """Repeat a failure and return its trace."""
    repro = read_repro(path, folder)
    return run_case(repro.check, repro.case, Wanted(trace=True)).trace


def _same(repro: Repro, outcome: Outcome) -> bool:
    return Failure(repro.failure.property, repro.failure.reason) in outcome.failures


def _same_trace(repro: Repro, outcome: Outcome) -> bool | None:
    """Return whether the trace is the same; None if there was none, as for a controller that hangs."""
    return hashlib.sha256(outcome.trace.encode()).hexdigest() == repro.trace if repro.trace else None


def _facts(repro: Repro, outcome: Outcome) -> dict[str, object]:
    return {
        "failed": outcome.failure is not None,
        "same_failure": _same(repro, outcome),
        "same_trace": _same_trace(repro, outcome),
        "ending": outcome.ending,
        "cause": outcome.cause,
        "at": outcome.at,
        "violations": [violation.as_dict() for violation in outcome.violations],
    }


def _lines(args: argparse.Namespace, repro: Repro, outcome: Outcome) -> Iterator[str]:
    schedule = repro.case.schedule
    for number, i in enumerate(by_begin(schedule, outcome), 1):
        yield f"{number}. {schedule[i].describe()}"
    yield ""
    for at, text in events_of(outcome, LONG):
        yield f"{at:10.3f} s  {text}"
    cause = f" ({outcome.cause})" if outcome.cause else ""
    yield f"{outcome.at:10.3f} s  the run ends: {outcome.ending}{cause}"
    yield ""
    same_trace = _same_trace(repro, outcome)
    if outcome.failure is None:
        yield f"it passes: {repro.failure.property} is not violated any more"
    elif _same(repro, outcome):
        trace = {True: " (with the same trace)", False: " (with another trace)", None: ""}[same_trace]
        yield f"it fails as before: {repro.failure.property}: {repro.failure.reason}{trace}"
    else:
        yield f"it fails otherwise: {outcome.failure}"
    if same_trace is False:
        yield difference_from("", outcome.trace, _trace_of, args.repro, args.folder)

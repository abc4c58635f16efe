"""Repeating a failure that ``hmrsim check`` has found."""

from __future__ import annotations

import argparse
import hashlib
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.first_difference import difference_from
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.run_recording import recorded
from hmrsim.errors import CheckError, Problem
from hmrsim.fault_search.file.reading import read_repro
from hmrsim.fault_search.results.story import LONG, events_of
from hmrsim.fault_search.results.summary import by_begin
from hmrsim.fault_search.running.single import Failure, Wanted, run_case
from hmrsim.fault_search.schedule import Case
from hmrsim.program.garbage import collect_rarely
from hmrsim.program.outputs import check_outputs
from hmrsim.settings.run import RunSettings
from hmrsim.trials.trial import ERROR

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.file.reading import Repro
    from hmrsim.fault_search.running.single import Outcome


def repeat(args: argparse.Namespace) -> int:
    """Repeat a failure; return the exit code: 1 if it fails, in this or in another way."""
    check_outputs([("--record", args.record)], [args.repro])
    if args.folder is not None and not args.folder.is_dir():
        raise WrongUse(f"--folder {args.folder}: no such folder")
    repro = read_repro(args.repro, args.folder)
    # Such a file may come from others, and what it names is a program.
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
    if args.json:
        show_json(_said(repro, outcome))
    else:
        _tell(repro, outcome)
        if _same_trace(repro, outcome) is False:
            show(difference_from("", outcome.trace, _trace_of, args.repro, args.folder))
    return ExitCode.FAILED if outcome.failure else ExitCode.DONE


def _compared(check: Check) -> Check:
    """Return a check that knows its run without faults, which is made for that, if a property compares runs with it."""
    if not check.compares:
        return check
    nominal = run_case(check, Case())
    return replace(check, reference=nominal.items if nominal.ending == "succeeded" else None)


def _trace_of(path: Path, folder: Path | None) -> str:
    """Return the trace of a failure, which is repeated once more."""
    repro = read_repro(path, folder)
    return run_case(repro.check, repro.case, Wanted(trace=True)).trace


def _same(repro: Repro, outcome: Outcome) -> bool:
    return Failure(repro.failure.property, repro.failure.reason) in outcome.failures


def _same_trace(repro: Repro, outcome: Outcome) -> bool | None:
    """Return whether the trace is the same; None if there was none, as of a controller that hangs."""
    return hashlib.sha256(outcome.trace.encode()).hexdigest() == repro.trace if repro.trace else None


def _said(repro: Repro, outcome: Outcome) -> dict[str, object]:
    return {
        "failed": outcome.failure is not None,
        "same_failure": _same(repro, outcome),
        "same_trace": _same_trace(repro, outcome),
        "ending": outcome.ending,
        "cause": outcome.cause,
        "at": outcome.at,
        "violations": [violation.as_dict() for violation in outcome.violations],
    }


def _tell(repro: Repro, outcome: Outcome) -> None:
    schedule = repro.case.schedule
    for number, i in enumerate(by_begin(schedule, outcome), 1):
        show(f"{number}. {schedule[i].describe()}")
    show("")
    for at, text in events_of(outcome, LONG):
        show(f"{at:10.3f} s  {text}")
    cause = f" ({outcome.cause})" if outcome.cause else ""
    show(f"{outcome.at:10.3f} s  the run ends: {outcome.ending}{cause}")
    show("")
    if outcome.failure is None:
        show(f"it passes: {repro.failure.property} is not violated any more")
    elif _same(repro, outcome):
        trace = {True: " (with the same trace)", False: " (with another trace)", None: ""}[_same_trace(repro, outcome)]
        show(f"it fails as before: {repro.failure.property}: {repro.failure.reason}{trace}")
    else:
        show(f"it fails otherwise: {outcome.failure}")

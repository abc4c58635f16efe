"""The runs of ``hmrsim check``: the search for failures of a controller, and the repetition of one."""

from __future__ import annotations

import argparse
import hashlib
import shlex
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, WrongUse
from hmrsim.cli.output import ProgressLine, counted, show_result, warn
from hmrsim.cli.replay import difference_from
from hmrsim.documents.document import read_document
from hmrsim.errors import CheckError, HmrsimError, Problem, WorldError
from hmrsim.fault_search.campaign import Campaign, Options, Progress, limited, no_search
from hmrsim.fault_search.evaluator import Evaluator
from hmrsim.fault_search.failure_page import failure_page, run_logged
from hmrsim.fault_search.reading import check_at, file_of, read_check, read_repro
from hmrsim.fault_search.results_folder import ResultsFolder
from hmrsim.fault_search.run import VERDICTS, Failure, Wanted, run_case
from hmrsim.fault_search.schedule import Case
from hmrsim.fault_search.story import LONG, events_of, passes
from hmrsim.fault_search.summary import by_begin
from hmrsim.program.files import write_text
from hmrsim.program.memory import collect_rarely
from hmrsim.settings.run import RunSettings
from hmrsim.trials.batches import factory_of
from hmrsim.trials.trial import DIED, ERROR, TIMEOUT
from hmrsim.world.overlays.overlay import setting

if TYPE_CHECKING:
    from hmrsim.fault_search.check import Check
    from hmrsim.fault_search.reading import Repro
    from hmrsim.fault_search.run import Outcome
    from hmrsim.fault_search.summary import Finding, Summary

_KEYS: Final = frozenset({"controller", "world", "space", "limits", "budget"})
"""Keys of check files that worlds don't have; any of them is enough, since another may be misspelled."""
_ENOUGH: Final = 500
"""Runs below which a search is too short to mean much."""
_MINUTES: Final = 120.0
"""Seconds from which a time is shown in minutes."""
_PERIOD: Final = 30.0
"""Wall seconds between two lines without a terminal."""


def search(args: argparse.Namespace, controllers: Sequence[str]) -> int:
    """Search for failures, with the *controllers* that options name; return the exit code."""
    make, workers = factory_of(args.executor, args.jobs)
    check = _check(args, controllers)
    for problem in check.warnings:
        warn(f"warning: {problem}")
    results = ResultsFolder(args.output or Path(f"{check.name}_check"))
    line = ProgressLine(_PERIOD, quiet=args.json)
    began = time.monotonic()
    with Evaluator(check, make, workers) as evaluator:
        try:
            with line.showing("starting: the run without faults"):
                nominal = next(iter(evaluator.outcomes([Case()], began + check.file.budget.time)), None)
        except KeyboardInterrupt:
            warn("interrupted before the run without faults was over: nothing was tried")
            return ExitCode.INTERRUPTED
        if nominal is None:
            seconds = f"the run without faults is not over after {check.file.budget.time:g} s"
            raise CheckError([Problem(check.place, "budget", f"{seconds}; give more time")])
        if why := no_search(nominal):
            raise CheckError([Problem(check.place, "controller", why)])
        results.prepare()
        _warn_of(nominal, check)
        check = limited(check, nominal)
        evaluator.take(check, nominal)
        display = _Display(check, results, line, quiet=args.json)
        earlier = _earlier(results)

        def set_aside(case: Case, why: str) -> None:
            path = next(path for path, each, _ in earlier if each is case)
            why = f"its world does not fit the controller any more; {why}"
            warn(f"warning: set aside {path}: {why}. Delete it, or keep it")

        options = Options(
            first_only=args.first,
            earlier=[(case, failure) for _, case, failure in earlier],
            set_aside=set_aside,
            tell=display.update,
            on_finding=display.on_finding,
        )
        with line.showing("searching"):
            summary = Campaign(check, evaluator, nominal, options, began).run()
    if summary.complete and not summary.tried.singles:
        warn("warning: nothing was tried: nothing of the space can happen in the run without faults")
    summary.files.update(display.files)
    results.finish(check, summary, evaluator.covered)
    show_result(summary.to_json(), _summary_lines(summary, results.folder), as_json=args.json)
    if args.page is not None:
        _write_page(args.page, check, summary)
    if not summary.complete:
        return ExitCode.INTERRUPTED
    return ExitCode.FAILED if summary.findings else ExitCode.DONE


def _write_page(path: Path, check: Check, summary: Summary) -> None:
    """Write the page of the first failure, which is repeated for it."""
    if not summary.findings:
        warn(f"--page {path}: not written, since no failure was found")
        return
    # A run that kills its process would end this command, too.
    case = next((each.case for each in summary.findings if each.outcome.ending != DIED), None)
    if case is None:
        warn(f"--page {path}: not written, since the controller kills the process of its run")
        return
    outcome, log = run_logged(check, case, VERDICTS)
    write_text("--page", path, failure_page(check, case, outcome, log))
    warn(f"page: {path}")


def _warn_of(nominal: Outcome, check: Check) -> None:
    """Warn if the controller does not succeed even without faults, unless it need not end."""
    if nominal.ending != "succeeded" and (nominal.ending != TIMEOUT or check.properties.built_in.mission_ends):
        cause = nominal.cause or nominal.output.rpartition("\n")[2]
        why = f": {cause.removeprefix(f'{nominal.ending}: ')}" if cause else ""
        if nominal.ending == TIMEOUT:
            why += "; for a controller that never ends, put `built_in: {mission_ends: false}` into its properties"
        warn(f"warning: without faults the run ends as {nominal.ending} at {nominal.at:.1f} s{why}")


def _check(args: argparse.Namespace, controllers: Sequence[str]) -> Check:
    if args.world is None:
        raise WrongUse(
            "expected a world or the file of a check, --repro FILE or --trace TRACE; see hmrsim check --help"
        )
    if _is_check(args.world):
        given = [f"--{name}" for name in (*controllers, *_given(robots=args.robots, properties=args.properties))]
        given += ["--set"] if args.changes else []
        if given:
            raise WrongUse(f"{args.world}: the file of a check says that itself; leave out {', '.join(given)}")
        return _overridden(read_check(args.world), args)
    if len(controllers) != 1:
        raise WrongUse(f"{args.world}: expected one of --tree, --python and --command, or the file of a check")
    controller: dict[str, Any] = {controllers[0]: getattr(args, controllers[0])}
    if args.robots:
        controller["robots"] = args.robots
    overlay: dict[str, Any] = {}
    for text in args.changes:
        overlay |= setting(text).source.document.data
    values = {"world": args.world, "controller": controller, "overlay": overlay, **_options(args, {})}
    if args.properties:
        values["properties"] = args.properties
    return check_at(file_of(values), Path.cwd())


def _is_check(source: str) -> bool:
    path = Path(source)
    try:
        data = read_document(path, WorldError).data if path.suffix in {".yaml", ".yml", ".json"} else None
    except WorldError:
        return False
    return isinstance(data, dict) and not _KEYS.isdisjoint(data)


def _overridden(check: Check, args: argparse.Namespace) -> Check:
    values = check.file.model_dump(mode="json", by_alias=True, exclude_unset=True)
    options = _options(args, values)
    return check_at(file_of({**values, **options}), check.folder) if options else check


def _options(args: argparse.Namespace, values: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of the search from the options, merged with the values of a file."""
    settings: dict[str, Any] = {}
    if budget := _given(time=args.budget, runs=args.runs):
        of_file = values.get("budget") or {}
        settings["budget"] = {**(of_file if isinstance(of_file, dict) else {"time": of_file}), **budget}
    settings |= _given(seed=args.seed)
    if space := _given(at_most=args.at_most, only=args.only, without=args.without, also=args.also, spare=args.spare):
        settings["space"] = {**values.get("space", {}), **space}
    return settings


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _earlier(results: ResultsFolder) -> list[tuple[Path, Case, Failure]]:
    """Return the failures that earlier searches have found."""
    cases = []
    for path in results.earlier():
        try:
            repro = read_repro(path)
        except HmrsimError as error:
            warn(f"warning: set aside {path}: {error}")
            continue
        failure = Failure(repro.failure.property, repro.failure.reason)
        cases.append((path, Case(repro.case.schedule, repro.check.definition), failure))
    return cases


class _Display:
    """Shows the progress of a search, and writes the files of its failures, which are known by their numbers from 1."""

    def __init__(self, check: Check, results: ResultsFolder, line: ProgressLine, *, quiet: bool) -> None:
        self.files: dict[int, str] = {}
        self._check, self._results, self._line, self._quiet = check, results, line, quiet

    def update(self, progress: Progress) -> None:
        """Show the progress."""
        self._line.report(lambda: _progress_text(progress))

    def on_finding(self, finding: Finding) -> None:
        """Write the files of a failure, and print that it was found."""
        path = self._results.keep(self._check, finding)
        self.files[len(self.files) + 1] = str(path)
        self._line.show()
        if not self._quiet:
            count = counted(len(finding.schedule), "things") if finding.schedule else "without any fault"
            warn(f"found after {finding.seconds:.1f} s: {finding.failure.property}: {finding.text} ({count})")


def _progress_text(progress: Progress) -> str:
    tried = progress.search.tried
    pace = tried.runs / progress.seconds if progress.seconds else 0.0
    singles = tried.singles - tried.singles_left
    if progress.reducing:
        effort = f"{progress.reduced_in:,} runs, at most {progress.left:.0f} s more"
        return f"reducing a failure of {progress.reducing}: {effort}"
    return (
        f"searching: {tried.runs:,} runs, {pace:.0f}/s, {counted(len(progress.findings), 'failures')}, "
        f"{singles:,} of {tried.singles:,} single things, {len(progress.search.guide.features):,} features, "
        f"{progress.left:.0f} s left"
    )


def _summary_lines(summary: Summary, folder: Path) -> Iterator[str]:
    tried = summary.tried
    failures = counted(len(summary.findings), "failures") if summary.findings else "no failure"
    pace = tried.runs / summary.seconds if summary.seconds else 0.0
    ended = "" if summary.complete else ", interrupted"
    yield f"{summary.name}: {failures} in {tried.runs:,} runs ({summary.seconds:.1f} s, {pace:,.1f} runs/s{ended})"
    for number, finding in enumerate(summary.findings, 1):
        yield ""
        yield from _finding(number, finding, summary.files.get(number, ""))
    yield ""
    singles = tried.singles - summary.unreached.singles
    yield f"tried: {singles:,} of {tried.singles:,} single things at their moments, and schedules of several"
    if summary.covered:
        yield f"of the tree: {summary.covered}; see `bt-controller coverage {folder / 'coverage.json'}`"
    if tried.gave_up and summary.nominal.ending == "succeeded":
        first = "; ".join(summary.gave_up_first)
        share = f"{tried.gave_up:,} of {tried.transient:,}"
        yield f"gave up in {share} schedules with transient faults only, first: {first}"
    if summary.too_few:
        yield _too_few(summary)
    if summary.unreached.untried and not summary.too_few:
        yield f"not tried: {', '.join(summary.unreached.untried)}"
    if summary.unreached.kinds:
        yield f"never began: {', '.join(summary.unreached.kinds)}"
    if summary.unreached.properties:
        yield f"never exercised: {', '.join(summary.unreached.properties)}"
    yield f"report: {folder / 'report.html'}"


def _too_few(summary: Summary) -> str:
    """Return a warning that there were far too few runs, and why."""
    tried, unreached = summary.tried, summary.unreached
    per_run = summary.seconds / max(1, tried.runs)
    text = f"{tried.runs:,} runs in {_time(summary.seconds)} are far too few for this mission ({per_run:.2g} s each)"
    if unreached.untried:
        text += f"; {counted(len(unreached.untried), 'kinds')} of things had no turn"
    return f"{text}; allow it {_time(per_run * _ENOUGH)} or more"


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < _MINUTES else f"{seconds / 60:.0f} minutes"


def _finding(number: int, finding: Finding, file: str) -> Iterator[str]:
    yield f"{number}. {finding.failure.property}: {finding.text}"
    if not finding.schedule:
        yield "   It fails without any fault."
    for thing, outcome in finding.in_order:
        yield f"   - {thing.describe()}"
        yield f"     without it {passes(outcome)}"
    if file:
        yield f"   hmrsim check --repro {shlex.quote(file)}"


def repeat(args: argparse.Namespace) -> int:
    """Repeat a failure; return the exit code: 1 if the run fails, in the same or another way."""
    if args.folder is not None and not args.folder.is_dir():
        raise WrongUse(f"--folder {args.folder}: no such folder")
    repro = read_repro(args.repro, args.folder)
    # The file may come from someone else, and it names a program that is run.
    warn(f"{args.repro}: runs {repro.check.file.controller.described}")
    collect_rarely()
    with ExitStack() as stack:
        wanted = Wanted(trace=True, story=True)
        if args.record:
            # Loads the MCAP writer, which takes 100 ms.
            from hmrsim.cli.record import recorded

            further = stack.enter_context(recorded(args.record, RunSettings(clock="lockstep")))
            wanted = Wanted(trace=True, story=True, further=further)
        check = _compared(repro.check)
        if args.page is None:
            outcome, log = run_case(check, repro.case, wanted), None
        else:
            outcome, log = run_logged(check, repro.case, wanted)
    if outcome.ending == ERROR:
        raise CheckError([Problem(str(args.repro), "", f"can't be repeated: {outcome.cause}")])
    show_result(_repro_facts(repro, outcome), _repro_lines(args, repro, outcome), as_json=args.json)
    if log is not None:
        if outcome.failure is None:
            warn(f"--page {args.page}: not written, since the run passes")
        else:
            write_text("--page", args.page, failure_page(check, repro.case, outcome, log))
            warn(f"page: {args.page}")
    return ExitCode.FAILED if outcome.failure else ExitCode.DONE


def _compared(check: Check) -> Check:
    """Return the check with its run without faults, which is made here if a property compares runs with it."""
    if not check.compares:
        return check
    nominal = run_case(check, Case())
    return replace(check, reference=nominal.items if nominal.ending == "succeeded" else None)


def _trace_of(path: Path, folder: Path | None) -> str:
    repro = read_repro(path, folder)
    return run_case(repro.check, repro.case, Wanted(trace=True)).trace


def _same(repro: Repro, outcome: Outcome) -> bool:
    return Failure(repro.failure.property, repro.failure.reason) in outcome.failures


def _same_trace(repro: Repro, outcome: Outcome) -> bool | None:
    """Return whether the trace is the same; None if there was none, as for a controller that hangs."""
    return hashlib.sha256(outcome.trace.encode()).hexdigest() == repro.trace if repro.trace else None


def _repro_facts(repro: Repro, outcome: Outcome) -> dict[str, object]:
    return {
        "failed": outcome.failure is not None,
        "same_failure": _same(repro, outcome),
        "same_trace": _same_trace(repro, outcome),
        "ending": outcome.ending,
        "cause": outcome.cause,
        "at": outcome.at,
        "violations": [violation.as_dict() for violation in outcome.violations],
    }


def _repro_lines(args: argparse.Namespace, repro: Repro, outcome: Outcome) -> Iterator[str]:
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

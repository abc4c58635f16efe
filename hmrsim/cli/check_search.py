"""Searching for failures of a controller from the command line."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.check import CONTROLLERS
from hmrsim.cli.check_text import progress_text, summary_text
from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.terminal_line import TerminalLine
from hmrsim.errors import CheckError, HmrsimError, Problem, WorldError
from hmrsim.fault_search.file.reading import check_at, check_of, file_of, read_check, read_repro
from hmrsim.fault_search.results.folder import ResultsFolder
from hmrsim.fault_search.running.evaluator import Evaluator
from hmrsim.fault_search.running.single import Failure
from hmrsim.fault_search.schedule import Case
from hmrsim.fault_search.searching.campaign import Campaign, Options, Progress, limited, no_search
from hmrsim.trials.batches import factory_of
from hmrsim.trials.trial import TIMEOUT
from hmrsim.world.files import read_text
from hmrsim.world.overlays.overlay import setting
from hmrsim.world.yaml_text import Unreadable, read

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.fault_search.file.check import Check
    from hmrsim.fault_search.results.summary import Finding, Summary
    from hmrsim.fault_search.running.single import Outcome

_LOOK: Final = 0.2
"""Wall seconds between two updates of the line on a terminal."""
_QUIET: Final = 30.0
"""Wall seconds between two lines where there is no terminal."""


def search(args: argparse.Namespace) -> int:
    """Search for failures; return the exit code."""
    make, workers = factory_of(args.executor, args.jobs)
    check = _check(args)
    for problem in check.warnings:
        warn(f"warning: {problem}")
    results = ResultsFolder(args.output or Path(f"{check.name}_check"))
    line = TerminalLine(quiet=args.json)
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
        _warn_of(nominal)
        check = limited(check, nominal)
        evaluator.take(check, nominal)
        teller = _Teller(check, results, line, quiet=args.json)
        earlier = _earlier(results)
        options = Options(
            first_only=args.first,
            earlier=[(case, failure) for _, case, failure in earlier],
            set_aside=lambda case, why: _set_aside(earlier, case, why),
            tell=teller.tell,
            on_finding=teller.on_finding,
        )
        with line.showing("searching"):
            summary = Campaign(check, evaluator, nominal, options, began).run()
    if summary.complete and not summary.tried.singles:
        warn("warning: nothing was tried: nothing of the space can happen in the run without faults")
    summary.files.update(teller.files)
    results.finish(check, summary, evaluator.covered)
    return _conclude(args, summary, results)


def _warn_of(nominal: Outcome) -> None:
    """Say so if the controller does not succeed without faults: then there may be little to break."""
    if nominal.ending != "succeeded":
        said = nominal.cause or nominal.output.rpartition("\n")[2]
        why = f": {said}" if said else ""
        if nominal.ending == TIMEOUT:
            why += "; for a controller that never ends, put `built_in: {mission_ends: false}` into its properties"
        warn(f"warning: without faults the run ends as {nominal.ending} at {nominal.at:.1f} s{why}")


def _conclude(args: argparse.Namespace, summary: Summary, results: ResultsFolder) -> int:
    if args.json:
        show_json(summary.to_json())
    else:
        show("\n".join(summary_text(summary, results.folder)))
    if not summary.complete:
        return ExitCode.INTERRUPTED
    return ExitCode.FAILED if summary.findings else ExitCode.DONE


def _check(args: argparse.Namespace) -> Check:
    """Return the check of a file, or of the options."""
    said = [name for name in CONTROLLERS if getattr(args, name) is not None]
    if args.world is None:
        raise WrongUse(
            "expected a world or the file of a check, --repro FILE or --trace TRACE; see hmrsim check --help"
        )
    if _is_check(args.world):
        _only_search(args)
        return _over(read_check(args.world), args)
    if len(said) != 1:
        raise WrongUse(f"{args.world}: expected one of --tree, --python and --command, or the file of a check")
    controller: dict[str, Any] = {said[0]: getattr(args, said[0])}
    if args.robots:
        controller["robots"] = args.robots
    overlay: dict[str, Any] = {}
    for text in args.changes:
        overlay |= setting(text).source.document.data
    values = {"world": args.world, "controller": controller, "overlay": overlay, **_options(args, {})}
    if args.properties:
        values["properties"] = args.properties
    return check_of(file_of(values))


def _only_search(args: argparse.Namespace) -> None:
    """Raise WrongUse for an option that says what the file of a check says itself."""
    given = [f"--{name}" for name in (*CONTROLLERS, "robots", "properties") if getattr(args, name) is not None]
    given += ["--set"] if args.changes else []
    if given:
        raise WrongUse(f"{args.world}: the file of a check says that itself; leave out {', '.join(given)}")


def _is_check(source: str) -> bool:
    """Return whether a file is that of a check, and not of a world."""
    path = Path(source)
    try:
        data, _, _ = read(read_text(path, source)) if path.suffix in {".yaml", ".yml", ".json"} else (None, None, None)
    except (WorldError, Unreadable):
        return False
    return isinstance(data, dict) and "controller" in data


def _over(check: Check, args: argparse.Namespace) -> Check:
    """Return the check of a file, with what the command line says over it."""
    values = check.file.model_dump(mode="json", by_alias=True, exclude_unset=True)
    options = _options(args, values)
    return check_at(file_of({**values, **options}), check.folder) if options else check


def _options(args: argparse.Namespace, values: dict[str, Any]) -> dict[str, Any]:
    """Return what options say of the search, over the values of a file."""
    said: dict[str, Any] = {}
    budget = {"time": args.budget, "runs": args.runs}
    if any(value is not None for value in budget.values()):
        said["budget"] = {**_as_mapping(values.get("budget")), **_given(budget)}
    if args.seed is not None:
        said["seed"] = args.seed
    space = {
        "at_most": args.at_most,
        "only": args.only,
        "without": args.without,
        "also": args.also,
        "spare": args.spare,
    }
    if _given(space):
        said["space"] = {**values.get("space", {}), **_given(space)}
    return said


def _as_mapping(budget: Any) -> dict[str, Any]:
    return budget if isinstance(budget, dict) else {} if budget is None else {"time": budget}


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _set_aside(earlier: Sequence[tuple[Path, Case, Failure]], case: Case, why: str) -> None:
    path = next(path for path, each, _ in earlier if each is case)
    warn(f"warning: set aside {path}: its world does not fit the controller any more; {why}. Delete it, or keep it")


def _earlier(results: ResultsFolder) -> list[tuple[Path, Case, Failure]]:
    """Return the failures that were found earlier."""
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


class _Teller:
    """Tells how far a search is, and writes what it finds.

    Attributes:
        files: The file of each failure, by its number from 1.
    """

    def __init__(self, check: Check, results: ResultsFolder, line: TerminalLine, *, quiet: bool) -> None:
        self.files: dict[int, str] = {}
        self._check, self._results, self._line, self._quiet = check, results, line, quiet
        self._told = time.monotonic()

    def tell(self, progress: Progress) -> None:
        """Tell, if it was not just told."""
        if self._quiet or time.monotonic() - self._told < (_LOOK if self._line.shown else _QUIET):
            return
        self._told = time.monotonic()
        self._line.tell(progress_text(progress))

    def on_finding(self, finding: Finding) -> None:
        """Write the files of a failure, and say that it was found."""
        path = self._results.keep(self._check, finding)
        self.files[len(self.files) + 1] = str(path)
        self._line.show()
        if not self._quiet:
            things = len(finding.schedule)
            count = f"{things} thing{'s' * (things != 1)}" if things else "without any fault"
            warn(f"found after {finding.seconds:.1f} s: {finding.failure.property}: {finding.text} ({count})")

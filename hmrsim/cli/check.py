"""``hmrsim check``: find the faults that break a controller, repeat a failure, or apply properties to a trace."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, WrongUse, add_json, count, jobs
from hmrsim.cli.output import columns, show_result, warn
from hmrsim.errors import printable
from hmrsim.program.files import check_outputs, check_writable
from hmrsim.program.log_options import add_log_options, logging_to_stderr

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.properties import Checked, Properties, Verdict, Violation

_MAX_VIOLATIONS: Final = 50
"""Violations to print."""
_CONTROLLERS: Final = ("tree", "python", "command")
"""The options that name a controller, of which only one is given."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim check``."""
    parser.description = (
        "Find what breaks a controller: run it again and again with faults, changes of the world and disturbances of\n"
        "the wire until a property is violated, then shrink the schedule to a minimal reproducer and write a file\n"
        "that repeats it. Or apply properties to a trace or a recording."
    )
    parser.epilog = """\
exit codes: 0 no property was violated; 1 a property was violated; 2 wrong use or unreadable input; 130 Ctrl-C

examples:
  hmrsim check hospital --tree bt_controller.examples.hospital:mission --budget 1m
  hmrsim check my_world.yaml --tree mission.xml --properties properties.yaml -o results
  hmrsim check hospital --command './my_fleet_manager --robots all' --runs 500
  hmrsim check check.yaml
  hmrsim check --repro results/failures/mission_ends_it_does_not_end.yaml --page failure.html
  hmrsim check --trace run.jsonl --properties properties.yaml"""
    parser.add_argument(
        "world", metavar="WORLD", nargs="?", help="a world, or the file of a check, which contains everything else"
    )
    what = parser.add_argument_group("subject")
    what.add_argument("--tree", metavar="TREE", help="a behavior tree: FILE.xml, MODULE:FUNCTION or FILE.py:FUNCTION")
    what.add_argument("--python", metavar="FUNCTION", help="a function that takes a client: MODULE:FUNCTION")
    what.add_argument("--command", metavar="COMMAND", help="any program, over Zenoh; started for each run")
    what.add_argument("--robots", metavar="NAME", nargs="+", help="the robots of a tree (all)")
    what.add_argument("--properties", metavar="FILE", help="the properties to check, in addition to the built-in ones")
    what.add_argument(
        "--set",
        dest="changes",
        metavar="PATH=VALUE",
        action="append",
        default=[],
        help="a change of the world, such as robots.*.base.speed=0.5; repeatable",
    )
    search = parser.add_argument_group("search")
    search.add_argument("--budget", metavar="TIME", help="how long to search: 90s, 10m, 1h (10m)")
    search.add_argument("--runs", metavar="N", type=count, help="the maximum number of runs")
    search.add_argument("--seed", metavar="N", type=int, help="the seed of the search (0)")
    search.add_argument("--at-most", metavar="N", type=count, help="the maximum number of disturbances in a run (3)")
    search.add_argument("--only", metavar="KIND", nargs="+", help="the kinds to try, such as slip or speed (all)")
    search.add_argument("--without", metavar="KIND", nargs="+", help="the kinds to leave out")
    search.add_argument("--also", metavar="KIND", nargs="+", help="item_lost, second_controller, simulation_reset")
    search.add_argument("--spare", metavar="NAME", nargs="+", help="robots, doors, … to leave undisturbed")
    search.add_argument("--first", action="store_true", help="stop at the first failure")
    search.add_argument("-j", "--jobs", metavar="N", type=jobs, help="number of parallel processes (one per processor)")
    search.add_argument("--executor", metavar="WHERE", default="pool", help="as for `hmrsim experiment run` (pool)")
    other = parser.add_argument_group("instead of a search")
    other.add_argument("--repro", metavar="FILE", type=Path, help="repeat a failure that was found")
    other.add_argument("--folder", metavar="DIR", type=Path, help="the folder of the controller's files, for --repro")
    other.add_argument("--record", metavar="FILE.mcap", type=Path, help="record the run of --repro")
    other.add_argument("--trace", metavar="TRACE", type=Path, help="apply properties to a trace or a recording")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="the folder of the results (NAME_check)")
    parser.add_argument(
        "--page",
        metavar="FILE.html",
        type=Path,
        help="write a page that replays the failing run, or the first one found, beside a run that passes",
    )
    add_json(parser, "print the summary as JSON")
    add_log_options(parser)
    parser.set_defaults(function=_check)


def _check(args: argparse.Namespace) -> int:
    if args.repro is not None and args.trace is not None:
        raise WrongUse("--repro and --trace: each is a command of its own; leave one out")
    for option, value in (("--folder", args.folder), ("--record", args.record)):
        if value is not None and args.repro is None:
            raise WrongUse(f"{option} {value}: it is for --repro alone; name a failure with it, or leave it out")
    option = "--repro" if args.repro is not None else "--trace" if args.trace is not None else ""
    if option and args.world is not None:
        raise WrongUse(f"{args.world}: a world is of no use with {option}, whose file has it; leave one out")
    controllers = [name for name in _CONTROLLERS if getattr(args, name) is not None]
    if option and controllers:
        given = ", ".join(f"--{name}" for name in controllers)
        raise WrongUse(f"{option}: its file says what was run; leave out {given}")
    if args.trace is not None:
        if args.page is not None:
            raise WrongUse(f"--page {args.page}: a trace has no run beside it; `hmrsim report` shows it as a page")
        return check_trace(args)
    check_page(args)
    if args.repro is not None:
        from hmrsim.cli.check_runs import repeat

        return repeat(args)
    from hmrsim.trials.batches import load_early

    load_early(args.executor, "hmrsim.fault_search.evaluator")
    from hmrsim.cli.check_runs import search

    return search(args, controllers)


def check_page(args: argparse.Namespace) -> None:
    """Check that a page can be written, before its run takes time.

    Raises:
        OutputError: It can't be written, or is a file that the command reads or writes itself.
    """
    outputs = [("--record", args.record), ("--page", args.page)]
    check_outputs(outputs, [args.repro, args.properties, args.world if Path(args.world or "").is_file() else None])
    if args.page is not None:
        check_writable("--page", args.page)


def check_trace(args: argparse.Namespace) -> int:
    """Apply the properties to the run; return the exit code: 1 if one is violated.

    Raises:
        TraceError: The file is neither a trace nor a recording.
        PropertyError: The properties are not valid, or refer to something that the world lacks.
    """
    from hmrsim.program.memory import collect_rarely
    from hmrsim.properties import Properties
    from hmrsim.properties.model.file import read_valid_properties

    properties, flaws = (Properties(), []) if args.properties is None else read_valid_properties(args.properties)
    collect_rarely()
    with logging_to_stderr(args):
        checked = _checked(args.trace, properties, flaws)
    for note in checked.notes:
        warn(f"{args.trace}: {printable(note)}")
    monitor = checked.monitor
    lines = (*_verdict_lines(monitor.verdicts()), *_violation_lines(monitor.violations))
    show_result(_trace_facts(checked), lines, as_json=args.json)
    return ExitCode.FAILED if monitor.violations else ExitCode.DONE


def _checked(path: Path, properties: Properties, flaws: list[Finding]) -> Checked:
    from hmrsim.cli.replay import errors_of, is_recording, lines_of
    from hmrsim.cli.worlds import show_findings
    from hmrsim.properties import check_recording
    from hmrsim.properties import check_trace as check_lines
    from hmrsim_zenoh.recording import Recording

    def on_findings(further: list[Finding]) -> None:
        """Report errors and misspelled names before a long run is replayed."""
        show_findings(properties, [*flaws, *further])

    with errors_of(path, no_text="neither a trace (text) nor a recording (MCAP)"):
        if is_recording(path):
            return check_recording(Recording(path), properties, on_findings)
        return check_lines(lambda: lines_of(path), properties, on_findings)


def _trace_facts(checked: Checked) -> dict[str, Any]:
    monitor = checked.monitor
    return {
        "violated": bool(monitor.violations),
        "verdicts": [verdict.as_dict() for verdict in monitor.verdicts()],
        "violations": [violation.as_dict() for violation in monitor.violations],
        "notes": list(checked.notes),
    }


def _verdict_lines(verdicts: Sequence[Verdict]) -> Iterator[str]:
    rows = [("property", "verdict", "robustness", "")]
    for verdict in verdicts:
        robustness = f"{verdict.robustness:+.2f}" if verdict.state in {"holds", "violated"} else ""
        rows.append((verdict.property, verdict.state.replace("_", " "), robustness, verdict.text))
    return columns(rows)


def _violation_lines(violations: Sequence[Violation]) -> Iterator[str]:
    """Yield a line for each of the first violations, in order of time."""
    from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

    if not violations:
        return
    yield ""
    for violation in violations[:_MAX_VIOLATIONS]:
        yield f"{violation.at / NANOSECONDS:9.3f} s  {violation.property}: {printable(violation.text)}"
    if len(violations) > _MAX_VIOLATIONS:
        yield f"... and {len(violations) - _MAX_VIOLATIONS} more"

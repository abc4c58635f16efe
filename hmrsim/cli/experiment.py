"""``hmrsim experiment``: many runs of one world, with factors, measures and comparisons."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, WrongUse, add_json, jobs
from hmrsim.cli.output import show, show_json, show_result, show_table
from hmrsim.errors import ResultsError, printable
from hmrsim.program.command_line import Later, add_commands
from hmrsim.program.files import STDOUT, check_outputs, write_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from hmrsim.experiments.statistics.intervals import Interval
    from hmrsim.experiments.store import Results
    from hmrsim.experiments.table import Group
    from hmrsim.program.command_line import CommandParser

_MAX_FAILED: Final = 10
_PAGE: Final = "report.html"
"""The name of the page in the folder of results, if no other is given."""


def configure(parser: CommandParser) -> None:
    """Add the commands of ``hmrsim experiment``."""
    parser.description = "Run a world many times, with different settings and controllers, and summarize the results."
    parser.epilog = """\
examples:
  hmrsim experiment check delivery.yaml
  hmrsim experiment run delivery.yaml -o results && hmrsim experiment report results -o results.html
  hmrsim experiment show results
  hmrsim experiment again results 17 --trace run_17.jsonl"""
    add_commands(
        parser,
        {
            "check": ("list all errors in an experiment, without running it", _configure_check),
            "run": ("run an experiment, or continue it", _configure_run),
            "status": ("show the progress of an experiment", _configure_status),
            "show": ("show the results of an experiment, or of one run", _configure_show),
            "report": ("write the results as one page", _configure_report),
            "export": ("write the table of runs as CSV, JSON or Parquet", _configure_export),
            "again": ("repeat one run, with a trace or a report", _configure_again),
        },
    )


def _configure_check(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "List everything that is wrong with an experiment: its file, the world of each scenario, its controllers,\n"
        "measures and endings. Nothing is run."
    )
    parser.epilog = """\
exit codes: 0 no errors, maybe warnings; 2 errors

examples:
  hmrsim experiment check delivery.yaml
  hmrsim experiment check delivery.yaml --variant flaky"""
    _add_file(parser)
    add_json(parser, "print the planned runs as one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_runs", "check"))


def _configure_run(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Make all runs of an experiment, several at a time. Results are saved as they arrive: run the same command\n"
        "again to continue after an interruption or a crash."
    )
    parser.epilog = """\
exit codes: 0 all runs have a result, whatever it is; 1 results can't be written; 2 the experiment has errors;
130 Ctrl-C

examples:
  hmrsim experiment run delivery.yaml
  hmrsim experiment run delivery.yaml -o results -j 4
  hmrsim experiment run delivery.yaml -o flaky --variant flaky
  hmrsim experiment run delivery.yaml --executor dask://10.0.0.7:8786"""
    _add_file(parser)
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=Path, help="the folder of the results (the experiment's name)"
    )
    parser.add_argument("-j", "--jobs", metavar="N", type=jobs, help="number of parallel processes (one per processor)")
    parser.add_argument(
        "--executor",
        metavar="WHERE",
        default="pool",
        help="pool or pool:N processes of this machine, dask, dask://HOST:PORT, or MODULE:FACTORY, which returns a "
        "concurrent.futures.Executor (pool)",
    )
    add_json(parser, "print the progress as JSON, one object per line")
    parser.set_defaults(function=_run)


def _run(args: argparse.Namespace) -> int:
    from hmrsim.trials.batches import load_early

    load_early(args.executor, "hmrsim.experiments.replications")
    from hmrsim.cli.experiment_runs import run

    return run(args)


def _configure_again(parser: argparse.ArgumentParser) -> None:
    parser.description = "Repeat one run of an experiment in this process, and check that the result is the same."
    parser.epilog = (
        "exit codes: 0 the result is the same; 1 it differs; 2 there is no such run\n\n"
        "examples:\n  hmrsim experiment again results 17\n"
        "  hmrsim experiment again results 17 --trace run.jsonl --report run.html\n"
        "  hmrsim experiment again results 17 --page run.html\n"
        "  hmrsim experiment again results 17 --record run.mcap && hmrsim view run.mcap"
    )
    _add_results(parser)
    parser.add_argument("run", metavar="RUN", type=int, help="the number of the run")
    parser.add_argument("--trace", metavar="FILE", type=Path, help="write its trace")
    parser.add_argument("--report", metavar="FILE", type=Path, help="write its report, as one page")
    parser.add_argument(
        "--page", metavar="FILE", type=Path, help="write a page that replays it beside the run of another treatment"
    )
    parser.add_argument("--beside", metavar="TREATMENT", help="the other treatment of --page (one that succeeds)")
    parser.add_argument("--record", metavar="FILE", type=Path, help="record it, for `hmrsim view` and Foxglove (MCAP)")
    add_json(parser, "print the result as one JSON object")
    parser.set_defaults(function=Later("hmrsim.cli.experiment_runs", "again"))


def _configure_status(parser: argparse.ArgumentParser) -> None:
    parser.description = "Show how many runs of an experiment have a result, and how they ended; also while it runs."
    parser.epilog = (
        "examples:\n  hmrsim experiment status results\n  hmrsim experiment status results --json | jq .endings"
    )
    _add_results(parser)
    add_json(parser)
    parser.set_defaults(function=_status)


def _configure_show(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Show rates and means of each treatment with 95 % confidence intervals, and the runs without success; or\n"
        "everything about one run. The means of a treatment are taken over all levels of all factors; with --by there\n"
        "is a row for each level."
    )
    parser.epilog = (
        "examples:\n"
        "  hmrsim experiment show results\n"
        "  hmrsim experiment show results --by robots\n"
        "  hmrsim experiment show results 17"
    )
    _add_results(parser)
    parser.add_argument("run", metavar="RUN", type=int, nargs="?", help="the number of a run")
    parser.add_argument(
        "--by", metavar="FACTOR", action="append", default=[], help="a row for each level of a factor; repeatable"
    )
    parser.add_argument("--file", action="store_true", help="print the experiment file with which the runs were made")
    add_json(parser)
    parser.set_defaults(function=_show)


def _configure_report(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write the results of an experiment as one self-contained HTML page: rates and means of each treatment with\n"
        "confidence intervals, verdicts, effects of factors, distributions, and the runs without success. Also while\n"
        "the experiment runs."
    )
    parser.epilog = """\
exit codes: 0 done, also if runs have failed; 1 the page can't be written, or scipy is missing; 2 there are
no results

examples:
  hmrsim experiment report results
  hmrsim experiment report results -o results.html
  hmrsim experiment report results --json | jq '.comparisons[].measures | map_values(.verdict)'"""
    _add_results(parser)
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="the page; - is the standard output (report.html in the folder)"
    )
    add_json(parser, "print the content of the page as one JSON object")
    parser.set_defaults(function=_report)


def _configure_export(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write the table of runs, with one row per run. The results are SQLite, which pandas and polars also read:\n"
        "pandas.read_sql('SELECT * FROM runs', sqlite3.connect('results/results.sqlite'))"
    )
    parser.epilog = (
        "examples:\n  hmrsim experiment export results -o runs.csv\n"
        "  hmrsim experiment export results -o runs.parquet\n"
        "  hmrsim experiment export results --json | jq '.[0]'"
    )
    _add_results(parser)
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=Path, help="ends in .csv, .json or .parquet (CSV to standard output)"
    )
    add_json(parser, "print one JSON list")
    parser.set_defaults(function=_export)


def _add_file(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="the file of an experiment, YAML or JSON")
    parser.add_argument(
        "--variant", action="append", default=[], metavar="NAME", help="apply a variant of the file; repeatable"
    )


def _add_results(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", metavar="DIR", type=Path, help="the folder of an experiment's results")


def _status(args: argparse.Namespace) -> int:
    from hmrsim.experiments.store import Results

    with Results(args.results) as results:
        about, endings = results.about, results.count("ending")
    done = sum(endings.values())
    cells = about["scenarios"] * len(about["treatments"])
    least, most = (cells * about["replications"][key] for key in ("min", "max"))
    if about["replications"]["until"] is None:
        least = most
    runs = f"{most:,}" if least == most else f"{least:,} to {most:,}"
    lines = [f"{about['name']}: {done:,} of {runs} runs have a result"]
    lines += [f"  {ending}: {count:,}" for ending, count in endings.items()]
    facts = {"name": about["name"], "done": done, "min": least, "max": most, "endings": endings}
    show_result(facts, lines, as_json=args.json)
    return ExitCode.DONE


def _show(args: argparse.Namespace) -> int:
    from hmrsim.experiments.store import Results

    with Results(args.results) as results:
        if args.run is not None:
            return _show_run(args, results)
        about = results.about
        if args.file:
            show(about["text"].rstrip("\n"))
            return ExitCode.DONE
        groups = _groups(results, args)
        columns = ["number", "treatment", *about["factors"], "ending", "cause"]
        failed = [*results.rows(columns, {"success": 0})]
    if args.json:
        show_json({"name": about["name"], "treatments": [_values(group) for group in groups]})
        return ExitCode.DONE
    headings = (*args.by, "treatment", "runs", "success", *about["measures"])
    show_table(headings, (_row(group, about["measures"]) for group in groups), left=(*args.by, "treatment"))
    for note in _notes(groups):
        show(printable(note))
    for row in failed[:_MAX_FAILED]:
        cause = f": {row['cause']}" if row["cause"] else ""
        levels = "".join(f", {factor} {row[factor]}" for factor in about["factors"])
        show(printable(f"run {row['number']} ({row['treatment']}{levels}) {row['ending']}{cause}"))
        show(f"  hmrsim experiment again {args.results} {row['number']} --trace run_{row['number']}.jsonl")
    if len(failed) > _MAX_FAILED:
        show(f"… and {len(failed) - _MAX_FAILED} more without success; see `hmrsim experiment export {args.results}`")
    return ExitCode.DONE


def _export(args: argparse.Namespace) -> int:
    from hmrsim.experiments.store import FILE, Results
    from hmrsim.experiments.table import write_csv, write_json, write_table

    with Results(args.results) as results:
        if args.output is None:
            write_json(results, sys.stdout) if args.json else write_csv(results, sys.stdout)
        else:
            check_outputs([("--output", args.output)], [args.results / FILE])
            write_table(results, args.output)
    return ExitCode.DONE


def _groups(results: Results, args: argparse.Namespace) -> list[Group]:
    from hmrsim.experiments.table import groups_by

    try:
        return groups_by(results, args.by)
    except ValueError as error:
        raise WrongUse(f"--by: {error}") from None


def _show_run(args: argparse.Namespace, results: Results) -> int:
    from hmrsim.experiments.store import TRACES

    row = next(results.rows(where={"number": args.run}), None)
    if row is None:
        raise ResultsError(f"{args.results}: there is no run {args.run}; `hmrsim experiment status` tells how many are")
    trace = args.results / TRACES / f"{args.run}.jsonl"
    if args.json:
        show_json({**row, "trace": str(trace) if trace.is_file() else None})
        return ExitCode.DONE
    for name, value in row.items():
        if name == "output":
            lines = "\n".join(f"  {printable(line)}" for line in str(value).splitlines())
            show(f"output:\n{lines}")
        else:
            show(printable(f"{name}: {value}"))
    if trace.is_file():
        show(f"trace: {trace}")
    show(f"again: hmrsim experiment again {args.results} {args.run} --trace run_{args.run}.jsonl")
    return ExitCode.DONE


def _row(group: Group, measures: Iterable[str]) -> tuple[str, ...]:
    levels, means = map(str, group.levels.values()), (_interval(group.mean(measure)) for measure in measures)
    return *levels, group.name, f"{group.runs:,}", _interval(group.rate(), share=True), *means


def _notes(groups: list[Group]) -> Iterator[str]:
    """Yield notes about means and intervals that may not be what the user expects."""
    from hmrsim.experiments.repeats import note_of

    for name in dict.fromkeys(group.name for group in groups):
        own = [group for group in groups if group.name == name]
        if note := note_of(sum(group.runs for group in own), sum(group.count for group in own)):
            yield f"{name}: {note}"
        failed = sum((group.failed for group in own), Counter[str]())
        if failed:
            counts = ", ".join(f"{count:,} of {measure}" for measure, count in sorted(failed.items()))
            yield f"{name}: means include values of runs without success: {counts}"


def _interval(interval: Interval, *, share: bool = False) -> str:
    """Return an estimate with its 95 % interval."""
    from hmrsim.report.html import UNKNOWN

    if interval.estimate is None:
        return UNKNOWN
    form = ".1%" if share else ".4g"
    if interval.low is None or interval.high is None:
        return format(interval.estimate, form)
    return f"{interval.estimate:{form}} [{interval.low:{form}}, {interval.high:{form}}]"


def _values(group: Group) -> dict[str, Any]:
    means = {measure: {**_plain(group.mean(measure)), "failed": group.failed[measure]} for measure in group.values}
    return {
        "name": group.name,
        **({"levels": dict(group.levels)} if group.levels else {}),
        "runs": group.runs,
        "count": group.count,
        "success": _plain(group.rate()),
        "endings": dict(group.endings),
        "measures": means,
    }


def _plain(interval: Interval) -> dict[str, Any]:
    return {"estimate": interval.estimate, "low": interval.low, "high": interval.high, "n": interval.n}


def _report(args: argparse.Namespace) -> int:
    from hmrsim.experiments.report import page_of, summary_of
    from hmrsim.experiments.store import FILE, Results

    if args.json and args.output == STDOUT:
        raise WrongUse("hmrsim experiment report: -o - and --json both write to the standard output; give -o a file")
    output = args.output or (None if args.json else str(args.results / _PAGE))
    check_outputs([("-o", output)], [args.results / f"{FILE}{end}" for end in ("", "-wal", "-shm")])
    with Results(args.results) as results:
        summary = summary_of(results)
    if output is not None:
        page = page_of(summary, shlex.quote(str(args.results)))
        if output == STDOUT:
            show(page)
            return ExitCode.DONE
        write_text("-o", Path(output), page)
        if not args.json:
            show(f"page: {output}")
    if args.json:
        show_json(summary.model_dump(mode="json"))
    return ExitCode.DONE

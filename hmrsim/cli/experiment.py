"""``hmrsim experiment``: many runs of one world, with factors, measures and comparisons."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hmrsim.cli.options import add_json, jobs
from hmrsim.program.command_line import Later, add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser


def configure(parser: LazyParser) -> None:
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
    code: int = Later("hmrsim.cli.experiment_runs", "run")(args)
    return code


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
    parser.set_defaults(function=Later("hmrsim.cli.experiment_results", "status"))


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
    parser.set_defaults(function=Later("hmrsim.cli.experiment_results", "show_results"))


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
    parser.set_defaults(function=Later("hmrsim.cli.experiment_results", "report"))


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
    parser.set_defaults(function=Later("hmrsim.cli.experiment_results", "export"))


def _add_file(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="the file of an experiment, YAML or JSON")
    parser.add_argument(
        "--variant", action="append", default=[], metavar="NAME", help="apply a variant of the file; repeatable"
    )


def _add_results(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("results", metavar="DIR", type=Path, help="the folder of an experiment's results")

"""``hmrsim check``: find the faults that break a controller, and shrink them to a minimal reproducer."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.exits import WrongUse
from hmrsim.cli.options import add_json, count, jobs
from hmrsim.program.log_options import add_log_options

CONTROLLERS: Final = ("tree", "python", "command")
"""The options that name a controller, of which only one is given."""
_SET_HELP: Final = "a change of the world, such as robots.*.base.speed=0.5; repeatable"


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
  hmrsim check --repro results/failures/mission_ends_it_does_not_end.yaml
  hmrsim check --trace run.jsonl --properties properties.yaml"""
    parser.add_argument(
        "world", metavar="WORLD", nargs="?", help="a world, or the file of a check, which contains everything else"
    )
    what = parser.add_argument_group("subject")
    what.add_argument("--tree", metavar="TREE", help="a behaviour tree: FILE.xml, MODULE:FUNCTION or FILE.py:FUNCTION")
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
    search.add_argument("--at-most", metavar="N", type=count, help="the maximum number of things in one schedule (3)")
    search.add_argument("--only", metavar="KIND", nargs="+", help="the kinds of things to try (all)")
    search.add_argument("--without", metavar="KIND", nargs="+", help="kinds of things to leave out")
    search.add_argument("--also", metavar="KIND", nargs="+", help="item_lost, second_controller, simulation_reset")
    search.add_argument("--spare", metavar="NAME", nargs="+", help="robots, doors, … to leave undisturbed")
    search.add_argument("--first", action="store_true", help="stop at the first failure")
    search.add_argument("-j", "--jobs", metavar="N", type=jobs, help="processes at once (one a processor)")
    search.add_argument("--executor", metavar="WHERE", default="pool", help="as of `hmrsim experiment run` (pool)")
    other = parser.add_argument_group("instead of a search")
    other.add_argument("--repro", metavar="FILE", type=Path, help="repeat a failure that was found")
    other.add_argument("--folder", metavar="DIR", type=Path, help="the folder of the controller's files, for --repro")
    other.add_argument("--record", metavar="FILE.mcap", type=Path, help="record the run of --repro")
    other.add_argument("--trace", metavar="TRACE", type=Path, help="apply properties to a trace or a recording")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="the folder of the results (NAME_check)")
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
    controllers = [f"--{name}" for name in CONTROLLERS if getattr(args, name) is not None]
    if option and controllers:
        raise WrongUse(f"{option}: its file says what was run; leave out {', '.join(controllers)}")
    if args.trace is not None:
        from hmrsim.cli.check_trace import check_trace

        return check_trace(args)
    if args.repro is not None:
        from hmrsim.cli.check_repro import repeat

        return repeat(args)
    from hmrsim.cli.check_search import search

    return search(args)

"""``hmrsim check``: find the schedule of faults that breaks a controller, and shrink it to the smallest one."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import WrongUse
from hmrsim.cli.options import count, jobs
from hmrsim.program.command_line import Later
from hmrsim.program.log_options import add_log_options

if TYPE_CHECKING:
    from collections.abc import Callable

_EXAMPLES: Final = """\
exit codes: 0 no property was violated; 1 one was; 2 wrong use or unreadable input; 130 Ctrl-C, with what was found

examples:
  hmrsim check hospital --tree bt_controller.examples.hospital:mission --budget 1m
  hmrsim check my_world.yaml --tree mission.xml --properties properties.yaml -o results
  hmrsim check hospital --command './my_fleet_manager --robots all' --runs 500
  hmrsim check check.yaml
  hmrsim check --repro results/failures/mission_ends_it_does_not_end.yaml
  hmrsim check --trace run.jsonl --properties properties.yaml"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim check``."""
    parser.description = (
        "Search for what breaks a controller: run it again and again with faults, changes of the world and\n"
        "disturbances of the wire, until a property is violated; then shrink that to the smallest schedule, and\n"
        "write a file that repeats it. Or apply properties to a trace or a recording."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "world", metavar="WORLD", nargs="?", help="a world, or the file of a check, which has all that follows"
    )
    what = parser.add_argument_group("what is checked")
    what.add_argument("--tree", metavar="TREE", help="a behaviour tree: FILE.xml, MODULE:FUNCTION or FILE.py:FUNCTION")
    what.add_argument("--python", metavar="FUNCTION", help="a function that is given a client: MODULE:FUNCTION")
    what.add_argument("--command", metavar="COMMAND", help="any program, over Zenoh; started for each run")
    what.add_argument("--robots", metavar="NAME", nargs="+", help="the robots of a tree (all)")
    what.add_argument("--properties", metavar="FILE", help="the properties that have to hold, beside the built-in ones")
    what.add_argument("--set", dest="changes", metavar="PATH=VALUE", action="append", default=[], help=_SET)
    search = parser.add_argument_group("how it is searched")
    search.add_argument("--budget", metavar="TIME", help="how long: 90s, 10m, 1h (10m)")
    search.add_argument("--runs", metavar="N", type=count, help="at most so many runs")
    search.add_argument("--seed", metavar="N", type=int, help="the seed of the search (0)")
    search.add_argument("--at-most", metavar="N", type=count, help="things in one schedule (3)")
    search.add_argument("--only", metavar="KIND", nargs="+", help="the kinds of things that happen (all)")
    search.add_argument("--without", metavar="KIND", nargs="+", help="kinds that do not happen")
    search.add_argument("--also", metavar="KIND", nargs="+", help="item_lost, second_controller, simulation_reset")
    search.add_argument("--spare", metavar="NAME", nargs="+", help="robots, doors, … to which nothing happens")
    search.add_argument("--first", action="store_true", help="end with the first failure")
    search.add_argument("-j", "--jobs", metavar="N", type=jobs, help="processes at once (one a processor)")
    search.add_argument("--executor", metavar="WHERE", default="pool", help="as of `hmrsim experiment run` (pool)")
    other = parser.add_argument_group("instead of a search")
    other.add_argument("--repro", metavar="FILE", type=Path, help="repeat a failure that was found")
    other.add_argument("--folder", metavar="DIR", type=Path, help="where the controller's files are, for --repro")
    other.add_argument("--record", metavar="FILE.mcap", type=Path, help="record the run of --repro")
    other.add_argument("--trace", metavar="TRACE", type=Path, help="apply properties to a trace or a recording")
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help="the folder of the results (NAME_check)")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")
    add_log_options(parser)
    parser.set_defaults(function=_chosen)


_SET: Final = "a change of the world, such as robots.*.base.speed=0.5; repeatable"


CONTROLLERS: Final = ("tree", "python", "command")
"""The options of which one says what is checked."""


def _chosen(args: argparse.Namespace) -> int:
    """Do what is asked for; return the exit code."""
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
        module, function = "check_trace", "check_trace"
    elif args.repro is not None:
        module, function = "check_repro", "repeat"
    else:
        module, function = "check_search", "search"
    later: Callable[[argparse.Namespace], int] = Later(f"hmrsim.cli.{module}", function)
    return later(args)

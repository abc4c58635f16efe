"""``hmrsim map``: list, create, check, inspect, convert and draw worlds, and plan routes on them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Final

from hmrsim.cli.options import ExitCode, add_json, add_world_options, positive
from hmrsim.cli.output import counted, show_result
from hmrsim.errors import WorldError
from hmrsim.program.command_line import Later, add_commands

if TYPE_CHECKING:
    from hmrsim.errors import Problem
    from hmrsim.program.command_line import LazyParser


_NEW: Final = "hmrsim.cli.map_new"


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim map``."""
    parser.description = "List, create, check, inspect, convert and draw worlds; plan routes on them."
    parser.epilog = """\
examples:
  hmrsim map list
  hmrsim map new my_world.yaml && hmrsim run my_world.yaml
  hmrsim map validate my_world.yaml
  hmrsim map info hospital
  hmrsim map plan hospital wall_e pharmacy
  hmrsim map convert drawing.drawio my_world.yaml
  hmrsim map render hospital -o hospital.svg"""
    add_commands(
        parser,
        {
            "list": ("list the shipped worlds", Later(_NEW, "configure_list")),
            "new": ("write a commented starter world", Later(_NEW, "configure_new")),
            "generate": ("write a small random fleet with orders", Later(_NEW, "configure_generate")),
            "schema": ("print the schema of world files, for editors", Later(_NEW, "configure_schema")),
            "validate": ("list all errors in a world file", _configure_validate),
            "info": ("show the contents of a world file", _configure_info),
            "plan": ("print the route between two points, and its travel time", _configure_plan),
            "convert": ("write a world in another format", _configure_convert),
            "render": ("draw a world as SVG or PNG", _configure_render),
        },
    )


def _configure_validate(parser: argparse.ArgumentParser) -> None:
    parser.description = "List everything that is wrong with a world file, and what looks odd."
    parser.epilog = """\
exit codes: 0 no errors, maybe warnings; 1 errors; 2 the file, or an option, can't be read

examples:
  hmrsim map validate my_world.yaml
  hmrsim map validate my_world.yaml --traffic
  hmrsim map validate my_world.yaml --json | jq -r '.[].message'"""
    add_world_options(parser, argument="file")
    parser.add_argument(
        "--traffic",
        action="store_true",
        help="also warn of places and initial positions where robots block others under the traffic policy, of"
        " corridors where they deadlock, and of too few places to wait",
    )
    add_json(parser, "print one JSON list")
    parser.set_defaults(function=_validate)


def _configure_info(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Show the contents of a world file, and what its lanes mean for traffic: bottlenecks, places that can't be"
        " reached, the longest and shortest trips, and where traffic will concentrate."
    )
    parser.epilog = """\
examples:
  hmrsim map info hospital
  hmrsim map info drawing.drawio --json | jq '.counts, .parts'
  hmrsim map info a.yaml --json | jq -r .hash
  hmrsim map info warehouse --json | jq '.network.bottlenecks.worst[0]'"""
    add_world_options(parser, argument="file")
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.map_info", "info"))


def _configure_plan(parser: argparse.ArgumentParser) -> None:
    parser.description = "Print the quickest route from one point to another, each of its legs, and its travel time."
    parser.epilog = """\
exit codes: 0 there is a route; 1 there is none, or no such name; 2 the file can't be read

examples:
  hmrsim map plan hospital wall_e pharmacy
  hmrsim map plan hospital lab 39,6.5 --for eve
  hmrsim map plan my_world.yaml home -3,4 --speed 0.8 --json | jq .length"""
    add_world_options(parser, argument="file")
    where = "X,Y, or the name of a waypoint, place, dock, robot or item"
    parser.add_argument("start", metavar="FROM", help=where)
    parser.add_argument("goal", metavar="TO", help=where)
    who = parser.add_mutually_exclusive_group()
    who.add_argument(
        "--for", dest="driver", metavar="ROBOT", help="the robot that drives (default: FROM, if that is a robot)"
    )
    who.add_argument(
        "--speed",
        type=positive,
        metavar="V",
        help="the maximum speed, in the world's unit per second (default: the world's default speed)",
    )
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.map_plan", "plan"))


def _configure_convert(parser: argparse.ArgumentParser) -> None:
    parser.epilog = """\
OUT's suffix chooses the format: .yaml or .json is a native world, which holds everything; .geojson is the route graph
of Nav2's Route Server. Anything that OUT can't hold is reported on stderr. Files that IN includes are
merged in.

examples:
  hmrsim map convert drawing.drawio world.yaml
  hmrsim map convert office.building.yaml office.geojson
  hmrsim map convert arena.map arena.yaml --neighbours 4
  hmrsim map convert hospital hospital.geojson --force
  hmrsim map convert scenario1 - --to geojson | jq '.features | length'"""
    add_world_options(parser, argument="in")
    parser.add_argument("out", metavar="OUT", help="the file to write, or - for stdout")
    parser.add_argument(
        "--to",
        choices=("yaml", "json", "geojson"),
        help="the format (default: that of OUT's suffix; yaml for -)",
    )
    parser.add_argument("--force", action="store_true", help="overwrite OUT")
    add_json(parser, "print one JSON object about what was written")
    parser.set_defaults(function=Later("hmrsim.cli.map_export", "convert"))


def _configure_render(parser: argparse.ArgumentParser) -> None:
    parser.description = "Draw a world: walls and lanes, places and docks, robots and items as they are at the start."
    parser.epilog = """\
OUT's suffix chooses the format: .svg, or .png, which needs the extra `png` (pip install 'hmrsim[png]'). Without -o the
picture is SVG on stdout. Names are omitted where there is no room for them; a viewer shows them, and more, as
tooltips. The same world gives the same SVG, byte for byte.

examples:
  hmrsim map render hospital -o hospital.svg
  hmrsim map render warehouse -o warehouse.png --theme dark --width 1600
  hmrsim map render office.building.yaml --page L1 --details > office.svg
  hmrsim map render warehouse --bottlenecks -o traffic.svg
  hmrsim map render arena.map --robot wall_e@3,4 --no-legend -o arena.svg"""
    add_world_options(parser)
    parser.add_argument("-o", "--output", default="-", metavar="OUT", help="the file to write (SVG on stdout)")
    parser.add_argument("--theme", choices=("light", "dark"), default="light", help="colors (light)")
    parser.add_argument(
        "--width",
        type=Later("hmrsim.cli.map_export", "width"),
        default=1200,
        metavar="N",
        help="width in pixels (1200)",
    )
    parser.add_argument(
        "--scale",
        type=Later("hmrsim.cli.map_export", "scale"),
        default=2.0,
        metavar="N",
        help="pixels of a PNG per pixel of the drawing, in each direction (2)",
    )
    parser.add_argument("--no-names", action="store_true", help="write no names")
    parser.add_argument(
        "--no-legend", action="store_true", help="draw the map only, without title, scale bar and legend"
    )
    parser.add_argument("--details", action="store_true", help="write speed limits and capacities beside lanes")
    parser.add_argument(
        "--bottlenecks",
        action="store_true",
        help="draw where traffic concentrates, and the waypoints, lanes and lifts that alone connect parts",
    )
    parser.set_defaults(function=Later("hmrsim.cli.map_export", "render"))


def _validate(args: argparse.Namespace) -> int:
    from hmrsim.cli.worlds import policy_line, read_world
    from hmrsim.world_checks.lanes import check_crossings

    checks = [check_crossings]
    if args.traffic:
        from hmrsim.world_checks.forecast import forecast
        from hmrsim.world_checks.obstructions import check_obstructions

        checks += [check_obstructions, forecast]
    try:
        loaded = read_world(args, argument="file", further=checks)
        problems, policy, code = loaded.warnings, policy_line(loaded.world), ExitCode.DONE
    except WorldError as error:
        misused = any(_is_wrong_use(problem) for problem in error.problems) or not _is_readable(args)
        problems, policy, code = error.problems, "", ExitCode.WRONG_USE if misused else ExitCode.FAILED
    show_result([_plain(problem) for problem in problems], _lines(problems, policy), as_json=args.json)
    return code


def _is_wrong_use(problem: Problem) -> bool:
    """Return whether a problem is an unreadable option, rather than an option that does not fit the file."""
    return problem.file.startswith("--") and not problem.path


def _is_readable(args: argparse.Namespace) -> bool:
    """Return whether the file exists and has a known format, whatever its content."""
    from hmrsim.settings.arguments import read_settings
    from hmrsim.settings.run import WorldSettings
    from hmrsim.world.files import ReadOptions, find
    from hmrsim.world.includes import read_document

    try:
        read_document(find(args.file), args.file, ReadOptions(page=read_settings(args, WorldSettings).page))
    except WorldError:
        return False
    return True


def _lines(problems: Sequence[Problem], policy: str) -> Iterator[str]:
    from hmrsim.cli.worlds import line_of

    yield from map(line_of, problems)
    if policy:
        yield policy
    errors = sum(problem.severity == "error" for problem in problems)
    yield f"{counted(errors, 'errors')}, {counted(len(problems) - errors, 'warnings')}"


def _plain(problem: Problem) -> dict[str, object]:
    """Return a problem as JSON values; a value that JSON can't hold is given as its Python representation."""
    value = problem.value
    finite = not isinstance(value, float) or value - value == 0
    plain = isinstance(value, (str, int, float, bool, type(None))) and finite
    return {**asdict(problem), "value": value if plain else repr(value)}

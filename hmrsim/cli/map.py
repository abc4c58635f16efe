"""``hmrsim map``: list, create, check, inspect, convert and draw worlds, and plan routes on them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.options import ExitCode, WrongUse, add_json, add_world_options, number_in, positive, whole_in
from hmrsim.cli.output import check_target, columns, counted, show, show_result, warn, write_whole
from hmrsim.errors import WorldError
from hmrsim.program.command_line import Later, add_commands
from hmrsim.settings.option import MAX_COUNT

if TYPE_CHECKING:
    from hmrsim.errors import Problem
    from hmrsim.program.command_line import CommandParser


_SCHEMA: Final = "world.schema.json"
"""The name of the schema's file beside a world."""
_TEMPLATE: Final = Path(__file__).with_name("map_new.yaml")
_FEWEST: Final = 2
_MOST: Final = 30
"""Limits of the number of robots in a random fleet."""
_SEEDS: Final = 25
"""Number of seeds that --solvable tries."""
_SEED: Final = whole_in(0, MAX_COUNT, f"a seed; expected a whole number from 0 to {MAX_COUNT}")
_ROBOTS: Final = whole_in(_FEWEST, _MOST, f"a number of robots; expected a whole number from {_FEWEST} to {_MOST}")
_MIN_WIDTH: Final = 100
_MAX_WIDTH: Final = 20_000
"""Limits of the width of a picture in pixels."""
_MAX_SCALE: Final = 8.0


def configure(parser: CommandParser) -> None:
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
            "list": ("list the shipped worlds", _configure_list),
            "new": ("write a commented starter world", _configure_new),
            "generate": ("write a small random fleet with orders", _configure_generate),
            "schema": ("print the schema of world files, for editors", _configure_schema),
            "validate": ("list all errors in a world file", _configure_validate),
            "info": ("show the contents of a world file", _configure_info),
            "plan": ("print the route between two points, and its travel time", _configure_plan),
            "convert": ("write a world in another format", _configure_convert),
            "render": ("draw a world as SVG or PNG", _configure_render),
        },
    )


def _configure_list(parser: argparse.ArgumentParser) -> None:
    parser.description = "List the shipped worlds, whose names can be used for WORLD in every command."
    parser.epilog = "examples:\n  hmrsim map list\n  hmrsim map list --json | jq -r '.cafe.file'"
    add_json(parser, "print one JSON object: a world's text and file, by name")
    parser.set_defaults(function=_list)


def _list(args: argparse.Namespace) -> int:
    from hmrsim.world.files import shipped_maps

    worlds = {name: {"text": _first_sentence(path), "file": str(path)} for name, path in shipped_maps().items()}
    show_result(worlds, columns([(name, world["text"]) for name, world in worlds.items()]), as_json=args.json)
    return ExitCode.DONE


def _first_sentence(path: Path) -> str:
    """Return the first sentence of the comment at the beginning of a world file, without the dot."""
    lines = [line.removeprefix("#").strip() for line in path.read_text(encoding="utf-8").splitlines()[1:]]
    comment = lines[: next(number for number, line in enumerate(lines) if line.startswith("name:"))]
    return " ".join(comment).strip().partition(". ")[0].removesuffix(".")


def _configure_new(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write a starter world: two rooms, a robot that carries things, and a comment on each part. The schema "
        f"is written beside it, as {_SCHEMA}, so that editors complete keys and mark errors."
    )
    parser.epilog = """\
examples:
  hmrsim map new my_world.yaml
  hmrsim map validate my_world.yaml && hmrsim run my_world.yaml --view"""
    parser.add_argument("file", metavar="FILE", type=_world_file, help="the file to write")
    parser.add_argument("--force", action="store_true", help="overwrite FILE")
    parser.set_defaults(function=_new)


def _world_file(text: str) -> Path:
    path = Path(text)
    if path.suffix not in (".yaml", ".yml"):
        raise argparse.ArgumentTypeError(f"{text}: a world is YAML; expected a name that ends in .yaml")
    return path


def _new(args: argparse.Namespace) -> int:
    check_target(args.file, force=args.force)
    write_whole(args.file, _TEMPLATE.read_bytes().replace(b"NAME", args.file.stem.encode()))
    _write_schema(args.file)
    show(f"{args.file}: a world to begin with; `hmrsim run {args.file} --view` shows it")
    return ExitCode.DONE


def _write_schema(file: Path) -> None:
    """Write the schema beside a world, unless it is already there."""
    schema = file.with_name(_SCHEMA)
    if not schema.exists():
        write_whole(schema, _shipped_schema().read_bytes())


def _shipped_schema() -> Path:
    from hmrsim.world.files import folder

    return folder("schemas") / _SCHEMA


def _configure_schema(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Print the JSON Schema of world files. An editor with support for YAML finds it by the first line of a world: "
        "# yaml-language-server: $schema=world.schema.json"
    )
    parser.epilog = "examples:\n  hmrsim map schema > world.schema.json"
    parser.set_defaults(function=_schema)


def _schema(_args: argparse.Namespace) -> int:
    show(_shipped_schema().read_text(encoding="utf-8").rstrip("\n"))
    return ExitCode.DONE


def _configure_generate(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write a small random fleet with orders to deliver, to try a dispatcher on: single tracks, rings, dead ends, "
        "doors or a lift, robots of several types that start anywhere. With FILE, the schema is written beside it, "
        f"as {_SCHEMA}."
    )
    parser.epilog = """\
The same seed and number of robots give the same world in this version of hmrsim; another version may draw another one.

examples:
  hmrsim map generate fleet.yaml --seed 7 --solvable && hmrsim run fleet.yaml --view
  hmrsim map generate --seed 3 --robots 6 | less"""
    parser.add_argument("file", metavar="FILE", nargs="?", type=_world_file, help="the file to write (default: stdout)")
    parser.add_argument("--seed", metavar="N", type=_SEED, default=0, help="the seed of all random choices (0)")
    parser.add_argument(
        "--robots", metavar="N", type=_ROBOTS, help=f"number of robots, {_FEWEST} to {_MOST} (5 to 12 at random)"
    )
    parser.add_argument(
        "--solvable",
        action="store_true",
        help=f"use the first of {_SEEDS} seeds from N for which a search can deliver all orders",
    )
    parser.add_argument("--force", action="store_true", help="overwrite FILE")
    parser.set_defaults(function=_generate)


def _generate(args: argparse.Namespace) -> int:
    from hmrsim.random_fleets.generator import header, random_fleet, to_text

    if args.file is not None:
        check_target(args.file, force=args.force)
    elif args.force:
        raise WrongUse("--force overwrites a file; name FILE, or leave --force out")
    seed, robots = args.seed, args.robots
    if args.solvable:
        seed = _solvable_seed(seed, robots)
    data = random_fleet(seed, robots)
    text = to_text(data, header(seed, robots), schema=_SCHEMA if args.file is not None else None)
    if args.file is None:
        show(text.rstrip("\n"))
        return ExitCode.DONE
    write_whole(args.file, text.encode())
    _write_schema(args.file)
    orders = sum(demand["count"] for demand in data["demand"])
    show(f"{args.file}: {len(data['robots'])} robots, {orders} orders, seed {seed}; `hmrsim run {args.file} --view`")
    return ExitCode.DONE


def _solvable_seed(first: int, robots: int | None) -> int:
    """Return the first seed, from *first* on, whose fleet is known to be able to deliver its orders."""
    from hmrsim.random_fleets.generator import random_fleet
    from hmrsim.random_fleets.oracle import solve
    from hmrsim.world.model import World

    answers: list[str] = []
    for seed in range(first, first + _SEEDS):
        answer = solve(World.model_validate(random_fleet(seed, robots)), any_robot=False).answer
        if answer == "solvable":
            if answers:
                warn(f"{_named(first, seed)} not known to be solvable; using seed {seed}")
            return seed
        answers.append(answer)
    unknown = answers.count("unknown")
    raise WrongUse(
        f"--solvable: {_named(first, first + _SEEDS)} not known to be solvable: {_SEEDS - unknown} unsolvable, "
        f"{unknown} where the search was given up; try another --seed or fewer --robots"
    )


def _named(first: int, end: int) -> str:
    """Return the subject of a sentence about the seeds from *first* to before *end*."""
    return f"seed {first} is" if end == first + 1 else f"seeds {first} to {end - 1} are"


def _configure_validate(parser: argparse.ArgumentParser) -> None:
    parser.description = "List everything that is wrong with a world file, and what looks odd."
    parser.epilog = """\
exit codes: 0 no errors, maybe warnings; 1 errors; 2 the file, or an option, can't be read

examples:
  hmrsim map validate my_world.yaml
  hmrsim map validate my_world.yaml --traffic
  hmrsim map validate my_world.yaml --json | jq -r '.[].message'"""
    add_world_options(parser, metavar="FILE")
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
    add_world_options(parser, metavar="FILE")
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
    add_world_options(parser, metavar="FILE")
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
    add_world_options(parser, metavar="IN")
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
        type=whole_in(_MIN_WIDTH, _MAX_WIDTH, f"a whole number from {_MIN_WIDTH} to {_MAX_WIDTH}"),
        default=1200,
        metavar="N",
        help="width in pixels (1200)",
    )
    parser.add_argument(
        "--scale",
        type=number_in(0.0, _MAX_SCALE, f"a number above 0, up to {_MAX_SCALE:g}"),
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
        loaded = read_world(args, further=checks)
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
        read_document(find(args.world), args.world, ReadOptions(page=read_settings(args, WorldSettings).page))
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

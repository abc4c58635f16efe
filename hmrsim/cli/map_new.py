"""``hmrsim map list``, ``new``, ``generate`` and ``schema``: the shipped worlds, new ones, and their schema."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Final

from hmrsim.cli.options import ExitCode, WrongUse, add_json
from hmrsim.cli.output import check_target, columns, show, show_result, warn, write_whole
from hmrsim.settings.option import MAX_COUNT, shortened

SCHEMA: Final = "world.schema.json"
"""The name of the schema's file beside a world."""
_TEMPLATE: Final = Path(__file__).with_name("map_new.yaml")

_FEWEST: Final = 2
_MOST: Final = 30
"""Limits of the number of robots in a random fleet."""
_SEEDS: Final = 25
"""Number of seeds that --solvable tries."""


def configure_list(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map list``."""
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


def configure_new(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map new``."""
    parser.description = (
        "Write a starter world: two rooms, a robot that carries things, and a comment on each part. The schema "
        f"is written beside it, as {SCHEMA}, so that editors complete keys and mark errors."
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
    schema = file.with_name(SCHEMA)
    if not schema.exists():
        write_whole(schema, _shipped_schema().read_bytes())


def _shipped_schema() -> Path:
    from hmrsim.world.files import folder

    return folder("schemas") / SCHEMA


def configure_schema(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map schema``."""
    parser.description = (
        "Print the JSON Schema of world files. An editor with support for YAML finds it by the first line of a world: "
        "# yaml-language-server: $schema=world.schema.json"
    )
    parser.epilog = "examples:\n  hmrsim map schema > world.schema.json"
    parser.set_defaults(function=_schema)


def _schema(_args: argparse.Namespace) -> int:
    show(_shipped_schema().read_text(encoding="utf-8").rstrip("\n"))
    return ExitCode.DONE


def configure_generate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim map generate``."""
    parser.description = (
        "Write a small random fleet with orders to deliver, to try a dispatcher on: single tracks, rings, dead ends, "
        "doors or a lift, robots of several types that start anywhere. With FILE, the schema is written beside it, "
        f"as {SCHEMA}."
    )
    parser.epilog = """\
The same seed and number of robots give the same world in this version of hmrsim; another version may draw another one.

examples:
  hmrsim map generate fleet.yaml --seed 7 --solvable && hmrsim run fleet.yaml --view
  hmrsim map generate --seed 3 --robots 6 | less"""
    parser.add_argument("file", metavar="FILE", nargs="?", type=_world_file, help="the file to write (default: stdout)")
    parser.add_argument("--seed", metavar="N", type=_seed, default=0, help="the seed of all random choices (0)")
    parser.add_argument(
        "--robots", metavar="N", type=_robots, help=f"number of robots, {_FEWEST} to {_MOST} (5 to 12 at random)"
    )
    parser.add_argument(
        "--solvable",
        action="store_true",
        help=f"use the first of {_SEEDS} seeds from N for which a search can deliver all orders",
    )
    parser.add_argument("--force", action="store_true", help="overwrite FILE")
    parser.set_defaults(function=_generate)


def _seed(text: str) -> int:
    if not text.isdecimal() or len(text) > len(str(MAX_COUNT)) or int(text) > MAX_COUNT:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)!r} is not a seed; expected a whole number from 0 to {MAX_COUNT}"
        )
    return int(text)


def _robots(text: str) -> int:
    if not text.isdecimal() or len(text) > len(str(_MOST)) or not _FEWEST <= int(text) <= _MOST:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)!r} is not a number of robots; expected a whole number from {_FEWEST} to {_MOST}"
        )
    return int(text)


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
    text = to_text(data, header(seed, robots), schema=SCHEMA if args.file is not None else None)
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

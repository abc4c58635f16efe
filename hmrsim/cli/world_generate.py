"""``hmrsim world generate``: a small random fleet with orders."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import check_target, show, warn, write_whole
from hmrsim.cli.world_new import SCHEMA, world_file, write_schema
from hmrsim.random_fleets.generator import header, random_fleet, to_text
from hmrsim.random_fleets.oracle import solve
from hmrsim.settings.option import MAX_COUNT, shortened
from hmrsim.world.model import World

if TYPE_CHECKING:
    from hmrsim.random_fleets.oracle import Verdict

_FEWEST: Final = 2
_MOST: Final = 30

_SEEDS: Final = 25
"""Seeds that --solvable tries."""

_EXAMPLES: Final = """\
The same seed and number of robots give the same world in this version of hmrsim; another version may draw another one.

examples:
  hmrsim world generate fleet.yaml --seed 7 --solvable && hmrsim run fleet.yaml --view
  hmrsim world generate --seed 3 --robots 6 | less"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim world generate``."""
    parser.description = (
        "Write a small random fleet with orders to deliver, to try a dispatcher on: single tracks, rings, dead ends, "
        "doors or a lift, robots of several types that start anywhere. With FILE, the schema is written beside it, "
        f"as {SCHEMA}."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("file", metavar="FILE", nargs="?", type=world_file, help="the file to write (default: stdout)")
    parser.add_argument("--seed", metavar="N", type=_seed, default=0, help="decides everything that is drawn (0)")
    parser.add_argument(
        "--robots", metavar="N", type=_robots, help=f"number of robots, {_FEWEST} to {_MOST} (5 to 12 at random)"
    )
    parser.add_argument(
        "--solvable",
        action="store_true",
        help=f"use the first of {_SEEDS} seeds from N on whose orders can all be delivered, as a search shows",
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
    write_schema(args.file)
    orders = sum(demand["count"] for demand in data["demand"])
    show(f"{args.file}: {len(data['robots'])} robots, {orders} orders, seed {seed}; `hmrsim run {args.file} --view`")
    return ExitCode.DONE


def _solvable_seed(first: int, robots: int | None) -> int:
    """Return the first seed whose fleet can surely serve its orders."""
    tried: list[Verdict] = []
    for seed in range(first, first + _SEEDS):
        verdict = solve(World.model_validate(random_fleet(seed, robots)), any_robot=False)
        if verdict.answer == "solvable":
            if tried:
                warn(f"{_named(first, seed)} not known to be solvable; using seed {seed}")
            return seed
        tried.append(verdict)
    unknown = sum(verdict.answer == "unknown" for verdict in tried)
    raise WrongUse(
        f"--solvable: {_named(first, first + _SEEDS)} not known to be solvable: {_SEEDS - unknown} unsolvable, "
        f"{unknown} where the search was given up; try another --seed or fewer --robots"
    )


def _named(first: int, end: int) -> str:
    """Return the subject of a sentence: the seeds from one on, without the last one."""
    return f"seed {first} is" if end == first + 1 else f"seeds {first} to {end - 1} are"

"""The options of every command that takes a WORLD: what to add to the file, and how to read it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.world import ReadOptions
from hmrsim.world.options import renames
from hmrsim.world_checks import load_world

if TYPE_CHECKING:
    import argparse

    from hmrsim.world_checks import LoadedWorld


def add_world_options(parser: argparse.ArgumentParser, *, argument: str = "world") -> None:
    """Give a command its WORLD and the options that go with it.

    Args:
        parser: Of the command.
        argument: What the world is called there.
    """
    parser.add_argument(
        argument, metavar=argument.upper(), help="a world file of any format, or the name of a shipped world"
    )
    group = parser.add_argument_group("world")
    group.add_argument(
        "--robot", action="append", default=[], metavar="NAME@X,Y[:TYPE]", help="add a robot; repeatable"
    )
    group.add_argument("--item", action="append", default=[], metavar="NAME@X,Y[:KG]", help="add an item; repeatable")
    group.add_argument(
        "--page",
        metavar="PAGE",
        help="the page of a drawing, the level of a building or the layout of a LIF file:"
        " its name, or its number from 1 (the first page; all levels, all layouts)",
    )
    group.add_argument(
        "--rename", action="append", default=[], metavar="OLD=NEW", help="rename a robot of a drawing; repeatable"
    )
    group.add_argument("--lenient", action="store_true", help="leave out objects of a drawing that have no known type")
    group.add_argument(
        "--neighbours", type=int, choices=(4, 8), help="whether cells of a grid touch at their corners, too (8)"
    )


def read_world(args: argparse.Namespace, *, argument: str = "world") -> LoadedWorld:
    """Read the world that a command line names, with what it adds.

    Raises:
        WorldError: Something is wrong with it.
    """
    options = ReadOptions(args.page, renames(args.rename), args.lenient, args.neighbours)
    return load_world(getattr(args, argument), add_robots=args.robot, add_items=args.item, options=options)

"""The settings for reading a world file, and for additions to it."""

from __future__ import annotations

from typing import Annotated, Literal

from hmrsim.settings.model import Settings
from hmrsim.settings.option import Option


class WorldSettings(Settings):
    """How a command reads its world."""

    robot: Annotated[tuple[str, ...], Option("add a robot; repeatable", "NAME@X,Y[:TYPE]", group="world")] = ()
    item: Annotated[tuple[str, ...], Option("add an item; repeatable", "NAME@X,Y[:KG]", group="world")] = ()
    overlay: Annotated[
        tuple[str, ...], Option("lay the changes of a file over the world; repeatable", "FILE", group="world")
    ] = ()
    set: Annotated[
        tuple[str, ...],
        Option(
            "change one value of the world, such as robots.*.base.speed=0.8; ~PATH takes an entry away; repeatable",
            "PATH=VALUE",
            group="world",
        ),
    ] = ()
    page: Annotated[
        str | None,
        Option(
            "the page of a drawing, the level of a building or the layout of a LIF file: its name, or its number from "
            "1 (the first page; all levels, all layouts)",
            "PAGE",
            group="world",
        ),
    ] = None
    rename: Annotated[tuple[str, ...], Option("rename a robot of a drawing; repeatable", "OLD=NEW", group="world")] = ()
    lenient: Annotated[bool, Option("ignore objects of a drawing without a known type", group="world")] = False
    neighbours: Annotated[
        Literal[4, 8] | None, Option("neighbours of a grid cell: 4, or 8 with those at its corners", group="world")
    ] = None

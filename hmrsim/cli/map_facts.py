"""What ``hmrsim map info`` does: it gathers what there is to know of a world, and prints it."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli import map_network
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.map_network_text import counted, lines
from hmrsim.cli.output import show, show_json
from hmrsim.cli.worlds import policy_line, read_world
from hmrsim.documents.document import read_text
from hmrsim.drawing import extent
from hmrsim.errors import printable
from hmrsim.geometry import distance
from hmrsim.world.formats import choose

if TYPE_CHECKING:
    from hmrsim.world import World
    from hmrsim.world_checks import LoadedWorld

_COUNTED: Final = (
    "waypoints",
    "lanes",
    "walls",
    "places",
    "docks",
    "doors",
    "lifts",
    "items",
    "robot_types",
    "robots",
    "faults",
)
_MAX_LINES: Final = 10
"""Maximum number of lines of each kind."""


def info(args: argparse.Namespace) -> int:
    """Print what is in the file that the options name; return the exit code."""
    loaded = read_world(args, argument="file")
    values = facts(loaded)
    if args.json:
        show_json(values)
    else:
        for line in _lines(values, policy_line(loaded.world)):
            show(printable(line))
    return ExitCode.DONE


def facts(loaded: LoadedWorld) -> dict[str, Any]:
    """Return the contents and statistics of a world, as plain values."""
    world = loaded.world
    network = map_network.facts(world)
    kind = choose(loaded.path.name, read_text(loaded.path, str(loaded.path)))
    return {
        "name": world.name,
        "file": str(loaded.path),
        "format": kind.name if kind else None,
        "units": world.units,
        "bounds": world.bounds,
        "extent": extent(world),
        "seed": world.seed,
        "hash": loaded.hash,
        "warnings": len(loaded.warnings),
        "traffic": {"policy": world.policy, "by_default": world.traffic.policy is None},
        "counts": {key: len(getattr(world, key)) for key in _COUNTED},
        "one_way_lanes": sum(lane.one_way for lane in world.lanes),
        "lane_length": math.fsum(distance(world.points[lane.from_], world.points[lane.to]) for lane in world.lanes),
        "parts": network.pop("parts"),
        "network": network,
        "robots": [_robot(world, name) for name in world.robots],
        "items": [{"name": name, "at": world.point(one.at), "weight": one.weight} for name, one in world.items.items()],
        "places": [{"name": name, "at": one.at} for name, one in world.places.items()],
        "docks": [
            {"name": name, **one.model_dump(), "at": world.dock_point(name)} for name, one in world.docks.items()
        ],
        "remap": world.remap,
    }


def _robot(world: World, name: str) -> dict[str, Any]:
    robot = world.robots[name]
    kind = world.robot_type(robot)
    return {
        "name": name,
        "type": robot.type,
        "components": list(kind.components),
        "speed": world.speed(kind.base),
        "at": world.point(robot.at),
        "yaw": robot.yaw,
        "script": len(robot.script),
    }


def _lines(values: dict[str, Any], policy: str) -> Iterator[str]:
    units = values["units"]
    yield f"{values['name']} ({values['file']}, {values['format']})"
    box = values["bounds"] or values["extent"]
    if box:
        kind = "bounds" if values["bounds"] else "no bounds; all entities are within"
        yield f"{kind} ({box[0]:g}, {box[1]:g}) to ({box[2]:g}, {box[3]:g}) {units}"
    yield ", ".join(counted(number, key.replace("_", " ")) for key, number in values["counts"].items() if number)
    if values["counts"]["lanes"]:
        parts = f"in {len(values['parts'])} parts of {', '.join(map(str, values['parts'][:_MAX_LINES]))} waypoints"
        joined = "all connected" if len(values["parts"]) == 1 else parts
        yield f"lanes: {values['lane_length']:g} {units} in all, {values['one_way_lanes']} one-way, {joined}"
    if policy:
        yield policy
    yield from _listed("robots", (_robot_line(one, units) for one in values["robots"]))
    yield from _listed("items", (f"{one['name']} {_at(one)} {one['weight']:g} kg" for one in values["items"]))
    yield from _listed("places", (f"{one['name']} {_at(one)}" for one in values["places"]))
    yield from _listed("docks", (f"{one['name']} {_at(one)} {one['type']}" for one in values["docks"]))
    yield from _listed("remap", (f"{alias} -> {target}" for alias, target in values["remap"].items()))
    yield from lines(values["network"], units)
    yield f"seed {values['seed']}, hash {values['hash']}"
    if values["warnings"]:
        yield f"{counted(values['warnings'], 'warnings')}; see `hmrsim map validate {values['file']}`"


def _listed(title: str, lines: Iterable[str]) -> Iterator[str]:
    rows = list(lines)
    if rows:
        yield f"{title}:"
    yield from (f"  {row}" for row in rows[:_MAX_LINES])
    if len(rows) > _MAX_LINES:
        yield f"  and {len(rows) - _MAX_LINES} more; --json has all"


def _robot_line(robot: dict[str, Any], units: str) -> str:
    parts = [f"{robot['name']} {_at(robot)} {robot['type']}, {robot['speed']:g} {units}/s", *robot["components"]]
    script = [f"a script of {counted(robot['script'], 'lines')}"] if robot["script"] else []
    return ", ".join([*parts, *script])


def _at(thing: dict[str, Any]) -> str:
    return f"({thing['at'][0]:g}, {thing['at'][1]:g})"

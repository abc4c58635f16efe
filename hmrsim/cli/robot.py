"""``hmrsim robot``: the robots of a running simulation."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.connection import connected
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.options import add_connection_options, add_json
from hmrsim.cli.output import columns, show_result
from hmrsim.diagnostics import listed
from hmrsim.history.causes import dock_queues, running_actions
from hmrsim.program.command_line import add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser

_EXAMPLES: Final = """\
examples:
  hmrsim robot list
  hmrsim robot list --json | jq -r '.[] | select(all(.goals[]; .status > 3)).name'"""


def configure(parser: LazyParser) -> None:
    """Add the commands of ``hmrsim robot``."""
    parser.description = "List the robots of a running simulation."
    parser.epilog = _EXAMPLES
    add_commands(parser, {"list": ("list the robots with their poses and activities", _configure_list)})


def _configure_list(parser: argparse.ArgumentParser) -> None:
    parser.epilog = _EXAMPLES
    add_json(parser, "print one JSON list, as `robots` of _world/scene")
    parser.set_defaults(function=_list)
    add_connection_options(parser)


def _list(args: argparse.Namespace) -> int:
    with connected(args) as (client, _):
        scene = json.loads(client.get(client.keys.world("scene")))
    table = [("name", "type", "at", "battery", "state"), *rows(scene)]
    show_result(scene["robots"], columns(table), as_json=args.json)
    return ExitCode.DONE


def rows(scene: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each robot of a scene: name, type, position, charge, and what it does or why it waits."""
    queues = dock_queues(scene)
    for robot in scene["robots"]:
        yield _row(robot, queues.get(robot["name"]))


def _row(robot: Mapping[str, Any], queue: tuple[str, Sequence[str]] | None) -> tuple[str, ...]:
    x, y, _ = robot["pose"]
    battery = robot.get("battery")
    charge = f"{battery['percentage']:.0%}" if battery else "-"
    return robot["name"], robot["type"] or "-", f"({x:g}, {y:g})", charge, ", ".join(_states(robot, queue)) or "idle"


def _states(robot: Mapping[str, Any], queue: tuple[str, Sequence[str]] | None) -> list[str]:
    states = [*running_actions(robot)]
    states += sorted(robot["ailments"])
    states += [f"holds {item}" for item in robot["holds"]]
    states += [f"docked at {robot['dock']}"] if robot["dock"] else []
    states += [] if robot["connected"] else ["connection lost"]
    states += [f"queues for {queue[0]} (docked there: {listed(queue[1])})"] if queue else []
    return states + ([_why_it_waits(robot["waiting"] or {})] if robot["waits"] else [])


def _why_it_waits(waiting: Mapping[str, Any]) -> str:
    if waiting.get("why"):
        return f"waits: {waiting['why']}"
    return f"waits for {'; and for '.join(waiting['blockers'])}" if waiting.get("blockers") else "waits"

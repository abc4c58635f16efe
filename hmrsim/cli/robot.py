"""``hmrsim robot``: the robots of a running simulation."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, get_args

from hmrsim.cli.connection import connected
from hmrsim.cli.options import ExitCode, add_connection_options, add_json
from hmrsim.cli.output import columns, show_result
from hmrsim.program.command_line import add_commands
from hmrsim.protocol.goal import GoalStatus
from hmrsim.traffic.causes import Chain, Link, chain_of
from hmrsim.traffic.rules import Activity

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
    links = {robot["name"]: Link(**robot["cause"]) for robot in scene["robots"]}
    for robot in scene["robots"]:
        yield _row(robot, chain_of(robot["name"], links.__getitem__))


def _row(robot: Mapping[str, Any], chain: Chain) -> tuple[str, ...]:
    x, y, _ = robot["pose"]
    battery = robot.get("battery")
    charge = f"{battery['percentage']:.0%}" if battery else "-"
    return robot["name"], robot["type"] or "-", f"({x:g}, {y:g})", charge, ", ".join(_states(robot, chain))


def _states(robot: Mapping[str, Any], chain: Chain) -> list[str]:
    states = [goal["action"] for goal in robot["goals"] if not GoalStatus(goal["status"]).terminal]
    states += sorted(robot["ailments"])
    states += [f"holds {item}" for item in robot["holds"]]
    states += [f"docked at {robot['dock']}"] if robot["dock"] else []
    states += [] if robot["connected"] else ["connection lost"]
    first, last = chain.links[0], chain.links[-1]
    if first.kind not in get_args(Activity):
        cause = "" if first is last else f"; cause: {last.text}"
        states.append(f"{first.text.removeprefix(first.robot).strip()}{cause}")
    elif not states:
        states.append(first.text.removeprefix(f"{first.robot} is "))
    return states

"""``hmrsim robot``: the robots of a running simulation."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from itertools import chain
from typing import TYPE_CHECKING, Any, Final, get_args

from hmrsim.cli.connection import connected, value_of
from hmrsim.cli.options import ExitCode, add_connection_options, add_json
from hmrsim.cli.output import columns, show_result
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.program.command_line import add_commands
from hmrsim.protocol.goal import GoalStatus
from hmrsim.traffic.causes import Chain, Link, chain_of
from hmrsim.traffic.rules import Activity

if TYPE_CHECKING:
    from hmrsim.program.command_line import CommandParser
    from hmrsim_zenoh.client.client import Client

_EXAMPLES: Final = """\
examples:
  hmrsim robot list
  hmrsim robot list --json | jq -r '.[] | select(all(.goals[]; .status > 3)).name'"""


_VISIBLE: Final = ("idle", "drives")
"""The activities of a robot without a goal that its other states do not tell."""


def configure(parser: CommandParser) -> None:
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
        scene = value_of(client, "scene")
        orders = waiting_orders(client)
    table = [("name", "type", "at", "battery", "state"), *rows(scene)]
    lines = chain(columns(table), ["", orders] if orders else [])
    show_result(scene["robots"], lines, as_json=args.json)
    return ExitCode.DONE


def waiting_orders(client: Client) -> str:
    """Return how many orders no robot has picked up, and which one has waited longest; empty if there are none."""
    demand = value_of(client, "demand")
    waiting = [order for order in demand["orders"] if order["state"] == "waiting"]
    if not waiting:
        return ""
    first = waiting[0]
    seconds = (_nanoseconds(demand["stamp"]) - _nanoseconds(first["placed"])) / NANOSECONDS
    several = f"{len(waiting)} orders wait" if len(waiting) > 1 else "1 order waits"
    oldest = f"{first['name']}, from {first['at']} to {first['to']}, for {seconds:.0f} s"
    return f"{several} to be picked up; the oldest: {oldest}"


def _nanoseconds(stamp: Mapping[str, int]) -> int:
    return stamp["sec"] * NANOSECONDS + stamp["nanosec"]


def rows(scene: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each robot of a scene: name, type, position, charge, and what it does or why it waits."""
    robots = {robot["name"]: robot for robot in scene["robots"]}
    for robot in robots.values():
        causes = chain_of(robot["name"], lambda name: Link(**robots[name]["cause"]))
        yield _row(robot, causes, last_error(robots[causes.links[-1].robot], causes.links[-1]))


def last_error(robot: Mapping[str, Any], link: Link) -> str:
    """Return the error message of the last goal of a robot that has none; empty if it did not fail.

    Args:
        robot: The robot, as in a scene.
        link: The cause for which it makes no progress.
    """
    failed = [goal for goal in robot["goals"] if goal["status"] == GoalStatus.ABORTED]
    if link.kind not in {"idle", "docked"} or not failed:
        return ""
    # Loads the actions, which a list without failed goals does not need.
    from hmrsim.actions import error_of, registry

    known = registry()
    return next(
        (
            error_of(known[goal["action"]].result.model_validate(goal["result"], strict=False))
            for goal in failed
            if goal["action"] in known
        ),
        "",
    )


def _row(robot: Mapping[str, Any], causes: Chain, error: str) -> tuple[str, ...]:
    x, y, _ = robot["pose"]
    battery = robot.get("battery")
    charge = f"{battery['percentage']:.0%}" if battery else "-"
    return robot["name"], robot["type"] or "-", f"({x:g}, {y:g})", charge, ", ".join(_states(robot, causes, error))


def _states(robot: Mapping[str, Any], causes: Chain, error: str) -> list[str]:
    goals = [goal["action"] for goal in robot["goals"] if not GoalStatus(goal["status"]).terminal]
    states = [*goals, *sorted(robot["ailments"]), *(f"holds {item}" for item in robot["holds"])]
    if robot["dock"]:
        charging = robot["battery"] and robot["battery"]["charging"]
        states.append(f"{'charging' if charging else 'docked'} at {robot['dock']}")
    states += [] if robot["connected"] else ["connection lost"]
    first, last = causes.links[0], causes.links[-1]
    failed = f"; its last goal failed: {error}" if error else ""
    if first.kind not in get_args(Activity):
        cause = "" if first is last else f"; cause: {last.text}{failed}"
        states.append(f"{first.text.removeprefix(first.robot).strip()}{cause}")
    elif first.kind == "disabled" or not states or (first.kind in _VISIBLE and not goals):
        states.append(f"{first.text.removeprefix(f'{first.robot} is ')}{failed}")
    return states

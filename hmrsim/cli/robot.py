"""``hmrsim robot``: the robots of a running simulation."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from hmrsim.cli.columns import columns
from hmrsim.cli.connection import connected
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json
from hmrsim.diagnostics import listed
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.wire.options import ENVIRONMENT

_EXAMPLES: Final = f"""\
examples:
  hmrsim robot list
  hmrsim robot list --json | jq -r '.[] | select(all(.goals[]; .status > 3)).name'

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim robot``."""
    parser.description = "List the robots of a running simulation."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    lister = commands.add_parser(
        "list",
        help="list the robots, where they are and what they do",
        description="List the robots, where they are and what they do.",
        epilog=_EXAMPLES,
    )
    lister.add_argument("--json", action="store_true", help="print one JSON list, as `robots` of _world/scene")
    lister.set_defaults(function=_list)
    add_connection_options(lister)


def _list(args: argparse.Namespace) -> int:
    with connected(args) as (client, _):
        scene = json.loads(client.get(client.keys.world("scene")))
    if args.json:
        show_json(scene["robots"])
        return ExitCode.DONE
    for line in columns([("name", "type", "at", "battery", "state"), *rows(scene)]):
        show(line)
    return ExitCode.DONE


def rows(scene: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield the row of each robot of a scene: name, type, position, charge, and what it does or why it waits."""
    queues = dict(_queues(scene["fixtures"]))
    for robot in scene["robots"]:
        yield _row(robot, queues.get(robot["name"]))


def _queues(fixtures: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Yield the robots that queue for a dock, and what is said of that."""
    for fixture in fixtures:
        tags = [tag.partition(":") for tag in fixture["tags"]]
        inside = listed([name for tag, _, name in tags if tag == "docked"])
        for tag, _, name in tags:
            if tag == "queued":
                yield name, f"queues for {fixture['name']} (docked there: {inside})"


def _row(robot: Mapping[str, Any], queue: str | None) -> tuple[str, ...]:
    x, y, _ = robot["pose"]
    battery = robot.get("battery")
    charge = f"{battery['percentage']:.0%}" if battery else "-"
    return robot["name"], robot["type"] or "-", f"({x:g}, {y:g})", charge, ", ".join(_states(robot, queue)) or "idle"


def _states(robot: Mapping[str, Any], queue: str | None) -> list[str]:
    # The scene has each action's last goal, too, when it has ended.
    found = [goal["action"] for goal in robot["goals"] if not GoalStatus(goal["status"]).terminal]
    found += sorted(robot["ailments"])
    found += [f"holds {item}" for item in robot["holds"]]
    found += [f"docked at {robot['dock']}"] if robot["dock"] else []
    found += [] if robot["connected"] else ["connection lost"]
    found += [queue] if queue else []
    return found + ([_why_it_waits(robot["waiting"] or {})] if robot["waits"] else [])


def _why_it_waits(waiting: Mapping[str, Any]) -> str:
    if waiting.get("why"):
        return f"waits: {waiting['why']}"
    return f"waits for {'; and for '.join(waiting['blockers'])}" if waiting.get("blockers") else "waits"

"""``hmrsim fault``: let things go wrong in a running simulation, and put them right."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from typing import Any, Final

import yaml

from hmrsim.cli.asking import ask
from hmrsim.cli.columns import columns
from hmrsim.cli.connection import OPERATOR, connected
from hmrsim.cli.connection_options import add_connection_options
from hmrsim.cli.exits import ExitCode, UnknownName, WrongUse
from hmrsim.cli.output import show, show_json, yaml_flow
from hmrsim.diagnostics import instead, shown
from hmrsim.faults import registry
from hmrsim_zenoh.wire.options import ENVIRONMENT

_EXAMPLES: Final = f"""\
examples:
  hmrsim fault inject breakdown robot=mocha duration=30
  hmrsim fault list
  hmrsim fault clear breakdown_1

{ENVIRONMENT}"""

_INJECT_EXAMPLES: Final = f"""\
exit codes: 0 it is injected; 1 the simulator refuses it, such as for an unknown robot; 2 wrong use; 3 no simulator

examples:
  hmrsim fault inject breakdown robot=mocha duration=30
  hmrsim fault inject lane_closed 'lane=[hall, entrance]' until=60
  hmrsim fault inject slip robot=latte factor=0.4 at=20 --json

The faults that there are, with their keys, are in docs/reference/faults.md; unknown ones are told.

{ENVIRONMENT}"""

_LIST_EXAMPLES: Final = f"""\
examples:
  hmrsim fault list
  hmrsim fault list --json | jq -r '.[] | select(.active).name'

{ENVIRONMENT}"""

_CLEAR_EXAMPLES: Final = f"""\
examples:
  hmrsim fault clear                 # all of them
  hmrsim fault clear breakdown_1
  hmrsim fault clear slip            # those of a type

{ENVIRONMENT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim fault``."""
    parser.description = "Inject faults into a running simulation, list them, and clear them."
    parser.epilog = _EXAMPLES
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    inject = commands.add_parser(
        "inject", help="let something go wrong", description="Inject a fault.", epilog=_INJECT_EXAMPLES
    )
    inject.add_argument("type", metavar="TYPE", help="the fault, such as breakdown")
    inject.add_argument("keys", metavar="KEY=VALUE", nargs="*", help="its keys, as in a world file; values are YAML")
    inject.add_argument("--json", action="store_true", help="print one JSON object")
    inject.set_defaults(function=_inject)
    lister = commands.add_parser(
        "list",
        help="list the faults that are active or scheduled",
        description="List the faults that are active or scheduled.",
        epilog=_LIST_EXAMPLES,
    )
    lister.add_argument("--json", action="store_true", help="print one JSON list")
    lister.set_defaults(function=_list)
    clear = commands.add_parser(
        "clear", help="end faults", description="End a fault, or all faults.", epilog=_CLEAR_EXAMPLES
    )
    clear.add_argument("name", metavar="FAULT", nargs="?", help="the name of one, or a type (default: all)")
    clear.set_defaults(function=_clear)
    for command in (inject, lister, clear):
        add_connection_options(command)


def _inject(args: argparse.Namespace) -> int:
    keys = dict(map(_key_and_value, args.keys))
    if args.type not in registry():
        raise WrongUse(f"no fault {shown(args.type)}{instead(args.type, registry(), verb='there are:')}")
    with connected(args, OPERATOR) as (client, _):
        name = ask(client, "inject_fault", type=args.type, settings=json.dumps(keys))["name"]
    if args.json:
        show_json({"name": name})
    else:
        show(f"{name} is injected; `hmrsim fault clear {name}` ends it")
    return ExitCode.DONE


def _key_and_value(word: str) -> tuple[str, Any]:
    key, found, text = word.partition("=")
    if not found or not key:
        raise WrongUse(f"{word!r}: expected KEY=VALUE, such as robot=mocha")
    try:
        return key, yaml.safe_load(text)
    except yaml.YAMLError:
        raise WrongUse(f"{word!r}: {text!r} is not valid YAML") from None


def _list(args: argparse.Namespace) -> int:
    with connected(args) as (client, _):
        faults = ask(client, "get_faults")["faults"]
    if args.json:
        show_json(faults)
        return ExitCode.DONE
    if not faults:
        show("no fault is active or scheduled")
        return ExitCode.DONE
    for line in columns([("name", "fault", "state", "settings"), *map(_row, faults)]):
        show(line)
    return ExitCode.DONE


def _row(fault: Mapping[str, Any]) -> tuple[str, str, str, str]:
    settings = yaml_flow(json.loads(fault["settings"]) if isinstance(fault["settings"], str) else fault["settings"])
    return fault["name"], fault["type"], "active" if fault["active"] else "scheduled", settings


def _clear(args: argparse.Namespace) -> int:
    with connected(args, OPERATOR) as (client, _):
        names = ask(client, "clear_fault", **_meant(args.name, ask(client, "get_faults")["faults"])).get("names", [])
    show(f"cleared: {', '.join(names)}" if names else "there is no fault to clear")
    return ExitCode.DONE


def _meant(name: str | None, faults: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return which faults are meant: one by its name, those of a type, or all."""
    for field in ("name", "type"):
        if name in {fault[field] for fault in faults}:
            return {field: str(name)}
    if name is None:
        return {}
    known = [fault["name"] for fault in faults]
    rest = instead(name, known, verb="there are:") if known else "; there is none"
    raise UnknownName(f"no fault {shown(name)} is active or scheduled{rest}")

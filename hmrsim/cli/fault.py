"""``hmrsim fault``: inject faults into a running simulation, list them, and clear them."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hmrsim.cli.connection import OPERATOR, call, connected
from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, add_connection_options, add_json
from hmrsim.cli.output import columns, show, show_result, yaml_flow
from hmrsim.diagnostics import instead, shown
from hmrsim.program.command_line import add_commands

if TYPE_CHECKING:
    from hmrsim.program.command_line import CommandParser


def configure(parser: CommandParser) -> None:
    """Add the commands of ``hmrsim fault``."""
    parser.description = "Inject faults into a running simulation, list them, and clear them."
    parser.epilog = """\
examples:
  hmrsim fault inject breakdown robot=mocha duration=30
  hmrsim fault list
  hmrsim fault clear breakdown_1"""
    add_commands(
        parser,
        {
            "inject": ("inject a fault", _configure_inject),
            "list": ("list the faults that are active or scheduled", _configure_list),
            "clear": ("end faults", _configure_clear),
        },
    )


def _configure_inject(parser: argparse.ArgumentParser) -> None:
    parser.epilog = """\
exit codes: 0 the fault is injected; 1 the simulator refuses it, as for an unknown robot; 2 wrong use; 3 no simulator

examples:
  hmrsim fault inject breakdown robot=mocha duration=30
  hmrsim fault inject lane_closed 'lane=[hall, entrance]' until=60
  hmrsim fault inject slip robot=latte factor=0.4 at=20 --json

docs/reference/faults.md lists all faults and their keys."""
    parser.add_argument("type", metavar="TYPE", help="the fault, such as breakdown")
    parser.add_argument(
        "keys", metavar="KEY=VALUE", nargs="*", help="keys of the fault, as in a world file; values are YAML"
    )
    add_json(parser)
    parser.set_defaults(function=_inject)
    add_connection_options(parser)


def _configure_list(parser: argparse.ArgumentParser) -> None:
    parser.epilog = """\
examples:
  hmrsim fault list
  hmrsim fault list --json | jq -r '.[] | select(.active).name'"""
    add_json(parser, "print one JSON list")
    parser.set_defaults(function=_list)
    add_connection_options(parser)


def _configure_clear(parser: argparse.ArgumentParser) -> None:
    parser.description = "End a fault, or all faults."
    parser.epilog = """\
examples:
  hmrsim fault clear                 # all of them
  hmrsim fault clear breakdown_1
  hmrsim fault clear slip            # all of a type"""
    parser.add_argument("name", metavar="FAULT", nargs="?", help="the name or the type of faults (default: all)")
    parser.set_defaults(function=_clear)
    add_connection_options(parser)


def _inject(args: argparse.Namespace) -> int:
    from hmrsim.faults import registry

    keys = dict(map(_key_and_value, args.keys))
    if args.type not in registry():
        raise WrongUse(f"no fault {shown(args.type)}{instead(args.type, registry(), verb='there are:')}")
    with connected(args, OPERATOR) as (client, _):
        name = call(client, "inject_fault", type=args.type, settings=json.dumps(keys))["name"]
    show_result({"name": name}, f"{name} is injected; `hmrsim fault clear {name}` ends it", as_json=args.json)
    return ExitCode.DONE


def _key_and_value(word: str) -> tuple[str, Any]:
    import yaml

    key, found, text = word.partition("=")
    if not found or not key:
        raise WrongUse(f"{word!r}: expected KEY=VALUE, such as robot=mocha")
    try:
        return key, yaml.safe_load(text)
    except yaml.YAMLError:
        raise WrongUse(f"{word!r}: {text!r} is not valid YAML") from None


def _list(args: argparse.Namespace) -> int:
    with connected(args) as (client, _):
        faults = call(client, "get_faults")["faults"]
    table = columns([("name", "fault", "state", "settings"), *map(_row, faults)])
    show_result(faults, table if faults else "no fault is active or scheduled", as_json=args.json)
    return ExitCode.DONE


def _row(fault: Mapping[str, Any]) -> tuple[str, str, str, str]:
    settings = yaml_flow(json.loads(fault["settings"]) if isinstance(fault["settings"], str) else fault["settings"])
    return fault["name"], fault["type"], "active" if fault["active"] else "scheduled", settings


def _clear(args: argparse.Namespace) -> int:
    with connected(args, OPERATOR) as (client, _):
        names = call(client, "clear_fault", **_selected(args.name, call(client, "get_faults")["faults"])).get(
            "names", []
        )
    show(f"cleared: {', '.join(names)}" if names else "there is no fault to clear")
    return ExitCode.DONE


def _selected(name: str | None, faults: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return the request to clear a fault by its name, all faults of a type, or all faults."""
    for field in ("name", "type"):
        if name in {fault[field] for fault in faults}:
            return {field: str(name)}
    if name is None:
        return {}
    known = [fault["name"] for fault in faults]
    rest = instead(name, known, verb="there are:") if known else "; there is none"
    raise UnknownName(f"no fault {shown(name)} is active or scheduled{rest}")

"""``hmrsim explain``: the meaning of a code, or why a robot waits, and what to do."""

from __future__ import annotations

import argparse
import json
import re
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, add_connection_options
from hmrsim.cli.output import columns, show_result
from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.time import LOCKSTEP

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from hmrsim.explanations import Explanation

_WIDTH: Final = 100

_HANDLE: Final = "its controller has to handle this error, and send a goal; look at the output of the controller"

_EARLIER: Final = (
    "A dispatcher that subscribes to events misses orders from before it connects; use `AsyncClient.orders()`"
)

_EXAMPLES: Final = """\
examples:
  hmrsim explain 208
  hmrsim explain not_ready
  hmrsim explain              # all codes, one per line
  hmrsim explain --robot eve  # why it waits, in a running simulation"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim explain``."""
    parser.description = (
        "Explain a code: the error code of a result, the reason of a rejection, the cause of an aborted goal, the "
        "result of a service (result_4), or the exit code of a command (exit_3). With --robot, explain why a robot of "
        "a running simulation waits: each cause, down to the one that starts it."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("code", metavar="CODE", nargs="?", help="such as 208, -19, not_ready or exit_3 (default: list)")
    parser.add_argument("--robot", metavar="NAME", help="a robot of a running simulation, instead of a code")
    parser.add_argument("--json", action="store_true", help="print one JSON object, or a list")
    parser.set_defaults(function=_explain)
    add_connection_options(parser)


def _explain(args: argparse.Namespace) -> int:
    from hmrsim.explanations import explanations

    if args.robot is not None:
        return _explain_robot(args)

    known = explanations()
    if args.code is None:
        rows = [(each.code, each.name, each.means) for each in known.values()]
        show_result([asdict(each) for each in known.values()], columns(rows), as_json=args.json)
        return ExitCode.DONE
    explanation = known.get(args.code)
    if explanation is None:
        # Numbers are not misspelled, but may be defined by an action of another package.
        of_package = "; `hmrsim action info` lists those of an action of a package"
        other = of_package if args.code.lstrip("-").isdigit() else instead(args.code, known)
        raise UnknownName(f"no code {shown(args.code)}{other}; `hmrsim explain` lists all")
    show_result(asdict(explanation), _lines(explanation), as_json=args.json)
    return ExitCode.DONE


def _explain_robot(args: argparse.Namespace) -> int:
    from hmrsim.cli.connection import call, connected, value_of
    from hmrsim.cli.robot import last_error, waiting_orders
    from hmrsim.traffic.causes import Link, chain_of

    if args.code is not None:
        raise WrongUse("give a code or --robot, not both")
    with connected(args) as (client, _):
        scene = value_of(client, "scene")
        time = value_of(client, "time/state")
        orders = waiting_orders(client)
        faults = call(client, "get_faults")["faults"]
    robots = {robot["name"]: robot for robot in scene["robots"]}
    if args.robot not in robots:
        raise UnknownName(f"no robot {shown(args.robot)}{instead(args.robot, robots)}")
    chain = chain_of(args.robot, lambda name: Link(**robots[name]["cause"]))
    stopped, remedy = _why_time_stands(time)
    last = chain.links[-1]
    idle = last.kind == "idle"
    failed = last_error(robots[last.robot], last)
    ends = {fault["name"]: _end_of(fault) for fault in faults if _concerns(fault, f"{last.text} {failed}")}
    explanation = {
        "robot": args.robot,
        "time": stopped,
        "links": [link._asdict() for link in chain.links],
        "faults": [*ends.values()],
        "last_error": failed,
        "orders": f"{orders}. {_EARLIER}" if orders and idle else orders,
        "help": remedy or (_after_error(ends) if failed and len(chain.links) == 1 else chain.help),
    }
    show_result(explanation, _lines_about_robot(explanation), as_json=args.json)
    return ExitCode.DONE


def _lines_about_robot(explanation: dict[str, Any]) -> Iterator[str]:
    """Yield the causes, each indented below the one before it, and what would help."""
    if explanation["time"]:
        yield explanation["time"]
    for depth, link in enumerate(explanation["links"]):
        yield f"{'  ' * depth}{link['text']}"
    yield from explanation["faults"]
    if explanation["last_error"]:
        failed = f"{explanation['links'][-1]['robot']}'s last goal failed: {explanation['last_error']}"
        yield from textwrap.wrap(failed, _WIDTH, initial_indent="  ", subsequent_indent="  ")
    yield ""
    if explanation["orders"]:
        yield from textwrap.wrap(explanation["orders"], _WIDTH)
    yield from textwrap.wrap(f"What would help: {explanation['help']}", _WIDTH)


def _after_error(ends: Mapping[str, str]) -> str:
    """Return what would help a robot whose last goal failed, given the ends of the faults behind that, by name."""
    if not ends:
        return _HANDLE
    return f"wait until the fault ends, or end it: {' and '.join(f'`hmrsim fault clear {name}`' for name in ends)}"


def _concerns(fault: Mapping[str, Any], text: str) -> bool:
    """Return whether an active fault affects a robot, door, lift, dock or lane that a text names."""
    settings = json.loads(fault["settings"])
    subjects = [settings.get(key) for key in ("robot", "door", "lift", "dock")]
    lane = settings.get("lane") or ()
    words = set(re.findall(r"[\w/-]+", text))
    named = [fault["name"], "-".join(lane), "-".join(reversed(lane)), *subjects]
    return fault["active"] and any(name in words for name in named if name)


def _end_of(fault: Mapping[str, Any]) -> str:
    """Return when an active fault ends, as a sentence."""
    settings, since = json.loads(fault["settings"]), fault["since"]["sec"] + fault["since"]["nanosec"] / NANOSECONDS
    text = f"The fault {fault['name']} ({fault['type']})"
    if settings.get("until") is not None:
        return f"{text} ends at {settings['until']:g} s."
    match settings.get("duration"):
        case int() | float() as seconds:
            return f"{text} ends at {since + seconds:g} s."
        case None if settings.get("mean_duration") is None:
            return f"{text} has no end: `hmrsim fault clear {fault['name']}` ends it."
    return f"{text} ends after a random time."


def _why_time_stands(state: dict[str, Any]) -> tuple[str, str]:
    """Return why simulated time does not advance, and what would help; empty texts while it advances."""
    stands = f"Simulated time stands at {state['now']:g} s:"
    if state["paused"]:
        return f"{stands} it is paused", "`hmrsim time resume`"
    if state["waiting_for"]:
        names = ", ".join(state["waiting_for"])
        return f"{stands} lockstep waits for {names}", f"look at {names}: it has not asked for time, or has not joined"
    if state["clock"] == LOCKSTEP and not state["participants"]:
        remedy = "start the controller; if it has ended, its output says why"
        return f"{stands} no controller takes part in lockstep", remedy
    return "", ""


def _lines(explanation: Explanation) -> Iterator[str]:
    yield f"{explanation.code} {explanation.name} ({explanation.of})"
    yield from textwrap.wrap(explanation.means, _WIDTH)
    for title, text in (("Why", explanation.why), ("What to do", explanation.do)):
        yield from ("", f"{title}:", *_wrapped(text))


def _wrapped(text: str) -> Iterator[str]:
    """Yield the wrapped and indented lines of a text; each line of it is a paragraph, an entry of a list, or empty."""
    for line in text.splitlines():
        hanging = "    " if line.startswith("- ") else "  "
        yield from textwrap.wrap(line, _WIDTH, initial_indent="  ", subsequent_indent=hanging) or [""]

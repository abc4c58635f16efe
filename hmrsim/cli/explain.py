"""``hmrsim explain``: the meaning of a code, or why a robot waits, and what to do."""

from __future__ import annotations

import argparse
import json
import re
import textwrap
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any, Final, get_args

from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, add_connection_options
from hmrsim.cli.output import columns, show_result, warn
from hmrsim.diagnostics import instead, shown
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.time import LOCKSTEP
from hmrsim_zenoh.errors import SimulatorNotFound

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from hmrsim.explanations import Explanation

_WIDTH: Final = 100

_LOOK: Final = 2.0
"""Wall seconds to look for a simulator, unless the user sets --timeout."""

_NONE_WAITS: Final = "no robot waits; `hmrsim robot list` shows what each one does"

_HANDLE: Final = "its controller has to handle this error, and send a goal; look at the output of the controller"

_EARLIER: Final = (
    "A dispatcher that subscribes to events misses orders from before it connects; use `AsyncClient.orders()`"
)

_EXAMPLES: Final = """\
examples:
  hmrsim explain 208
  hmrsim explain not_ready
  hmrsim explain --codes      # all codes, one per line
  hmrsim explain              # why robots wait, in a running simulation
  hmrsim explain --robot eve  # why this one waits, or does nothing"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim explain``."""
    parser.description = (
        "Explain a code: the error code of a result, the reason of a rejection, the cause of an aborted goal, the "
        "result of a service (result_4), or the exit code of a command (exit_3). Without a code, explain why the "
        "robots of a running simulation wait: each cause, down to the one that starts it. If no simulator answers, "
        "list all codes."
    )
    parser.epilog = _EXAMPLES
    parser.add_argument("code", metavar="CODE", nargs="?", help="such as 208, -19, not_ready or exit_3")
    parser.add_argument("--codes", action="store_true", help="list all codes")
    parser.add_argument("--robot", metavar="NAME", help="only this robot, even if it does not wait")
    parser.add_argument("--json", action="store_true", help="print one JSON object, or a list")
    parser.set_defaults(function=_explain)
    add_connection_options(parser)


def _explain(args: argparse.Namespace) -> int:
    if sum([args.code is not None, args.robot is not None, args.codes]) > 1:
        raise WrongUse("give only one of a code, --robot and --codes")
    if args.code is not None:
        return _explain_code(args)
    if args.robot is not None:
        return _explain_robots(args)
    if not args.codes:
        try:
            return _explain_robots(argparse.Namespace(**{"timeout": _LOOK, **vars(args)}))
        except SimulatorNotFound as error:
            warn(f"{error}; all codes:")
    return _list_codes(args)


def _list_codes(args: argparse.Namespace) -> int:
    from hmrsim.explanations import explanations

    known = explanations().values()
    rows = [(each.code, each.name, each.means) for each in known]
    show_result([asdict(each) for each in known], columns(rows), as_json=args.json)
    return ExitCode.DONE


def _explain_code(args: argparse.Namespace) -> int:
    from hmrsim.explanations import explanations

    known = explanations()
    explanation = known.get(args.code)
    if explanation is None:
        # Numbers are not misspelled, but may be defined by an action of another package.
        of_package = "; `hmrsim action info` lists those of an action of a package"
        other = of_package if args.code.lstrip("-").isdigit() else instead(args.code, known)
        raise UnknownName(f"no code {shown(args.code)}{other}; `hmrsim explain --codes` lists all")
    show_result(asdict(explanation), _lines(explanation), as_json=args.json)
    return ExitCode.DONE


def _explain_robots(args: argparse.Namespace) -> int:
    """Explain why one robot or, without ``--robot``, each one that others or obstacles hold up makes no progress."""
    from hmrsim.cli.connection import call, connected, value_of
    from hmrsim.cli.robot import waiting_orders
    from hmrsim.traffic.rules import Activity

    with connected(args) as (client, _):
        scene = value_of(client, "scene")
        time = value_of(client, "time/state")
        orders = waiting_orders(client)
        faults = call(client, "get_faults")["faults"]
    robots = {robot["name"]: robot for robot in scene["robots"]}
    if args.robot is not None and args.robot not in robots:
        raise UnknownName(f"no robot {shown(args.robot)}{instead(args.robot, robots)}")
    stands = _why_time_stands(time)
    explain = partial(_explanation, robots=robots, stands=stands, orders=orders, faults=faults)
    if args.robot is not None:
        explanation = explain(args.robot)
        show_result(explanation, _lines_about_robot(explanation), as_json=args.json)
        return ExitCode.DONE
    held_up = [name for name, robot in robots.items() if robot["cause"]["kind"] not in get_args(Activity)]
    explanations = [explain(name) for name in held_up]
    show_result(explanations, _lines_about_robots(explanations, *stands), as_json=args.json)
    return ExitCode.DONE


def _explanation(
    name: str,
    *,
    robots: Mapping[str, dict[str, Any]],
    stands: tuple[str, str],
    orders: str,
    faults: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """Return the chain of causes of a robot of a scene, and what would help."""
    from hmrsim.cli.robot import last_error
    from hmrsim.traffic.causes import Link, chain_of

    chain = chain_of(name, lambda name: Link(**robots[name]["cause"]))
    stopped, remedy = stands
    last = chain.links[-1]
    idle = last.kind == "idle"
    failed = last_error(robots[last.robot], last)
    ends = {fault["name"]: _end_of(fault) for fault in faults if _concerns(fault, f"{last.text} {failed}")}
    return {
        "robot": name,
        "time": stopped,
        "links": [link._asdict() for link in chain.links],
        "faults": [*ends.values()],
        "last_error": failed,
        "orders": f"{orders}. {_EARLIER}" if orders and idle else orders,
        "help": remedy or (_after_error(ends) if failed and len(chain.links) == 1 else chain.help),
    }


def _lines_about_robots(explanations: Sequence[dict[str, Any]], stopped: str, remedy: str) -> Iterator[str]:
    """Yield the lines about each robot, with two empty lines in between; if there are none, why time stands, if so."""
    if not explanations:
        yield f"{stopped}; what would help: {remedy}" if stopped else _NONE_WAITS
    for number, explanation in enumerate(explanations):
        yield from ("", "") if number else ()
        yield from _lines_about_robot(explanation)


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

"""``hmrsim doctor``: diagnose a network: what is on it, what is wrong, and what to do."""

from __future__ import annotations

import argparse
import os
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.connection import VIEWER
from hmrsim.cli.options import (
    ExitCode,
    add_connection_options,
    add_json,
    add_ros_domain,
    ros_domain_of_environment,
)
from hmrsim.cli.output import counted, show_json, show_result
from hmrsim.errors import printable
from hmrsim.program.log_options import logging_to_stderr
from hmrsim_zenoh.doctor.ros2_checks import incomplete_actions, later_actions
from hmrsim_zenoh.doctor.snapshot import OFFER, endpoints, first_few
from hmrsim_zenoh.errors import BadOptions, ConnectionDenied, SimulatorNotFound
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.type_compat import distros_of, ros_name
from hmrsim_zenoh.server.tokens import MAX_TOKENS
from hmrsim_zenoh.wire.options import session_options

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor import Problem, Simulator, Snapshot
    from hmrsim_zenoh.doctor.snapshot import Domain
    from hmrsim_zenoh.ros2.keys import Token

_KINDS: Final = {
    Kind.PUBLISHER: "publisher",
    Kind.SUBSCRIBER: "subscriber",
    Kind.SERVICE: "service",
    Kind.CLIENT: "client",
}
_MAX_DOMAINS: Final = 8
_LABEL: Final = 11
"""Width of a line's label, in characters."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim doctor``."""
    parser.description = (
        "Show what is on the network (a simulator, its robots and their controllers, ROS nodes), what is wrong,\n"
        "and what to do. It observes for half a second, and changes nothing."
    )
    parser.epilog = """\
exit codes:
  0  no errors, maybe warnings
  1  errors; each comes with a remedy
  2  wrong use
  3  neither a simulator nor a ROS node answers

examples:
  hmrsim doctor
  hmrsim doctor --ros-domain-id 7 --connect tcp/10.0.0.7:7447
  hmrsim doctor --json | jq -r '.problems[].remedy'"""
    add_json(parser, "print one JSON object with everything")
    add_ros_domain(parser, "the ROS domain to examine")
    parser.set_defaults(function=_examine)
    add_connection_options(parser)


def _examine(args: argparse.Namespace) -> int:
    from hmrsim_zenoh.doctor import Problem, gather, problems, requested

    given, options = args.ros_domain_id, session_options(args, VIEWER)
    asked = requested(
        options,
        domain=given if given is not None else _domain_of_environment(),
        environment=os.environ,
        wants_ros=given is not None,
    )
    try:
        with logging_to_stderr(args):
            snapshot = gather(options, asked)
    except SimulatorNotFound as error:
        if args.json:
            text, _, remedy = str(error).partition("; ")
            kind = "access_denied" if isinstance(error, ConnectionDenied) else "nobody_there"
            show_json(as_json(asked, [Problem(kind, text, remedy)]))
        raise
    found = problems(snapshot)
    show_result(as_json(snapshot, found), as_text(snapshot, found), as_json=args.json)
    return ExitCode.FAILED if any(problem.severity == "error" for problem in found) else ExitCode.DONE


def _domain_of_environment() -> int:
    """Return the ROS domain of the environment; 0 if it is not valid, which is reported as a problem."""
    try:
        return ros_domain_of_environment()
    except BadOptions:
        return 0


def as_text(snapshot: Snapshot, problems: Sequence[Problem]) -> Iterator[str]:
    """Return the lines of the findings and of the problems."""
    facts = [f"{label:<{_LABEL}} {text}" for label, text in _facts(snapshot)]
    lines = [f"{problem.severity}: {problem.text}; {problem.remedy}" for problem in problems]
    return map(printable, (*facts, "", *(lines or ["nothing is wrong"])))


def as_json(snapshot: Snapshot, problems: Sequence[Problem]) -> dict[str, Any]:
    """Return the findings and the problems as plain values."""
    simulator, enclave = snapshot.simulator, snapshot.enclave
    return {
        "network": {"endpoints": snapshot.endpoints, "routers": snapshot.routers, "peers": snapshot.peers},
        "prefixes": snapshot.prefixes,
        "simulator": None if simulator is None else _simulator_json(snapshot, simulator),
        "ros2": {
            "domain": snapshot.domain,
            "domains": {str(number): _domain_json(domain) for number, domain in snapshot.domains.items()},
            "unreadable": snapshot.unreadable,
            "distros": _distros(snapshot.ros),
            "incomplete_actions": incomplete_actions(snapshot) if snapshot.ros.ours else {},
        },
        **({"security": enclave.member.to_json(), "connected": dict(snapshot.names)} if enclave else {}),
        "environment": dict(snapshot.environment),
        "problems": [asdict(problem) for problem in problems],
    }


def _simulator_json(snapshot: Snapshot, simulator: Simulator) -> dict[str, Any]:
    return {
        "prefix": snapshot.prefix,
        "session": simulator.session,
        "twins": simulator.twins,
        "info": simulator.info,
        "time": simulator.time,
        "robots_alive": sorted(simulator.alive),
        "participants_alive": sorted(simulator.tokens),
        "trees": {
            robot: {key: tree.get(key) for key in _TREE_FIELDS} for robot, tree in sorted(simulator.trees.items())
        },
    }


_TREE_FIELDS: Final = ("sim_time", "tick", "status", "ended")
"""The fields of a tree to show; its topic has more."""


def _domain_json(domain: Domain) -> list[dict[str, Any]]:
    """Return the nodes of a domain and their endpoints."""
    nodes: dict[tuple[str, str], list[dict[str, str]]] = {}
    for token in domain.tokens:
        served = nodes.setdefault((token.session, token.node.full_name), [])
        if token.endpoint is not None:
            endpoint = token.endpoint
            served.append(
                {
                    "kind": _KINDS[endpoint.kind],
                    "name": endpoint.name,
                    "type": ros_name(endpoint.type),
                    "hash": endpoint.hash,
                    "qos": endpoint.qos,
                }
            )
    ours = {token.session for token in domain.ours}
    return [
        {"name": name, "session": session, "simulator": session in ours, "endpoints": served}
        for (session, name), served in sorted(nodes.items())
    ]


def _facts(snapshot: Snapshot) -> Iterator[tuple[str, str]]:
    simulator = snapshot.simulator
    router = "a router" if snapshot.routers else "a peer, no router"
    if simulator and simulator.session in snapshot.routers:
        router = "the simulator is the router"
    yield "network", f"{snapshot.where}: {router}"
    if (enclave := snapshot.enclave) is not None:
        yield "security", f"as {enclave.name!r} ({enclave.member.role}), until {enclave.member.expires[:10]}"
    if names := Counter(snapshot.names.values()):
        yield (
            "connected",
            first_few(f"{name}{f' ({count})' if count > 1 else ''}" for name, count in sorted(names.items())),
        )
    others = [prefix for prefix in snapshot.prefixes if simulator is None or prefix != snapshot.prefix]
    if simulator is not None:
        yield from _simulator_facts(snapshot, simulator)
    else:
        yield "simulator", "none"
    if others:
        yield "others", f"simulators with the prefix {first_few(others)}"
    yield from _ros_facts(snapshot)


def _simulator_facts(snapshot: Snapshot, simulator: Simulator) -> Iterator[tuple[str, str]]:
    info, time = simulator.info, simulator.time
    world = info.get("world", {}).get("name")
    yield (
        "simulator",
        f"hmrsim {info.get('hmrsim')}, contract {info.get('contract')}, prefix {snapshot.prefix}, world {world!r}",
    )
    yield "time", ", ".join(_time_facts(time))
    yield "robots", "; ".join((first_few(_groups(simulator)) or "none", *_liveliness(simulator)))
    if time.get("participants") or time.get("waiting_for"):
        waiting = f"; time waits for {first_few(time['waiting_for'])}" if time.get("waiting_for") else ""
        yield "lockstep", f"{first_few(time.get('participants', ())) or 'no participants'}{waiting}"
    # A simulator mistakes another one with its prefix for a planner.
    if info.get("planner_present") and not simulator.twins:
        yield "planner", "an external one is available"
    if simulator.trees:
        yield (
            "trees",
            first_few(f"{robot} {tree.get('status', '')}".strip() for robot, tree in sorted(simulator.trees.items())),
        )


def _groups(simulator: Simulator) -> Iterator[str]:
    """Yield the robots that serve the same actions, with the number of these actions."""
    groups: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
    for robot, actions in simulator.robots.items():
        groups[tuple(actions)].append(robot)
    for served, names in groups.items():
        yield f"{first_few(names)} ({counted(len(served), 'actions')}{' each' * (len(names) > 1)})"


def _liveliness(simulator: Simulator) -> Iterator[str]:
    if len(simulator.robots) > MAX_TOKENS:
        yield "too many for liveliness tokens"
    elif simulator.robots:
        alive = len(simulator.alive & simulator.robots.keys())
        yield f"{alive} of {len(simulator.robots)} with a liveliness token"


def _time_facts(time: Any) -> Iterator[str]:
    yield f"{round(time.get('now', 0.0), 1):.9g} s"
    factor = time.get("real_time_factor", 1.0)
    if time.get("clock") == "lockstep":
        yield f"lockstep, epoch {time.get('epoch')}"
    else:
        yield f"realtime, {f'factor {factor:g}' if factor else 'as fast as possible'}"
    if time.get("paused"):
        yield "paused"
    if time.get("lag"):
        yield f"{time['lag']:.1f} wall seconds lost"


def _ros_facts(snapshot: Snapshot) -> Iterator[tuple[str, str]]:
    domains = {snapshot.domain: snapshot.ros, **snapshot.domains}
    for number in [*domains][:_MAX_DOMAINS]:
        domain = domains[number]
        if not domain.tokens:
            yield "ROS", f"domain {number}: no nodes"
        if domain.ours:
            yield "ROS", f"domain {number}: {_offer_text(snapshot, domain)}"
        if domain.others:
            yield "ROS", f"domain {number}: {_nodes_text(domain.others)}"
    if len(domains) > _MAX_DOMAINS:
        yield "ROS", f"{len(domains) - _MAX_DOMAINS} more domains"


def _offer_text(snapshot: Snapshot, domain: Domain) -> str:
    nodes, count = {token.node for token in domain.ours}, sum(1 for _ in endpoints(domain.ours))
    text = f"the simulator, with {len(nodes)} nodes and {count} endpoints"
    if domain is snapshot.ros and snapshot.simulator is not None:
        names, lost = snapshot.simulator.names.actions, set(snapshot.simulator.lost)
        gone = sum(robot in lost for robot, _ in names.values())
        later = len(later_actions(snapshot))
        whole = len(names) - gone - later - len(incomplete_actions(snapshot))
        text += f"; {whole} of {len(names)} action names whole"
        if later:
            text += f", {later} when a client looks for them"
    return f"{text}; types of {', '.join(_distros(domain)) or 'no distribution known here'}"


def _distros(domain: Domain) -> tuple[str, ...]:
    return distros_of({(endpoint.type, endpoint.hash) for _, endpoint in endpoints(domain.ours, *OFFER)})


def _nodes_text(tokens: Iterable[Token]) -> str:
    kinds: defaultdict[str, Counter[str]] = defaultdict(Counter)
    for token in tokens:
        counts = kinds[token.node.full_name]
        if token.endpoint is not None:
            counts[_KINDS[token.endpoint.kind]] += 1
    nodes = []
    for node, counts in sorted(kinds.items()):
        words = ", ".join(counted(count, f"{kind}s") for kind, count in sorted(counts.items()))
        nodes.append(f"{node} ({words})" if words else node)
    return f"{counted(len(kinds), 'nodes')} of others: {first_few(nodes)}"

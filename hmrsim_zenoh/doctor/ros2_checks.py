"""Checks of ROS 2: the simulator's endpoints, and the clients and subscribers of other nodes."""

from __future__ import annotations

import difflib
from collections import defaultdict
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.doctor.snapshot import OFFER, WANT, Problem, collapsed, endpoints, first_few
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.type_compat import difference, known

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Snapshot


_PARTS: Final = {
    "send_goal": Kind.SERVICE,
    "cancel_goal": Kind.SERVICE,
    "get_result": Kind.SERVICE,
    "feedback": Kind.PUBLISHER,
    "status": Kind.PUBLISHER,
}
"""The parts of an action: a ROS client waits for all of them before it sends a goal."""

_APART: Final = "start the simulator with another --ros-domain-id"


def incomplete_actions(snapshot: Snapshot) -> dict[str, list[str]]:
    """Return the missing parts of each incomplete action of the simulator in the domain.

    In a large fleet, actions are declared when a client looks for them.
    """
    return {name: parts for name, parts in _missing(snapshot).items() if len(parts) < len(_PARTS)}


def later_actions(snapshot: Snapshot) -> list[str]:
    """Return the actions that are declared when a client looks for them."""
    return [name for name, parts in _missing(snapshot).items() if len(parts) == len(_PARTS)]


def _missing(snapshot: Snapshot) -> dict[str, list[str]]:
    if snapshot.simulator is None:
        return {}
    there = {(endpoint.name, endpoint.kind) for _, endpoint in endpoints(snapshot.ros.ours, *OFFER)}
    found = {}
    for action, (robot, _) in snapshot.simulator.names.actions.items():
        if robot in snapshot.simulator.lost:
            continue
        missing = [part for part, kind in _PARTS.items() if (f"{action}/_action/{part}", kind) not in there]
        if missing:
            found[action] = missing
    return found


def _not_served(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that the simulator is not in the domain: it has no ROS 2 wire, or is in another domain."""
    if snapshot.simulator is None or snapshot.ros.ours:
        return
    elsewhere = [number for number, domain in snapshot.domains.items() if domain.ours]
    if elsewhere:
        yield Problem(
            "other_domain",
            f"the simulator is in ROS domain {elsewhere[0]}, not in {snapshot.domain}",
            f"`export ROS_DOMAIN_ID={elsewhere[0]}`, or start it with --ros-domain-id {snapshot.domain}",
        )
    elif snapshot.uses_ros:
        yield Problem("no_ros2", "the simulator does not serve ROS 2", "start `hmrsim run` with --ros2")


def _missing_parts(snapshot: Snapshot) -> Iterator[Problem]:
    incomplete = incomplete_actions(snapshot) if snapshot.ros.ours else {}
    if incomplete and snapshot.simulator is not None:
        most, every = len(_PARTS), len(snapshot.simulator.names.actions)
        listed = first_few(f"{name} ({', '.join(p)})" if len(p) < most else name for name, p in incomplete.items())
        yield Problem(
            "incomplete_actions",
            f"{len(incomplete)} of {every} actions are missing or incomplete: {listed}",
            "wait if the simulator has just started, else see its log",
        )


def _unknown_types(snapshot: Snapshot) -> Iterator[Problem]:
    strange = {
        endpoint.type
        for _, endpoint in endpoints(snapshot.ros.ours, *OFFER)
        if endpoint.hash not in known().get(endpoint.type, {endpoint.hash: ()})
    }
    if strange:
        yield Problem(
            "unknown_types",
            f"the simulator has types whose hashes this hmrsim does not know: {first_few(sorted(strange))}",
            "install the same version on both sides",
        )


def _two_servers(snapshot: Snapshot) -> Iterator[Problem]:
    """Report actions and services with two servers: both execute a request, and a client gets the reply of either."""
    servers: defaultdict[str, dict[str, str]] = defaultdict(dict)
    for token, endpoint in endpoints(snapshot.ros.tokens, Kind.SERVICE):
        servers[endpoint.name][token.session] = token.node.full_name
    doubled: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
    for name, sessions in servers.items():
        if len(sessions) > 1:
            doubled[tuple(sorted(sessions))].append(name)
    for programs, names in doubled.items():
        nodes = {servers[name][program] for name in names for program in programs}
        ours = snapshot.simulator is not None and snapshot.simulator.session in programs
        yield Problem(
            "two_servers",
            f"{len(programs)} programs serve {first_few(collapsed(names))} (nodes {first_few(sorted(nodes))}): "
            f"{'both' if len(programs) == 2 else 'all'} execute each goal and request",  # noqa: PLR2004 - both are two
            f"end one of them, or {_APART if ours else 'give it another ROS_DOMAIN_ID or other names'}",
        )


_CLOSE: Final = 0.8
"""The similarity from which a name counts as a misspelling, for difflib."""


def _without_server(snapshot: Snapshot) -> Iterator[Problem]:
    """Report clients that wait for a server; a warning if the node has found another server."""
    wanted: defaultdict[str, list[str]] = defaultdict(list)
    for token, endpoint in endpoints(snapshot.ros.others, Kind.CLIENT):
        wanted[token.node.full_name].append(endpoint.name)
    there = {endpoint.name for _, endpoint in endpoints(snapshot.ros.tokens, Kind.SERVICE)}
    for node, names in sorted(wanted.items()):
        missing = collapsed(name for name in names if name not in there)
        if missing:
            yield Problem(
                "no_server",
                f"{node} waits for {first_few(missing)}, which has no server{_elsewhere(snapshot, missing)}",
                _advice(missing, there),
                "error" if all(name not in there for name in names) else "warning",
            )


def _different_types(snapshot: Snapshot) -> Iterator[Problem]:
    found: defaultdict[tuple[str, str, str], list[str]] = defaultdict(list)
    for token, endpoint in endpoints(snapshot.ros.others, *WANT):
        types = snapshot.ros.types.get(endpoint.name, set())
        theirs = (endpoint.type, endpoint.hash)
        if types and theirs not in types:
            ours = endpoint.name in snapshot.ros.simulator_types
            found[token.node.full_name, *difference(theirs, types, simulator=ours)].append(endpoint.name)
    for (node, what, remedy), names in sorted(found.items()):
        yield Problem("different_types", f"{node} is incompatible with {first_few(sorted(names))}: {what}", remedy)


def _elsewhere(snapshot: Snapshot, names: list[str]) -> str:
    """Return the part of a message about other domains that serve the names; empty if there are none."""
    domains = [str(n) for n, domain in snapshot.domains.items() if not set(collapsed(domain.types)).isdisjoint(names)]
    return f" in domain {snapshot.domain}, but in domain {', '.join(domains)}" if domains else ""


def _advice(missing: list[str], there: Iterable[str]) -> str:
    served = collapsed(there)
    # The node may have been started without a namespace.
    namespaces = sorted(
        {
            other.removesuffix(name).strip("/")
            for name in missing
            for other in served
            if name != other and other.endswith(name)
        }
    )
    if namespaces:
        return f"give it a namespace: {first_few(namespaces)}"
    close = (difflib.get_close_matches(name, served, n=1, cutoff=_CLOSE) for name in missing)
    meant = next((matches[0] for matches in close if matches), None)
    return f"did you mean {meant}?" if meant else "start the server, or correct the name, namespace or ROS_DOMAIN_ID"


def _in_other_domains(snapshot: Snapshot) -> Iterator[Problem]:
    """Report clients in another domain of services that the simulator has in this one."""
    ours = snapshot.ros.simulator_types
    for number, domain in snapshot.domains.items():
        if number == snapshot.domain or not ours:
            continue
        nodes = {
            token.node.full_name
            for token, endpoint in endpoints(domain.others, Kind.CLIENT)
            if endpoint.name in ours and endpoint.name not in domain.types
        }
        if nodes:
            yield Problem(
                "client_in_other_domain",
                f"{first_few(sorted(nodes))} in ROS domain {number} waits for services that the simulator has in "
                f"domain {snapshot.domain}",
                f"start them with ROS_DOMAIN_ID={snapshot.domain}, or the simulator with --ros-domain-id {number}",
            )


def ros2_problems(snapshot: Snapshot) -> Iterator[Problem]:
    """Yield the problems of ROS 2, in the order in which they should be solved."""
    for check in (
        _not_served,
        _missing_parts,
        _unknown_types,
        _two_servers,
        _without_server,
        _different_types,
        _in_other_domains,
    ):
        yield from check(snapshot)

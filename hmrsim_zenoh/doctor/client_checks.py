"""Checks of ROS clients and subscribers."""

from __future__ import annotations

import difflib
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.doctor.problem import Problem, some
from hmrsim_zenoh.doctor.snapshot import WANT, endpoints, whole
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.type_compat import difference

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Domain, Snapshot

_CLOSE: Final = 0.8
"""The similarity from which a name may be a misspelling of another, for difflib."""


def without_server(snapshot: Snapshot) -> Iterator[Problem]:
    """Report clients that wait for a server; only a warning for a node that has found another server."""
    wanted: defaultdict[str, list[str]] = defaultdict(list)
    for token, endpoint in endpoints(snapshot.ros.others, Kind.CLIENT):
        wanted[token.node.full_name].append(endpoint.name)
    there = {endpoint.name for _, endpoint in endpoints(snapshot.ros.tokens, Kind.SERVICE)}
    for node, names in sorted(wanted.items()):
        missing = whole(name for name in names if name not in there)
        if missing:
            yield Problem(
                "no_server",
                f"{node} waits for {some(missing)}, which has no server{_elsewhere(snapshot, missing)}",
                _advice(missing, there),
                "error" if all(name not in there for name in names) else "warning",
            )


def different_types(snapshot: Snapshot) -> Iterator[Problem]:
    """Report clients and subscribers whose types differ from the server's or publisher's."""
    found: defaultdict[tuple[str, str, str], list[str]] = defaultdict(list)
    for token, endpoint in endpoints(snapshot.ros.others, *WANT):
        types = snapshot.ros.types.get(endpoint.name, set())
        theirs = (endpoint.type, endpoint.hash)
        if types and theirs not in types:
            ours = endpoint.name in snapshot.ros.simulator_types
            found[token.node.full_name, *difference(theirs, types, simulator=ours)].append(endpoint.name)
    for (node, what, remedy), names in sorted(found.items()):
        yield Problem("different_types", f"{node} is incompatible with {some(sorted(names))}: {what}", remedy)


def _elsewhere(snapshot: Snapshot, names: list[str]) -> str:
    """Return the other domains that serve some of the names, as a part of a message; empty if there are none."""
    found = [str(number) for number, domain in snapshot.domains.items() if _serves(domain, names)]
    return f" in domain {snapshot.domain}, but in domain {', '.join(found)}" if found else ""


def _serves(domain: Domain, names: list[str]) -> bool:
    return not set(whole(domain.types)).isdisjoint(names)


def _advice(missing: list[str], there: Iterable[str]) -> str:
    served = whole(there)
    # The remedy for a node that was started without a namespace.
    namespaces = sorted(
        {
            other.removesuffix(name).strip("/")
            for name in missing
            for other in served
            if name != other and other.endswith(name)
        }
    )
    if namespaces:
        return f"give it a namespace: {some(namespaces)}"
    close = (difflib.get_close_matches(name, served, n=1, cutoff=_CLOSE) for name in missing)
    meant = next((matches[0] for matches in close if matches), None)
    return f"did you mean {meant}?" if meant else "start the server, or correct the name, namespace or ROS_DOMAIN_ID"


def in_other_domains(snapshot: Snapshot) -> Iterator[Problem]:
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
                f"{some(sorted(nodes))} in ROS domain {number} waits for services that the simulator has in domain "
                f"{snapshot.domain}",
                f"start them with ROS_DOMAIN_ID={snapshot.domain}, or the simulator with --ros-domain-id {number}",
            )


CHECKS: Final[tuple[Callable[[Snapshot], Iterator[Problem]], ...]] = (without_server, different_types, in_other_domains)

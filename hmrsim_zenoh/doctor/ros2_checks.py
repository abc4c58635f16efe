"""Checks of a simulator's endpoints in ROS."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.doctor.problem import Problem, some
from hmrsim_zenoh.doctor.snapshot import OFFER, endpoints, whole
from hmrsim_zenoh.ros2.keys import Kind
from hmrsim_zenoh.ros2.publishing.endpoints import FIRST
from hmrsim_zenoh.ros2.type_compat import known

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

    In a large fleet, actions other than `FIRST` are declared when a client looks for them.
    """
    return {name: parts for name, parts in _missing(snapshot).items() if not _is_later(snapshot, name, parts)}


def later_actions(snapshot: Snapshot) -> list[str]:
    """Return the actions that are declared when a client looks for them."""
    return [name for name, parts in _missing(snapshot).items() if _is_later(snapshot, name, parts)]


def _is_later(snapshot: Snapshot, name: str, missing: list[str]) -> bool:
    actions = snapshot.simulator.names.actions if snapshot.simulator else {}
    return len(missing) == len(_PARTS) and actions[name][1] != FIRST


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


def not_spoken(snapshot: Snapshot) -> Iterator[Problem]:
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
    elif snapshot.has_to_do_with_ros:
        yield Problem("no_ros2", "the simulator does not serve ROS 2", "start `hmrsim run` with --ros2")


def not_whole(snapshot: Snapshot) -> Iterator[Problem]:
    """Report actions that are incomplete in ROS."""
    incomplete = incomplete_actions(snapshot) if snapshot.ros.ours else {}
    if incomplete and snapshot.simulator is not None:
        most, every = len(_PARTS), len(snapshot.simulator.names.actions)
        listed = some(f"{name} ({', '.join(p)})" if len(p) < most else name for name, p in incomplete.items())
        yield Problem(
            "incomplete_actions",
            f"{len(incomplete)} of {every} actions are missing or incomplete: {listed}",
            "wait if the simulator has just started, else see its log",
        )


def unknown_types(snapshot: Snapshot) -> Iterator[Problem]:
    """Report types of the simulator whose hashes this version does not know."""
    strange = {
        endpoint.type
        for _, endpoint in endpoints(snapshot.ros.ours, *OFFER)
        if endpoint.hash not in known().get(endpoint.type, {endpoint.hash: ()})
    }
    if strange:
        yield Problem(
            "unknown_types",
            f"the simulator has types whose hashes this hmrsim does not know: {some(sorted(strange))}",
            "install the same version on both sides",
        )


def two_servers(snapshot: Snapshot) -> Iterator[Problem]:
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
            f"{len(programs)} programs serve {some(whole(names))} (nodes {some(sorted(nodes))}): "
            f"{'both' if len(programs) == 2 else 'all'} execute each goal and request",  # noqa: PLR2004 - both are two
            f"end one of them, or {_APART if ours else 'give it another ROS_DOMAIN_ID or other names'}",
        )


CHECKS: Final[tuple[Callable[[Snapshot], Iterator[Problem]], ...]] = (
    not_spoken,
    not_whole,
    unknown_types,
    two_servers,
)

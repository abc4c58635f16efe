"""Checks of the network: peers, environment variables, certificates, and access denied to ROS nodes."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import meant
from hmrsim_zenoh.doctor.snapshot import WANT, Problem, collapsed, endpoints, first_few
from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.codec.types import DISTROS
from hmrsim_zenoh.ros2.keys import DOMAINS, MAX_DOMAIN, Kind

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Snapshot
    from hmrsim_zenoh.wire.access_control import Message


_RMW: Final = "rmw_zenoh_cpp"
_ROLLING: Final = "rolling"
_FILE, _OVERRIDE = "ZENOH_SESSION_CONFIG_URI", "ZENOH_CONFIG_OVERRIDE"
_CONNECT: Final = re.compile(r"connect/endpoints\s*=\s*\[([^\]]*)\]")


def no_simulator(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that there is no simulator with the prefix."""
    if snapshot.simulator is not None:
        return
    if snapshot.prefixes:
        are = "is" if len(snapshot.prefixes) == 1 else "are"
        yield Problem(
            "other_prefix",
            f"no simulator has the prefix {snapshot.prefix!r}; there {are} {first_few(map(repr, snapshot.prefixes))}",
            f"use --prefix {meant(snapshot.prefix, snapshot.prefixes) or snapshot.prefixes[0]}",
        )
    else:
        yield Problem(
            "no_simulator",
            f"there are ROS nodes at {snapshot.where}, but no simulator",
            f"start {snapshot.command}",
        )


def no_router(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that ROS nodes can't discover each other without a router."""
    if snapshot.peers and not snapshot.routers and snapshot.uses_ros:
        yield Problem(
            "no_router",
            f"only a peer answers at {snapshot.where}, but ROS nodes need a router to discover each other",
            "start the simulator without --mode peer, or start `ros2 run rmw_zenoh_cpp rmw_zenohd` and the simulator "
            "with --connect",
        )


def other_middleware(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that ROS nodes of this shell do not use rmw_zenoh."""
    rmw = snapshot.environment.get("RMW_IMPLEMENTATION")
    if rmw == _RMW or not (rmw or "ROS_DISTRO" in snapshot.environment):
        return
    what = f"RMW_IMPLEMENTATION is {rmw!r}" if rmw else "ROS is set up, but RMW_IMPLEMENTATION is not set"
    yield Problem(
        "other_middleware",
        f"{what}: ROS nodes of this shell do not use rmw_zenoh_cpp",
        f"`export RMW_IMPLEMENTATION={_RMW}`",
    )


def other_distribution(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that the distribution of this shell is not supported."""
    distro = snapshot.environment.get("ROS_DISTRO", _ROLLING)
    if distro not in (*DISTROS, _ROLLING):
        yield Problem(
            "other_distribution",
            f"ROS_DISTRO is {distro!r}, which is not supported: its types have other hashes, or none",
            f"use {', '.join(DISTROS)}, in a container if need be",
        )


def other_domain(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that ROS nodes of this shell are in another domain than the requested one, or can't start."""
    text = snapshot.environment.get("ROS_DOMAIN_ID", "")
    if not text:
        return
    if text not in DOMAINS:
        yield Problem(
            "no_domain",
            f"ROS_DOMAIN_ID is {text[:20]!r}, which is not a domain id: ROS nodes of this shell do not start",
            f"`export ROS_DOMAIN_ID={snapshot.domain}`, or another from 0 to {MAX_DOMAIN}",
        )
    elif DOMAINS[text] != snapshot.domain:
        yield Problem(
            "domain_of_this_shell",
            f"ROS_DOMAIN_ID is {text}, but domain {snapshot.domain} was requested",
            f"for ROS nodes of this shell: `export ROS_DOMAIN_ID={snapshot.domain}`",
            "warning",
        )


def configuration(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that ROS nodes of this shell lack their configuration file, or may connect elsewhere."""
    for name in (_FILE, _OVERRIDE):
        text = snapshot.environment.get(name)
        if not text or _leads_here(text, snapshot.endpoints):
            continue
        if name == _FILE and not _is_file(text.removeprefix("file://")):
            yield Problem("no_configuration", f"{name} is {text[:100]!r}, but there is no such file", f"`unset {name}`")
        else:
            yield Problem(
                "own_configuration",
                f"{name} is {text!r}: ROS nodes of this shell may connect elsewhere",
                f"check that its connect/endpoints lead to {snapshot.where}, or `unset {name}`",
                "warning",
            )


def _leads_here(override: str, endpoints: Collection[str]) -> bool:
    """Return whether a configuration connects nodes to one of the endpoints."""
    return any(f'"{endpoint}"' in listed for listed in _CONNECT.findall(override) for endpoint in endpoints)


def _is_file(text: str) -> bool:
    try:
        return Path(text).is_file()
    except OSError:
        # A folder that can't be read, or a name that is too long.
        return False


def unreadable_tokens(snapshot: Snapshot) -> Iterator[Problem]:
    """Report unknown ROS liveliness tokens."""
    if snapshot.unreadable:
        yield Problem(
            "unreadable_tokens",
            f"{len(snapshot.unreadable)} liveliness tokens are not in rmw_zenoh's format: "
            f"{first_few(repr(text[:100]) for text in snapshot.unreadable)}",
            "update rmw_zenoh_cpp on the machines that declare them",
            "warning",
        )


_DAY: Final = 86_400.0
_SOON: Final = 14
"""Days before its expiration from which a certificate is reported."""

_ASKS: Final[dict[Kind, Message]] = {Kind.CLIENT: "query", Kind.SUBSCRIBER: "declare_subscriber"}


def expiring(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that this session's certificate will expire soon."""
    enclave = snapshot.enclave
    if enclave and enclave.left < _SOON * _DAY:
        yield Problem(
            "certificate_expires",
            f"the certificate of {enclave.name!r} expires on {enclave.member.expires[:10]}",
            f"`hmrsim security renew DIR {enclave.name}`, and copy the enclave to where it is used",
            "warning",
        )


def denied(snapshot: Snapshot) -> Iterator[Problem]:
    """Report ROS clients and subscribers whose certificates do not allow access to the simulator."""
    if snapshot.enclave is None:
        return
    policy, ours = snapshot.enclave.access_control, snapshot.ros.simulator_types
    found: defaultdict[tuple[str, str, str], list[tuple[str, str]]] = defaultdict(list)
    for token, endpoint in endpoints(snapshot.ros.others, *WANT):
        name = snapshot.names.get(token.session)
        if name is None or endpoint.name not in ours:
            continue
        key = keys.key(snapshot.domain, endpoint.name, endpoint.type, endpoint.hash)
        decision = policy.decide(name, _ASKS[endpoint.kind], "ingress", key)
        if not decision.allowed:
            found[token.node.full_name, name, str(decision)].append((endpoint.name, key))
    for (node, name, why), wanted in sorted(found.items()):
        others = [each for each in policy.rules if all(policy.may_query(each, key).allowed for _, key in wanted)]
        names = first_few(collapsed(each for each, _ in wanted))
        yield Problem(
            "denied",
            f"{node}, with the certificate of {name!r}, may not use {names}: {why}",
            f"use the enclave of {' or '.join(others) or 'an operator'}, or `hmrsim security add` one that may",
        )


CHECKS: Final[tuple[Callable[[Snapshot], Iterator[Problem]], ...]] = (
    no_simulator,
    no_router,
    other_middleware,
    other_distribution,
    other_domain,
    configuration,
    unreadable_tokens,
    expiring,
    denied,
)

"""Checks of certificates, and of what access control denies to ROS nodes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.doctor.problem import Problem, some
from hmrsim_zenoh.doctor.snapshot import WANT, endpoints, whole
from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import Kind

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Snapshot
    from hmrsim_zenoh.wire.access_control import Message

_DAY: Final = 86_400.0
_SOON: Final = 14
"""Days before its end from which a certificate is reported."""

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
    """Report clients and subscribers of ROS whose certificates do not allow what they want of the simulator."""
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
        yield Problem(
            "denied",
            f"{node}, with the certificate of {name!r}, may not use {some(whole(each for each, _ in wanted))}: {why}",
            f"use the enclave of {' or '.join(others) or 'an operator'}, or `hmrsim security add` one that may",
        )


CHECKS: Final[tuple[Callable[[Snapshot], Iterator[Problem]], ...]] = (expiring, denied)

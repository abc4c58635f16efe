"""Diagnosis of a network: a snapshot taken with read-only queries, and the problems in it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.connection import PATIENCE
from hmrsim_zenoh.doctor.network_checks import network_problems
from hmrsim_zenoh.doctor.ros2_checks import ros2_problems
from hmrsim_zenoh.doctor.snapshot import Simulator, Snapshot
from hmrsim_zenoh.errors import ConnectionDenied, RequestError, RequestTimeout, SimulatorNotFound, Unreachable
from hmrsim_zenoh.ros2.keys import DOMAINS, read_token
from hmrsim_zenoh.wire.descriptions import SessionsInfo, TimeInfo, TreeInfo, described
from hmrsim_zenoh.wire.envelopes import UnreadableError
from hmrsim_zenoh.wire.session import enclave_of, encrypted

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Problem
    from hmrsim_zenoh.ros2.keys import Token
    from hmrsim_zenoh.wire.options import SessionOptions


_WATCH: Final = 0.5
"""Wall seconds between the two readings of the clock."""
_ANY_DOMAIN: Final = "@ros2_lv/**"
_ANY_SIMULATOR: Final = "**/_world/alive"

_OURS: Final = ("ROS_", "RMW_", "ZENOH_")


def requested(
    options: SessionOptions, *, domain: int, environment: Mapping[str, str], wants_ros: bool = False
) -> Snapshot:
    """Return the snapshot before any query, with the options only.

    Args:
        options: The session options.
        domain: ROS's domain id.
        environment: Environment variables, of which those of ROS and Zenoh are kept.
        wants_ros: Whether the user works with ROS.
    """
    file = (str(options.zenoh_config),) if options.zenoh_config else ()
    enclave = enclave_of(options)
    default = options.default if enclave is None else encrypted(options.default)
    return Snapshot(
        endpoints=options.connect or options.listen or file or (default,),
        enclave=enclave,
        prefix=options.prefix,
        domain=domain,
        environment={name: value for name, value in sorted(environment.items()) if name.startswith(_OURS) and value},
        wants_ros=wants_ros,
    )


def gather(options: SessionOptions, asked: Snapshot) -> Snapshot:
    """Return the snapshot with the findings on the network.

    Raises:
        SimulatorNotFound: No peer answers at the endpoints, or none is a simulator or a ROS node.
        BadOptions, PortTaken: The session can't be opened.
        SimulatorGone, Unreachable, RequestError, RequestTimeout, UnreadableError: The simulator does not answer.
    """
    with Client(options, clock="realtime", acknowledge_timeout=options.timeout) as client:
        if options.listen or options.mode not in (None, "client"):
            # Peers connect to this session or learn of it from others, which takes a while.
            with suppress(SimulatorNotFound):
                client.wait_for_simulator(options.timeout)
        prefixes = tuple(sorted(token.removesuffix(f"/{WORLD}/alive") for token in _tokens(client, _ANY_SIMULATOR)))
        simulator = _simulator(client, options.timeout) if options.prefix in prefixes else None
        tokens, unreadable = _of_ros(_tokens(client, _ANY_DOMAIN))
        names = _names(client, options.timeout) if asked.enclave and simulator else {}
        info = client.session.info
        routers, peers = (tuple(map(str, each)) for each in (info.routers_zid(), info.peers_zid()))
    if not (prefixes or tokens or unreadable):
        if asked.enclave and (routers or peers):
            raise ConnectionDenied(
                f"{asked.where} lets {asked.enclave.name!r} in, but shows nothing: the policy has no such member, "
                "or has it revoked; restart the simulator if it was added since"
            )
        who = "a Zenoh peer answers" if routers or peers else "no peer connects"
        raise SimulatorNotFound(
            f"{asked.where}: {who}, but there is no simulator and no ROS node; start {asked.command}"
        )
    return replace(
        asked,
        routers=routers,
        peers=peers,
        prefixes=prefixes,
        simulator=simulator,
        tokens=tokens,
        unreadable=unreadable,
        names=names,
    )


def _simulator(client: Client, timeout: float) -> Simulator:
    keys = client.keys
    begin = time.monotonic()
    first = _time(client, timeout)
    robots = {keys.owner(token) for token in _tokens(client, keys.alive("*"))}
    participants = {token.rpartition("/")[2] for token in _tokens(client, keys.participants())}
    trees = {
        keys.owner(key): described(key, body, TreeInfo) for key, body in client.get_all(keys.trees(), timeout).items()
    }
    info, sessions = client.info(timeout), _sessions(client, timeout)
    # Time that has not moved within this interval counts as standing still.
    time.sleep(max(0.0, begin + _WATCH - time.monotonic()))
    return Simulator(
        info=info,
        session=next(iter(sessions), ""),
        twins=tuple(sessions[1:]),
        times=(first, _time(client, timeout)),
        watched=time.monotonic() - begin,
        alive=frozenset(robots - {WORLD}),
        tokens=frozenset(participants),
        trees=trees,
    )


def _names(client: Client, timeout: float) -> dict[str, str]:
    """Return the names on the certificates of the sessions that are connected to the simulator."""
    key = client.keys.world("sessions")
    try:
        found = described(key, client.get(key, timeout), SessionsInfo).get("sessions", ())
        return {one["session"]: one["name"] for one in found}
    except (RequestError, Unreachable, UnreadableError):
        # A simulator whose Zenoh configuration has access control may deny this query.
        return {}


def _time(client: Client, timeout: float) -> dict[str, Any]:
    key = client.keys.world("time/state")
    return described(key, client.get(key, timeout), TimeInfo)


def _sessions(client: Client, timeout: float) -> list[str]:
    """Return the Zenoh ids of all sessions that answer as the simulator."""
    replies = client.session.get(
        client.keys.world("info"),
        target=zenoh.QueryTarget.ALL,
        consolidation=zenoh.ConsolidationMode.NONE,
        timeout=timeout,
    )
    return list(dict.fromkeys(str(reply.replier_id.zid) for reply in replies if reply.ok and reply.replier_id))


def _tokens(client: Client, pattern: str) -> list[str]:
    """Return all matching tokens; with a hundred robots this takes seconds on a busy machine."""
    found = []
    for reply in client.session.liveliness().get(pattern, timeout=PATIENCE):
        if reply.ok is None:
            raise RequestTimeout(f"no reply to the query for liveliness tokens {pattern!r} in {PATIENCE:g} s")
        found.append(str(reply.ok.key_expr))
    return sorted(found)


def _of_ros(texts: list[str]) -> tuple[dict[int, tuple[Token, ...]], tuple[str, ...]]:
    """Return the tokens of each domain, and the unreadable ones."""
    found: dict[int, list[Token]] = {}
    unreadable = []
    for text in texts:
        token = read_token(text)
        domain = DOMAINS.get(text.split("/")[1]) if token else None
        if token is None or domain is None:
            unreadable.append(text)
        else:
            found.setdefault(domain, []).append(token)
    return {domain: tuple(tokens) for domain, tokens in found.items()}, tuple(unreadable)


def problems(snapshot: Snapshot) -> list[Problem]:
    """Return the problems of a snapshot in the order in which they should be solved; errors first."""
    found = chain(network_problems(snapshot), ros2_problems(snapshot))
    return sorted(found, key=lambda problem: problem.severity != "error")

"""Checks of the network and of simulators, from their clients' view."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

import hmrsim
from hmrsim.diagnostics import meant
from hmrsim_zenoh.doctor.snapshot import WANT, Problem, collapsed, endpoints, first_few
from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.codec.types import DISTROS
from hmrsim_zenoh.ros2.keys import DOMAINS, MAX_DOMAIN, Kind

if TYPE_CHECKING:
    from hmrsim_zenoh.doctor.snapshot import Simulator, Snapshot
    from hmrsim_zenoh.wire.access_control import Message


_RMW: Final = "rmw_zenoh_cpp"
_ROLLING: Final = "rolling"
_FILE, _OVERRIDE = "ZENOH_SESSION_CONFIG_URI", "ZENOH_CONFIG_OVERRIDE"
_CONNECT: Final = re.compile(r"connect/endpoints\s*=\s*\[([^\]]*)\]")


def _no_simulator(snapshot: Snapshot) -> Iterator[Problem]:
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


def _no_router(snapshot: Snapshot) -> Iterator[Problem]:
    if snapshot.peers and not snapshot.routers and snapshot.uses_ros:
        yield Problem(
            "no_router",
            f"only a peer answers at {snapshot.where}, but ROS nodes need a router to discover each other",
            "start the simulator without --mode peer, or start `ros2 run rmw_zenoh_cpp rmw_zenohd` and the simulator "
            "with --connect",
        )


def _other_middleware(snapshot: Snapshot) -> Iterator[Problem]:
    rmw = snapshot.environment.get("RMW_IMPLEMENTATION")
    if rmw == _RMW or not (rmw or "ROS_DISTRO" in snapshot.environment):
        return
    what = f"RMW_IMPLEMENTATION is {rmw!r}" if rmw else "ROS is set up, but RMW_IMPLEMENTATION is not set"
    yield Problem(
        "other_middleware",
        f"{what}: ROS nodes of this shell do not use rmw_zenoh_cpp",
        f"`export RMW_IMPLEMENTATION={_RMW}`",
    )


def _other_distribution(snapshot: Snapshot) -> Iterator[Problem]:
    distro = snapshot.environment.get("ROS_DISTRO", _ROLLING)
    if distro not in (*DISTROS, _ROLLING):
        yield Problem(
            "other_distribution",
            f"ROS_DISTRO is {distro!r}, which is not supported: its types have other hashes, or none",
            f"use {', '.join(DISTROS)}, in a container if need be",
        )


def _other_domain(snapshot: Snapshot) -> Iterator[Problem]:
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


def _configuration(snapshot: Snapshot) -> Iterator[Problem]:
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


def _unreadable_tokens(snapshot: Snapshot) -> Iterator[Problem]:
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


def _expiring(snapshot: Snapshot) -> Iterator[Problem]:
    enclave = snapshot.enclave
    if enclave and enclave.left < _SOON * _DAY:
        yield Problem(
            "certificate_expires",
            f"the certificate of {enclave.name!r} expires on {enclave.member.expires[:10]}",
            f"`hmrsim security renew DIR {enclave.name}`, and copy the enclave to where it is used",
            "warning",
        )


def _denied(snapshot: Snapshot) -> Iterator[Problem]:
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


_PLANNER: Final = "_planner"
"""The external planner's name in ``waiting_for``."""


def _twins(simulator: Simulator) -> Iterator[Problem]:
    if simulator.twins:
        yield Problem(
            "two_simulators",
            f"{len(simulator.twins) + 1} simulators have the same prefix: a request may reach any of them, or all",
            "end one of them, or start it with another --prefix",
        )


def _contract(simulator: Simulator) -> Iterator[Problem]:
    theirs = simulator.info.get("contract")
    if theirs != hmrsim.CONTRACT:
        yield Problem(
            "contract",
            f"the simulator (hmrsim {simulator.info.get('hmrsim')}) has contract {theirs}, this hmrsim "
            f"{hmrsim.__version__} has contract {hmrsim.CONTRACT}",
            "install the same version on both sides",
        )


def _robots(simulator: Simulator) -> Iterator[Problem]:
    if not simulator.robots:
        yield Problem("no_robots", "the world has no robots", "add one: `hmrsim run WORLD --robot NAME@X,Y`")
    idle = [robot for robot, actions in simulator.robots.items() if not actions]
    if idle:
        yield Problem(
            "no_actions",
            f"{first_few(idle)} can do nothing: there are no actions",
            "give a base or other components in the world file",
        )


def _tokens(simulator: Simulator) -> Iterator[Problem]:
    if simulator.lost:
        are = "is" if len(simulator.lost) == 1 else "are"
        yield Problem(
            "no_token",
            f"{first_few(simulator.lost)} {are} unreachable: there is no liveliness token, and goals are rejected",
            "list faults with `hmrsim service call /_world/get_faults`; /_world/clear_fault clears one",
        )


def _time_stands(simulator: Simulator) -> Iterator[Problem]:
    time = simulator.time
    if time.get("paused"):
        yield Problem(
            "paused",
            f"time stands at {time.get('now'):.9g} s: it is paused",
            "`hmrsim service call /_world/set_simulation_state '{state: {state: 1}}'`",
        )
        return
    awaited = list(time.get("waiting_for", ()))
    if not awaited or any(each.get("now") != time.get("now") for each in simulator.times):
        return
    stands = f"time stands at {time.get('now'):.9g} s"
    if _PLANNER in awaited:
        yield Problem(
            "time_stands",
            f"{stands}: the external planner has not answered yet",
            "check the planner; the goal is aborted after --planner-timeout",
        )
    elif set(awaited) <= set(time.get("participants", ())):
        yield Problem(
            "time_stands",
            f"{stands}, for {simulator.watched:.1g} s at least: waiting for {first_few(awaited)} to advance",
            "check these participants; they are dropped after --participant-timeout",
        )
    else:
        here = time.get("participants", ())
        # "2 to join" stands for participants without known names.
        joining = (name.removesuffix(" to join") for name in awaited if name not in here)
        yield Problem(
            "time_stands",
            f"{stands}: waiting for {first_few(joining)} to join in lockstep",
            "start a controller, such as `bt-controller run TREE --robot NAME --name PARTICIPANT`, or run with "
            "`--clock realtime`",
        )


def _lag(simulator: Simulator) -> Iterator[Problem]:
    lags = [time.get("lag", 0.0) for time in simulator.times]
    if lags and lags[-1] > lags[0]:
        yield Problem(
            "lag",
            f"the machine can't keep up: simulated time lags by {lags[-1]:.1f} wall seconds, and the lag grows",
            "lower --real-time-factor, or reduce robots, rates or subscribers",
        )


def _planner(simulator: Simulator) -> Iterator[Problem]:
    waiting = [robot["name"] for robot in simulator.info.get("robots", ()) if robot.get("planner") == "external"]
    if waiting and not simulator.info.get("planner_present"):
        yield Problem(
            "no_planner",
            f"{first_few(waiting)} {'needs' if len(waiting) == 1 else 'need'} an external planner, but there is none",
            "start one; see `An external planner` in docs/reference/keys.md",
        )


def network_problems(snapshot: Snapshot) -> Iterator[Problem]:
    """Yield the problems of the network and its simulator, in the order in which they should be solved."""
    for check in (
        _no_simulator,
        _no_router,
        _other_middleware,
        _other_distribution,
        _other_domain,
        _configuration,
        _unreadable_tokens,
        _expiring,
        _denied,
    ):
        yield from check(snapshot)
    if snapshot.simulator is not None:
        for of_simulator in (_twins, _contract, _robots, _tokens, _planner, _time_stands, _lag):
            yield from of_simulator(snapshot.simulator)

"""Checks of the network: the peers at the endpoints, and the environment variables."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.doctor.problem import Problem, some
from hmrsim_zenoh.ros2.codec.distros import DISTROS
from hmrsim_zenoh.ros2.keys import DOMAINS, MAX_DOMAIN

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from hmrsim_zenoh.doctor.snapshot import Snapshot

_RMW: Final = "rmw_zenoh_cpp"
_ROLLING: Final = "rolling"
_FILE, _OVERRIDE = "ZENOH_SESSION_CONFIG_URI", "ZENOH_CONFIG_OVERRIDE"
_CONNECT: Final = re.compile(r"connect/endpoints\s*=\s*\[([^\]]*)\]")


def no_simulator(snapshot: Snapshot) -> Iterator[Problem]:
    """Tell that the simulator which was asked for is not there."""
    if snapshot.simulator is not None:
        return
    if snapshot.prefixes:
        yield Problem(
            "other_prefix",
            f"no simulator has the prefix {snapshot.prefix!r}; there is {some(map(repr, snapshot.prefixes))}",
            f"ask with --prefix {snapshot.prefixes[0]}",
        )
    else:
        yield Problem(
            "no_simulator",
            f"there are ROS nodes at {snapshot.where}, but no simulator",
            f"start {snapshot.command}",
        )


def no_router(snapshot: Snapshot) -> Iterator[Problem]:
    """Report that ROS nodes can't discover each other without a router."""
    if snapshot.peers and not snapshot.routers and snapshot.has_to_do_with_ros:
        yield Problem(
            "no_router",
            f"who answers at {snapshot.where} is a peer, and ROS nodes find one another by a router",
            "start the simulator without --mode peer, or `ros2 run rmw_zenoh_cpp rmw_zenohd` and it with --connect",
        )


def other_middleware(snapshot: Snapshot) -> Iterator[Problem]:
    """Tell that ROS nodes started here would not speak over Zenoh."""
    said = snapshot.environment.get("RMW_IMPLEMENTATION")
    if said == _RMW or not (said or "ROS_DISTRO" in snapshot.environment):
        return
    what = f"RMW_IMPLEMENTATION is {said!r}" if said else "ROS is set up, and RMW_IMPLEMENTATION is not"
    yield Problem(
        "other_middleware",
        f"{what}: ROS nodes of this shell do not speak over Zenoh",
        f"`export RMW_IMPLEMENTATION={_RMW}`",
    )


def other_distribution(snapshot: Snapshot) -> Iterator[Problem]:
    """Tell that the distribution of this shell is not served."""
    said = snapshot.environment.get("ROS_DISTRO", _ROLLING)
    if said not in (*DISTROS, _ROLLING):
        yield Problem(
            "other_distribution",
            f"ROS_DISTRO is {said!r}, which is not served: its types have other hashes, or none",
            f"use {', '.join(DISTROS)}, in a container if need be",
        )


def other_domain(snapshot: Snapshot) -> Iterator[Problem]:
    """Tell that ROS nodes started here are in another domain than the one that was asked for, or in none."""
    said = snapshot.environment.get("ROS_DOMAIN_ID", "")
    if not said:
        return
    if said not in DOMAINS:
        yield Problem(
            "no_domain",
            f"ROS_DOMAIN_ID is {said[:20]!r}, which is no domain: ROS nodes of this shell do not start",
            f"`export ROS_DOMAIN_ID={snapshot.domain}`, or another from 0 to {MAX_DOMAIN}",
        )
    elif DOMAINS[said] != snapshot.domain:
        yield Problem(
            "domain_of_this_shell",
            f"ROS_DOMAIN_ID is {said}, and domain {snapshot.domain} was asked for",
            f"for ROS nodes of this shell: `export ROS_DOMAIN_ID={snapshot.domain}`",
            "warning",
        )


def configuration(snapshot: Snapshot) -> Iterator[Problem]:
    """Tell that ROS nodes started here fail, as their configuration is not there, or may connect elsewhere."""
    for name in (_FILE, _OVERRIDE):
        said = snapshot.environment.get(name)
        if not said or _leads_here(said, snapshot.endpoints):
            continue
        if name == _FILE and not _is_file(said.removeprefix("file://")):
            yield Problem("no_configuration", f"{name} is {said[:100]!r}, and there is no such file", f"`unset {name}`")
        else:
            yield Problem(
                "own_configuration",
                f"{name} is {said!r}: ROS nodes of this shell may connect elsewhere",
                f"see that its connect/endpoints lead to {snapshot.where}, or `unset {name}`",
                "warning",
            )


def _leads_here(override: str, endpoints: Collection[str]) -> bool:
    """Return whether nodes connect to where we look."""
    return any(f'"{endpoint}"' in said for said in _CONNECT.findall(override) for endpoint in endpoints)


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
            f"{len(snapshot.unreadable)} liveliness tokens are none of rmw_zenoh's: "
            f"{some(repr(text[:100]) for text in snapshot.unreadable)}",
            "update rmw_zenoh_cpp where they come from",
            "warning",
        )


CHECKS: Final[tuple[Callable[[Snapshot], Iterator[Problem]], ...]] = (
    no_simulator,
    no_router,
    other_middleware,
    other_distribution,
    other_domain,
    configuration,
    unreadable_tokens,
)

"""What the commands of ``hmrsim security`` do that need the authority."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING, Any

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import show, show_json
from hmrsim_zenoh.settings import ROS_DOMAIN_ID, domain_id
from hmrsim_zenoh.wire.enclave import SIMULATOR, Member

try:
    from hmrsim_zenoh.security.keystore import Keystore, Network, own_hosts
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "cryptography":
        raise
    raise WrongUse("hmrsim security needs a package that is not installed; pip install 'hmrsim[security]'") from None

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path


def controller(text: str) -> Member:
    """Return the controller that ``NAME=ROBOT,ROBOT`` describes."""
    name, equals, robots = text.partition("=")
    named = tuple(robot for robot in robots.split(",") if robot)
    if equals and not named:
        raise argparse.ArgumentTypeError(f"{text!r} names no robots; expected NAME=ROBOT,ROBOT, or NAME for all")
    return Member(name, "controller", tuple(dict.fromkeys(named)))


def create(args: argparse.Namespace) -> int:
    """Make a keystore."""
    given = args.ros_domain_id
    domain = given if given is not None else _domain()
    hosts = tuple(dict.fromkeys([*args.host, *own_hosts()]))
    members = [
        Member(SIMULATOR, SIMULATOR),
        *(args.controller or [Member("controller", "controller")]),
        Member("viewer", "viewer"),
        Member("operator", "operator"),
    ]
    store = Keystore.create(
        args.keystore, members, Network(args.prefix, domain, hosts), days=args.days, force=args.force
    )
    if args.json:
        show_json(_as_json(store))
    else:
        show(f"made {store.path}: {', '.join(map(described, store.members.values()))}")
        show(f"valid until {_until(store.members.values())}, at {', '.join(hosts)}")
        show(f"next: hmrsim run WORLD --secure {store.path}")
    return ExitCode.DONE


def add(args: argparse.Namespace) -> int:
    """Add an enclave."""
    if args.role != "controller" and (args.robot or args.service):
        raise WrongUse(f"--robot and --service are for controllers, not for a {args.role}")
    store = keystore(args.keystore)
    store.add(Member(args.name, args.role, tuple(args.robot), tuple(args.service)), args.days)
    member = store.members[args.name]
    _tell(args, store, f"added {described(member)}, valid until {_until([member])}; restart the simulator")
    return ExitCode.DONE


def renew(args: argparse.Namespace) -> int:
    """Make new certificates."""
    store = keystore(args.keystore)
    names = store.renew(args.names, args.days)
    _tell(args, store, f"renewed {', '.join(names)}; valid until {_until(store.members[name] for name in names)}")
    return ExitCode.DONE


def revoke(args: argparse.Namespace) -> int:
    """Take all rights from an enclave."""
    store = keystore(args.keystore)
    store.revoke(args.name)
    _tell(args, store, f"revoked {args.name}; restart the simulator and `hmrsim view`, which know the old policy")
    return ExitCode.DONE


def keystore(folder: Path) -> Keystore:
    """Return the keystore in a folder."""
    return Keystore(folder)


def described(member: Member) -> str:
    """Return a member as text."""
    if member.role != "controller":
        return member.name if member.name == member.role else f"{member.name} ({member.role})"
    further = f", {', '.join(member.services)}" if member.services else ""
    return f"{member.name} (controller of {', '.join(member.robots) or 'all robots'}{further})"


def _tell(args: argparse.Namespace, store: Keystore, text: str) -> None:
    if args.json:
        show_json(_as_json(store))
    else:
        show(text)


def _as_json(store: Keystore) -> dict[str, Any]:
    return {
        "keystore": str(store.path),
        "prefix": store.network.prefix,
        "ros_domain_id": store.network.domain,
        "hosts": store.network.hosts,
        "enclaves": [member.to_json() for member in store.members.values()],
        "revoked": store.revoked,
    }


def _until(members: Iterable[Member]) -> str:
    return min(member.expires for member in members)[:10]


def _domain() -> int:
    try:
        return domain_id(os.environ.get(ROS_DOMAIN_ID) or "0")
    except ValueError as error:
        raise WrongUse(f"{ROS_DOMAIN_ID}: {error}") from None

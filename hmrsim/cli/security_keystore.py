"""The commands of ``hmrsim security`` that need the keystore's authority."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.options import ros_domain_of_environment
from hmrsim.cli.output import columns, show_result
from hmrsim.cli.security_policy import folder_of_environment
from hmrsim.settings.arguments import read_settings, reader_of
from hmrsim_zenoh.settings import Ros2Settings
from hmrsim_zenoh.wire.enclave import SIMULATOR, Member
from hmrsim_zenoh.wire.options import SessionOptions

try:
    from hmrsim_zenoh.security.check import attempts
    from hmrsim_zenoh.security.keystore import Keystore, Network, own_hosts
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "cryptography":
        raise
    raise WrongUse("hmrsim security needs a package that is not installed; pip install 'hmrsim[security]'") from None

if TYPE_CHECKING:
    from collections.abc import Iterable

ros_domain_id = reader_of(Ros2Settings, "ros_domain_id")
"""Reads the value of ``--ros-domain-id``."""


def controller(text: str) -> Member:
    """Return the controller described by ``NAME=ROBOT,ROBOT``."""
    name, equals, names = text.partition("=")
    robots = tuple(robot for robot in names.split(",") if robot)
    if equals and not robots:
        raise argparse.ArgumentTypeError(f"{text!r} names no robots; expected NAME=ROBOT,ROBOT, or NAME for all")
    return Member(name, "controller", tuple(dict.fromkeys(robots)))


def create(args: argparse.Namespace) -> int:
    """Create a keystore; return the exit code."""
    given = args.ros_domain_id
    domain = given if given is not None else ros_domain_of_environment()
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
    lines = (
        f"made {store.path}: {', '.join(map(described, store.members.values()))}",
        f"valid until {_until(store.members.values())}, at {', '.join(hosts)}",
        f"next: hmrsim run WORLD --secure {store.path}",
    )
    show_result(_as_json(store), lines, as_json=args.json)
    return ExitCode.DONE


def add(args: argparse.Namespace) -> int:
    """Add an enclave; return the exit code."""
    if args.role != "controller" and (args.robot or args.service):
        raise WrongUse(f"--robot and --service are for controllers, not for a {args.role}")
    store = Keystore(args.keystore)
    store.add(Member(args.name, args.role, tuple(args.robot), tuple(args.service)), args.days)
    member = store.members[args.name]
    show_result(
        _as_json(store),
        f"added {described(member)}, valid until {_until([member])}; restart the simulator",
        as_json=args.json,
    )
    return ExitCode.DONE


def renew(args: argparse.Namespace) -> int:
    """Create new certificates; return the exit code."""
    store = Keystore(args.keystore)
    names = store.renew(args.names, args.days)
    show_result(
        _as_json(store),
        f"renewed {', '.join(names)}; valid until {_until(store.members[name] for name in names)}",
        as_json=args.json,
    )
    return ExitCode.DONE


def revoke(args: argparse.Namespace) -> int:
    """Take all rights from an enclave; return the exit code."""
    store = Keystore(args.keystore)
    store.revoke(args.name)
    show_result(
        _as_json(store),
        f"revoked {args.name}; restart the simulator and `hmrsim view`, which know the old policy",
        as_json=args.json,
    )
    return ExitCode.DONE


def described(member: Member) -> str:
    """Return a member as text."""
    if member.role != "controller":
        return member.name if member.name == member.role else f"{member.name} ({member.role})"
    further = f", {', '.join(member.services)}" if member.services else ""
    return f"{member.name} (controller of {', '.join(member.robots) or 'all robots'}{further})"


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


def check(args: argparse.Namespace) -> int:
    """Try what each enclave may do at a running simulator; return 1 if the simulator does not enforce the policy."""
    store = Keystore(args.keystore or folder_of_environment())
    tried = list(attempts(store, read_settings(args, SessionOptions)))
    wrong = sum(not attempt.as_expected for attempt in tried)
    facts = [
        {"who": attempt.who, "what": attempt.what, "allowed": attempt.expected, "done": attempt.done}
        for attempt in tried
    ]
    verdicts = {True: "allows", False: "denies"}
    rows = [("who", "tries", "policy", "simulator", "")]
    rows += [
        (
            attempt.who,
            attempt.what,
            verdicts[attempt.expected],
            verdicts[attempt.done],
            "" if attempt.as_expected else "WRONG",
        )
        for attempt in tried
    ]
    text = "it does not enforce the policy; restart it" if wrong else "the simulator enforces the policy"
    total = f"{len(tried) - wrong} of {len(tried)} as the policy says: {text}"
    show_result({"attempts": facts, "wrong": wrong}, (*columns(rows), total), as_json=args.json)
    return ExitCode.FAILED if wrong else ExitCode.DONE

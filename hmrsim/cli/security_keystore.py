"""The commands of ``hmrsim security`` on keystores, and ``explain``: who may do what on a key."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import zenoh

from hmrsim.cli.options import ExitCode, WrongUse, ros_domain_of_environment
from hmrsim.cli.output import columns, show_result
from hmrsim.cli.security import VARIABLE
from hmrsim.settings.arguments import read_settings, reader_of
from hmrsim_zenoh.settings import Ros2Settings
from hmrsim_zenoh.wire.enclave import DESCRIPTION, ENCLAVES, SIMULATOR, Member, enclaves, find_enclave, read_enclave
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hmrsim_zenoh.wire.access_control import AccessControl, Decision, Message
    from hmrsim_zenoh.wire.enclave import Enclave


_ASKS: Final[Mapping[str, tuple[Message, Message]]] = {
    "ask": ("query", "reply"),
    "subscribe": ("declare_subscriber", "put"),
}
"""Operations of a client, with the message that it sends and the one that it receives."""
_DOES: Final[Mapping[str, Message]] = {
    "publish": "put",
    "answer": "declare_queryable",
    "be present": "liveliness_token",
    "see presence": "declare_liveliness_subscriber",
}
"""Operations of a client to which no message is returned."""

_KEY_AND_ROLE: Final = 2
"""The number of words without the folder."""


def explain(args: argparse.Namespace) -> int:
    """Print who may do what on a key, and by which rule; return the exit code."""
    folder, text, role = _parsed(args.words)
    try:
        key = str(zenoh.KeyExpr(text))
    except zenoh.ZError:
        raise WrongUse(f"{text!r} is not a key expression; chunks are joined by single slashes") from None
    chosen = _chosen(folder, role)
    policy = chosen[0].access_control
    alone = (folder / DESCRIPTION).exists() and role is None
    names = list(policy.rules) if alone else [enclave.name for enclave in chosen]
    decided = {name: decisions(policy, name, key) for name in names}
    facts = {
        name: {what: {"allowed": decision.allowed, "rule": decision.rule} for what, decision in each.items()}
        for name, each in decided.items()
    }
    rows = [
        (
            name,
            "may" if decision.allowed else "may not",
            what,
            f"rule {decision.rule!r}" if decision.rule else "no rule allows it",
        )
        for name, each in decided.items()
        for what, decision in each.items()
    ]
    show_result({"key": key, "enclaves": facts}, columns(rows), as_json=args.json)
    return ExitCode.DONE


def decisions(policy: AccessControl, name: str, key: str) -> dict[str, Decision]:
    """Return the policy's decision on each operation of a client on a key."""
    decided = {}
    for what, (sent, received) in _ASKS.items():
        first, second = policy.decide(name, sent, "ingress", key), policy.decide(name, received, "egress", key)
        decided[what] = second if first.allowed and not second.allowed else first
    return decided | {what: policy.decide(name, message, "ingress", key) for what, message in _DOES.items()}


def _parsed(words: Sequence[str]) -> tuple[Path, str, str | None]:
    """Return the folder, the key, and the role if given.

    Raises:
        WrongUse: There are too many words, or too few.
    """
    rest = list(words)
    first = Path(rest[0])
    if len(rest) > _KEY_AND_ROLE or (first / DESCRIPTION).exists() or (first / ENCLAVES).exists():
        folder = Path(rest.pop(0))
    else:
        folder = folder_of_environment()
    if not 1 <= len(rest) <= _KEY_AND_ROLE:
        raise WrongUse("expected [DIR] KEY [ROLE], such as keys hmrsim/wall_e/odom viewer")
    return folder, rest[0], rest[1] if len(rest) > 1 else None


def _chosen(folder: Path, role: str | None) -> list[Enclave]:
    if role is not None:
        return [find_enclave(folder, role)]
    if (folder / DESCRIPTION).exists():
        return [read_enclave(folder)]
    return enclaves(folder) or [find_enclave(folder, "")]


def folder_of_environment() -> Path:
    """Return the keystore's folder from the environment.

    Raises:
        WrongUse: The environment does not name one.
    """
    folder = os.environ.get(VARIABLE, "")
    if not folder:
        raise WrongUse(f"no keystore; name its folder DIR, or set {VARIABLE}=DIR")
    return Path(folder)


try:
    from hmrsim_zenoh.security.check import attempts
    from hmrsim_zenoh.security.keystore import Keystore, Network, own_hosts
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] != "cryptography":
        raise
    raise WrongUse("hmrsim security needs a package that is not installed; pip install 'hmrsim[security]'") from None


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

"""``hmrsim security``: keystores, which restrict who may drive robots."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import (
    ExitCode,
    WrongUse,
    add_json,
    add_ros_domain,
    number_in,
    ros_domain_of_environment,
)
from hmrsim.cli.output import columns, show_result
from hmrsim.program.command_line import add_commands
from hmrsim.settings.arguments import add_settings, read_settings
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from hmrsim.program.command_line import CommandParser
    from hmrsim_zenoh.security.keystore import Keystore
    from hmrsim_zenoh.wire.access_control import AccessControl, Decision, Message
    from hmrsim_zenoh.wire.enclave import Member

_VARIABLE: Final = "HMRSIM_SECURE"
"""The environment variable of ``--secure``."""
_MAX_DAYS: Final = 36_500.0


def configure(parser: CommandParser) -> None:
    """Add the commands of ``hmrsim security``."""
    parser.description = (
        "Restrict who may drive robots, with certificates. A keystore has an authority, and an enclave (a\n"
        "certificate, its key and the policy) for each role; commands use it by --secure DIR or HMRSIM_SECURE=DIR."
    )
    parser.epilog = """\
examples:
  hmrsim security create keys && hmrsim run hospital --secure keys
  hmrsim action send-goal --secure keys /wall_e/wait '{time: {sec: 3}}'
  hmrsim security create keys --host 10.0.0.7 --controller nurses=wall_e,eve --controller porters=m_o
  hmrsim security add keys viewer lobby
  hmrsim security explain keys hmrsim/wall_e/wait/_action/send_goal
  hmrsim security check keys"""
    add_commands(
        parser,
        {
            "create": ("create a keystore: an authority, and an enclave for each role", _configure_create),
            "add": ("add an enclave to a keystore", _configure_add),
            "renew": ("replace the certificates before they expire", _configure_renew),
            "revoke": ("revoke all rights of an enclave", _configure_revoke),
            "explain": ("explain who may do what on a key, and by which rule", _configure_explain),
            "check": ("verify that a running simulator enforces the policy", _configure_check),
        },
    )


def _configure_create(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Create a keystore: a certificate authority, and enclaves for the simulator, a controller of all robots (or\n"
        "those that --controller names), a viewer, who only reads, and an operator, who may do everything."
    )
    parser.epilog = """\
examples:
  hmrsim security create keys
  hmrsim security create keys --host 10.0.0.7 --host sim.example.org --days 30
  hmrsim security create keys --controller nurses=wall_e,eve --controller porters=m_o"""
    _add_keystore(parser)
    parser.add_argument(
        "--controller",
        action="append",
        type=_controller,
        metavar="NAME[=ROBOT,…]",
        help="a controller and the robots that it drives (default: all); repeatable",
    )
    parser.add_argument(
        "--host",
        action="append",
        default=[],
        metavar="HOST",
        help="a name or address of the simulator, in addition to localhost and this machine's name; "
        "repeatable, the first is in the configuration of ROS nodes",
    )
    _add_days(parser)
    parser.add_argument(
        "--prefix", default=DEFAULT_PREFIX, metavar="KEY", help="prefix of the simulator's keys (default: %(default)s)"
    )
    add_ros_domain(parser, "the ROS domain of ROS clients")
    parser.add_argument("--force", action="store_true", help="replace a keystore that exists")
    add_json(parser)
    parser.set_defaults(function=_create)


def _configure_add(parser: argparse.ArgumentParser) -> None:
    parser.description = "Add an enclave to a keystore. Simulators that start afterwards know it."
    parser.epilog = """\
examples:
  hmrsim security add keys viewer lobby
  hmrsim security add keys controller porters --robot m_o --robot eve --service call_lift"""
    _add_keystore(parser)
    parser.add_argument("role", choices=("controller", "viewer", "operator"), metavar="ROLE", help="%(choices)s")
    parser.add_argument("name", metavar="NAME", help="the name of the enclave")
    parser.add_argument(
        "--robot", action="append", default=[], metavar="ROBOT", help="a robot that the controller drives; repeatable"
    )
    parser.add_argument(
        "--service",
        action="append",
        default=[],
        metavar="SERVICE",
        help="a service of the world that the controller may call, such as call_lift; repeatable",
    )
    _add_days(parser)
    add_json(parser)
    parser.set_defaults(function=_add)


def _configure_renew(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Create new certificates and keys before the old ones expire. The old ones stay valid until then."
    )
    parser.epilog = "examples:\n  hmrsim security renew keys\n  hmrsim security renew keys nurses --days 30"
    _add_keystore(parser)
    parser.add_argument("names", nargs="*", metavar="NAME", help="the enclaves to renew (default: all)")
    _add_days(parser)
    add_json(parser)
    parser.set_defaults(function=_renew)


def _configure_revoke(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Revoke all rights of an enclave, for example when its key is lost. Restart running simulators and pages,\n"
        "which still use the old policy."
    )
    parser.epilog = "examples:\n  hmrsim security revoke keys porters"
    _add_keystore(parser)
    parser.add_argument("name", metavar="NAME", help="the enclave")
    add_json(parser)
    parser.set_defaults(function=_revoke)


def _configure_explain(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Explain who may do what on a key or a key expression, and by which rule of the policy. To `ask` is to\n"
        "get a value, to send a goal or to call a service."
    )
    parser.epilog = """\
examples:
  hmrsim security explain keys hmrsim/wall_e/wait/_action/send_goal
  hmrsim security explain keys hmrsim/_world/load_world viewer
  hmrsim security explain keys '0/wall_e/**' operator"""
    parser.usage = f"{parser.prog} [-h] [--json] [DIR] KEY [ROLE]"
    parser.add_argument(
        "words",
        nargs="+",
        metavar="DIR KEY ROLE",
        help=f"a keystore, or one enclave of it (default: {_VARIABLE}); a key expression, such as hmrsim/wall_e/odom; "
        "an enclave, by name or role (default: all)",
    )
    add_json(parser)
    parser.set_defaults(function=_explain)


def _configure_check(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Try at a running simulator what each enclave may and may not do, also without a certificate, with one of\n"
        "another authority and with an expired one. Nothing is changed: all requests are malformed on purpose."
    )
    parser.epilog = """\
exit codes:
  0  the simulator enforces the policy
  1  it does not, in the marked cases
  3  no simulator answers

examples:
  hmrsim security check keys
  hmrsim security check keys --connect tls/10.0.0.7:7447"""
    parser.add_argument(
        "keystore", nargs="?", type=Path, metavar="DIR", help=f"the folder of the keystore (default: {_VARIABLE})"
    )
    add_settings(parser, SessionOptions, only=("connect", "timeout"))
    add_json(parser)
    parser.set_defaults(function=_check)


def _add_keystore(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("keystore", type=Path, metavar="DIR", help="the folder of the keystore")


def _add_days(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--days",
        type=number_in(0.0, _MAX_DAYS, f"a number of days greater than 0, and up to {_MAX_DAYS:g}"),
        default=365.0,
        metavar="N",
        help="how long the certificates are valid, in days (default: %(default)g)",
    )


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


def _explain(args: argparse.Namespace) -> int:
    import zenoh

    folder, text, role = _parsed(args.words)
    try:
        key = str(zenoh.KeyExpr(text))
    except zenoh.ZError:
        raise WrongUse(f"{text!r} is not a key expression; chunks are joined by single slashes") from None
    policy, names = _policy(folder, role)
    decided = {name: _decisions(policy, name, key) for name in names}
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


def _decisions(policy: AccessControl, name: str, key: str) -> dict[str, Decision]:
    """Return the policy's decision on each operation of a client on a key."""
    decided = {}
    for what, (sent, received) in _ASKS.items():
        first, second = policy.decide(name, sent, "ingress", key), policy.decide(name, received, "egress", key)
        decided[what] = second if first.allowed and not second.allowed else first
    return decided | {what: policy.decide(name, message, "ingress", key) for what, message in _DOES.items()}


def _parsed(words: Sequence[str]) -> tuple[Path, str, str | None]:
    from hmrsim_zenoh.wire.enclave import DESCRIPTION, ENCLAVES

    rest = list(words)
    first = Path(rest[0])
    if len(rest) > _KEY_AND_ROLE or (first / DESCRIPTION).exists() or (first / ENCLAVES).exists():
        folder = Path(rest.pop(0))
    else:
        folder = _folder_of_environment()
    if not 1 <= len(rest) <= _KEY_AND_ROLE:
        raise WrongUse("expected [DIR] KEY [ROLE], such as keys hmrsim/wall_e/odom viewer")
    return folder, rest[0], rest[1] if len(rest) > 1 else None


def _policy(folder: Path, role: str | None) -> tuple[AccessControl, list[str]]:
    """Return the policy of a keystore or an enclave, and the names of the enclaves to explain."""
    from hmrsim_zenoh.wire.enclave import DESCRIPTION, enclaves, find_enclave, read_enclave

    if role is None and (folder / DESCRIPTION).exists():
        policy = read_enclave(folder).access_control
        return policy, list(policy.rules)
    every = enclaves(folder) if role is None else []
    chosen = every or [find_enclave(folder, role or "")]
    return chosen[0].access_control, [enclave.name for enclave in chosen]


def _folder_of_environment() -> Path:
    folder = os.environ.get(_VARIABLE, "")
    if not folder:
        raise WrongUse(f"no keystore; name its folder DIR, or set {_VARIABLE}=DIR")
    return Path(folder)


def _keystores() -> type[Keystore]:
    """Return the class of keystores, which needs an optional package."""
    try:
        from hmrsim_zenoh.security.keystore import Keystore
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "cryptography":
            raise
        text = "hmrsim security needs a package that is not installed; pip install 'hmrsim[security]'"
        raise WrongUse(text) from None
    return Keystore


def _controller(text: str) -> Member:
    """Return the controller described by ``NAME=ROBOT,ROBOT``."""
    from hmrsim_zenoh.wire.enclave import Member

    name, equals, names = text.partition("=")
    robots = tuple(robot for robot in names.split(",") if robot)
    if equals and not robots:
        raise argparse.ArgumentTypeError(f"{text!r} names no robots; expected NAME=ROBOT,ROBOT, or NAME for all")
    return Member(name, "controller", tuple(dict.fromkeys(robots)))


def _create(args: argparse.Namespace) -> int:
    keystores = _keystores()
    from hmrsim_zenoh.security.keystore import Network, own_hosts
    from hmrsim_zenoh.wire.enclave import SIMULATOR, Member

    given = args.ros_domain_id
    domain = given if given is not None else ros_domain_of_environment()
    hosts = tuple(dict.fromkeys([*args.host, *own_hosts()]))
    members = [
        Member(SIMULATOR, SIMULATOR),
        *(args.controller or [Member("controller", "controller")]),
        Member("viewer", "viewer"),
        Member("operator", "operator"),
    ]
    network = Network(args.prefix, domain, hosts)
    store = keystores.create(args.keystore, members, network, days=args.days, force=args.force)
    lines = (
        f"made {store.path}: {', '.join(map(_described, store.members.values()))}",
        f"valid until {_until(store.members.values())}, at {', '.join(hosts)}",
        f"next: hmrsim run WORLD --secure {store.path}",
    )
    show_result(_as_json(store), lines, as_json=args.json)
    return ExitCode.DONE


def _add(args: argparse.Namespace) -> int:
    from hmrsim_zenoh.wire.enclave import Member

    if args.role != "controller" and (args.robot or args.service):
        raise WrongUse(f"--robot and --service are for controllers, not for a {args.role}")
    store = _keystores()(args.keystore)
    store.add(Member(args.name, args.role, tuple(args.robot), tuple(args.service)), args.days)
    member = store.members[args.name]
    text = f"added {_described(member)}, valid until {_until([member])}; restart the simulator"
    show_result(_as_json(store), text, as_json=args.json)
    return ExitCode.DONE


def _renew(args: argparse.Namespace) -> int:
    store = _keystores()(args.keystore)
    names = store.renew(args.names, args.days)
    text = f"renewed {', '.join(names)}; valid until {_until(store.members[name] for name in names)}"
    show_result(_as_json(store), text, as_json=args.json)
    return ExitCode.DONE


def _revoke(args: argparse.Namespace) -> int:
    store = _keystores()(args.keystore)
    store.revoke(args.name)
    text = f"revoked {args.name}; restart the simulator and `hmrsim view`, which know the old policy"
    show_result(_as_json(store), text, as_json=args.json)
    return ExitCode.DONE


def _described(member: Member) -> str:
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


def _check(args: argparse.Namespace) -> int:
    """Try what each enclave may do at a running simulator; return 1 if the simulator does not enforce the policy."""
    store = _keystores()(args.keystore or _folder_of_environment())
    from hmrsim_zenoh.security.check import attempts

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

"""``hmrsim security``: keystores, which restrict who may drive robots."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.options import add_json, number_in
from hmrsim.program.command_line import Later, add_commands
from hmrsim.settings.arguments import add_settings
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from hmrsim.program.command_line import LazyParser

VARIABLE: Final = "HMRSIM_SECURE"
"""The environment variable of ``--secure``."""
_MAX_DAYS: Final = 36_500.0


def configure(parser: LazyParser) -> None:
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
        type=Later("hmrsim.cli.security_keystore", "controller"),
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
    parser.add_argument(
        "--ros-domain-id",
        type=Later("hmrsim.cli.security_keystore", "ros_domain_id"),
        metavar="N",
        help="the ROS domain of ROS clients (default: the environment's ROS_DOMAIN_ID, else 0)",
    )
    parser.add_argument("--force", action="store_true", help="replace a keystore that exists")
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_keystore", "create"))


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
    parser.set_defaults(function=Later("hmrsim.cli.security_keystore", "add"))


def _configure_renew(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Create new certificates and keys before the old ones expire. The old ones stay valid until then."
    )
    _add_keystore(parser)
    parser.add_argument("names", nargs="*", metavar="NAME", help="the enclaves to renew (default: all)")
    _add_days(parser)
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_keystore", "renew"))


def _configure_revoke(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Revoke all rights of an enclave, for example when its key is lost. Restart running simulators and pages,\n"
        "which still use the old policy."
    )
    _add_keystore(parser)
    parser.add_argument("name", metavar="NAME", help="the enclave")
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_keystore", "revoke"))


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
        help=f"a keystore, or one enclave of it (default: {VARIABLE}); a key expression, such as hmrsim/wall_e/odom; "
        "an enclave, by name or role (default: all)",
    )
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_keystore", "explain"))


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
        "keystore", nargs="?", type=Path, metavar="DIR", help=f"the folder of the keystore (default: {VARIABLE})"
    )
    add_settings(parser, SessionOptions, only=("connect", "timeout"))
    add_json(parser)
    parser.set_defaults(function=Later("hmrsim.cli.security_keystore", "check"))


def _add_keystore(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("keystore", type=Path, metavar="DIR", help="the folder of the keystore")


def _add_days(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--days",
        type=_days,
        default=365.0,
        metavar="N",
        help="how long the certificates are valid, in days (default: %(default)g)",
    )


def _days(text: str) -> float:
    return number_in(text, 0.0, _MAX_DAYS, otherwise=f"a number of days greater than 0, and up to {_MAX_DAYS:g}")

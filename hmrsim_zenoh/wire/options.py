"""Endpoints, and the options of every command that opens a session.

A :class:`~hmrsim.program.command_line.CommandParser` also reads them from ``HMRSIM_CONNECT`` and the other environment
variables. This module does not load Zenoh, which takes longer than ``--help`` may take.
"""

from __future__ import annotations

import argparse
import ipaddress
import math
import os
import re
import socket
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path  # noqa: TC003 - settings are read at run time
from typing import Annotated, Any, Final, Literal

from hmrsim.diagnostics import shortened
from hmrsim.errors import reason_of
from hmrsim.program.command_line import words_of
from hmrsim.settings.arguments import add_settings, read_settings, reader
from hmrsim.settings.option import MAX_SECONDS, Option, settings_of
from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.wire.keys import DEFAULT_PREFIX, Keys

DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"

_PROTOCOLS: Final = ("tcp", "udp", "tls", "quic", "ws", "unixsock-stream")
_DATAGRAMS: Final = ("udp", "quic")
ENCRYPTED: Final = ("tls", "quic")
"""The protocols of secured sessions; Zenoh checks no certificates at IPv6 addresses."""
_ENDPOINT: Final = re.compile(r"(?P<protocol>[^/]+)/(?P<address>[^?#]+)(?P<rest>[?#].*)?")
_HOST_PORT: Final = re.compile(r"(?P<host>\[[^\]]+\]|[^:\[\]]+):(?P<port>[0-9]{1,5})")
_LAST_PORT: Final = 65535
_EVERY_ADDRESS: Final = {"0.0.0.0": "127.0.0.1", "[::]": "[::1]"}  # noqa: S104 - compared with, not bound to


def check_endpoint(flag: str, endpoint: str) -> None:
    """Check an endpoint, which Zenoh would otherwise try in vain until the timeout.

    Args:
        flag: ``--connect`` or ``--listen``.
        endpoint: The endpoint.

    Raises:
        BadOptions: The endpoint is invalid; the text begins with the flag.
    """
    expected = "expected PROTOCOL/ADDRESS, such as tcp/127.0.0.1:7447"
    match = _ENDPOINT.fullmatch(endpoint)
    if not match:
        raise BadOptions(f"{flag} {endpoint!r} is not an endpoint; {expected}")
    if match["protocol"] not in _PROTOCOLS:
        raise BadOptions(f"{flag} {endpoint!r}: no protocol {match['protocol']!r}; there are {', '.join(_PROTOCOLS)}")
    if match["protocol"] == "unixsock-stream":
        return
    address = _HOST_PORT.fullmatch(match["address"])
    lowest = 1 if flag == "--connect" else 0
    if not address or not lowest <= int(address["port"]) <= _LAST_PORT:
        raise BadOptions(
            f"{flag} {endpoint!r}: {match['address']!r} is not HOST:PORT with a port of {lowest} to 65535; {expected}"
        )


def address_of(endpoint: str) -> tuple[str, int] | None:
    """Return the host and the port of an endpoint; None if it is invalid or has none."""
    match = _ENDPOINT.fullmatch(endpoint)
    address = _HOST_PORT.fullmatch(match["address"]) if match else None
    return (address["host"].strip("[]"), int(address["port"])) if address else None


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach a host's address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def from_here(endpoint: str) -> str:
    """Return how this machine reaches an endpoint that another program on it listens on."""
    protocol, slash, rest = endpoint.partition("/")
    if protocol in ENCRYPTED and rest.startswith(("[::]:", "[::1]:")):
        return f"{protocol}{slash}localhost:{rest.partition(']:')[2]}"
    for every, own in _EVERY_ADDRESS.items():
        if f"/{every}:" in endpoint:
            return endpoint.replace(f"/{every}:", f"/{own}:", 1)
    return endpoint


def with_port(endpoint: str) -> str:
    """Return an endpoint with a free port in place of port 0, as Zenoh does not report the port that it chooses."""
    match = _ENDPOINT.fullmatch(endpoint)
    address = _HOST_PORT.fullmatch(match["address"]) if match else None
    if not match or not address or int(address["port"]) != 0:
        return endpoint
    host = address["host"].strip("[]")
    kind = socket.SOCK_DGRAM if match["protocol"] in _DATAGRAMS else socket.SOCK_STREAM
    try:
        family = socket.getaddrinfo(host, 0, type=kind)[0][0]
        with socket.socket(family, kind) as probe:
            probe.bind((host, 0))
            port = probe.getsockname()[1]
    except OSError as error:
        raise BadOptions(f"--listen {endpoint!r}: {reason_of(error)}") from None
    return f"{match['protocol']}/{address['host']}:{port}{match['rest'] or ''}"


Mode = Literal["peer", "client", "router"]


def _check_endpoints(flag: str, endpoints: str | tuple[str, ...]) -> str | tuple[str, ...]:
    for endpoint in (endpoints,) if isinstance(endpoints, str) else endpoints:
        try:
            check_endpoint(flag, endpoint)
        except BadOptions as error:
            raise ValueError(str(error).removeprefix(f"{flag} ")) from None
    return endpoints


def _prefix(text: str) -> str:
    return Keys(text).prefix


def _seconds(text: str, what: str = "time") -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds <= MAX_SECONDS:
        raise ValueError(
            f"{shortened(text)!r} is not a valid {what}; expected a number of seconds greater than 0, up to "
            f"{MAX_SECONDS:g}"
        )
    return seconds


def seconds(text: str, *, what: str = "time") -> float:
    """Return a number of seconds greater than 0, for argparse; *what* names it in an error."""
    try:
        return _seconds(text, what)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


_OF_ONE_SESSION: Final = frozenset({"role"})
"""The options without an environment variable, because a variable would affect all sessions of a shell."""


@dataclass(frozen=True)
class SessionOptions:
    """The options of a Zenoh session.

    Attributes:
        connect: Endpoints to connect to, such as ``tcp/10.0.0.7:7447``, of which one has to answer; by default
            *default* for tools.
        listen: Endpoints to listen on; by default *default* for a simulator without *connect*.
        mode: Zenoh's mode; None to derive it from the endpoints.
        zenoh_config: A Zenoh configuration, JSON5; the other options take precedence.
        prefix: The prefix of all keys.
        timeout: Wall seconds to reach a simulator.
        secure: A keystore or an enclave of ``hmrsim security``: sessions are encrypted, and both sides show their
            certificates; None for open sessions.
        role: The enclave of the keystore, by name or role; None for *default_role*.
        default_role: The role of a session without *role*; a simulator's role is always ``simulator``.
        default: The default endpoint of simulators and tools. Zenoh tries all addresses of a name, so that
            ``tcp/localhost:7447`` works even if localhost resolves to ``::1`` first.
    """

    connect: Annotated[
        tuple[str, ...],
        Option(
            "endpoint to connect to, such as tcp/10.0.0.7:7447; repeatable",
            "ENDPOINT",
            group="session",
            default_text=DEFAULT_ENDPOINT,
            check=partial(_check_endpoints, "--connect"),
        ),
    ] = ()
    listen: Annotated[
        tuple[str, ...],
        Option(
            "endpoint to listen on; repeatable",
            "ENDPOINT",
            group="session",
            check=partial(_check_endpoints, "--listen"),
        ),
    ] = ()
    mode: Annotated[Mode | None, Option("Zenoh's mode", group="session")] = None
    zenoh_config: Annotated[
        Path | None, Option("Zenoh configuration; options take precedence", "FILE.json5", group="session")
    ] = None
    prefix: Annotated[str, Option("prefix of all keys", "KEY", group="session", check=_prefix)] = DEFAULT_PREFIX
    timeout: Annotated[
        float,
        Option(
            "wall seconds to reach a simulator",
            "S",
            unit="wall seconds",
            group="session",
            more_than=0,
            at_most=MAX_SECONDS,
            read=_seconds,
        ),
    ] = 5.0
    secure: Annotated[
        Path | None,
        Option(
            "encrypt the connection and authenticate with a certificate: a keystore made by "
            "`hmrsim security create`, or one of its enclaves",
            "DIR",
            group="session",
        ),
    ] = None
    role: Annotated[
        str | None,
        Option(
            "with --secure, the enclave to use: its name, or its role if no other enclave has that role",
            "NAME",
            group="session",
        ),
    ] = None
    default_role: str = "operator"
    default: str = DEFAULT_ENDPOINT

    @classmethod
    def from_environment(cls) -> SessionOptions:
        """Return the options of the environment variables: ``HMRSIM_CONNECT``, ``HMRSIM_PREFIX`` and so on.

        Values are spelled as on the command line, with commas between several values. Empty variables are ignored.

        Raises:
            BadOptions: A value is not valid.
        """
        given: dict[str, Any] = {}
        for name, setting in settings_of(SessionOptions).items():
            variable = f"HMRSIM_{name.upper()}"
            text = "" if name in _OF_ONE_SESSION else os.environ.get(variable, "")
            if not text:
                continue
            read = reader(setting.kind.type, setting.option)
            try:
                given[name] = tuple(map(read, words_of(text))) if setting.kind.repeatable else read(text)
            except argparse.ArgumentTypeError as error:
                raise BadOptions(f"{variable}: {error}") from None
            if setting.kind.choices and given[name] not in setting.kind.choices:
                raise BadOptions(f"{variable}: no {name} {text!r}; there are {', '.join(setting.kind.choices)}")
        return cls(**given)


def add_session_options(parser: argparse.ArgumentParser) -> None:
    """Add the session options to a command."""
    add_settings(parser, SessionOptions)


def session_options(args: argparse.Namespace, default_role: str = "operator") -> SessionOptions:
    """Return the options from the command line and the environment; *default_role* is that of the command."""
    return replace(read_settings(args, SessionOptions), default_role=default_role)

"""Endpoints: their validation, and free ports."""

from __future__ import annotations

import ipaddress
import re
import socket
from typing import Final

from hmrsim.errors import reason_of
from hmrsim_zenoh.errors import BadOptions

DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"

_PROTOCOLS: Final = ("tcp", "udp", "tls", "quic", "ws", "unixsock-stream")
_DATAGRAMS: Final = ("udp", "quic")
_CERTIFIED: Final = ("tls", "quic")
"""The protocols by which Zenoh checks certificates, which it does not do at IPv6 addresses."""
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
    if protocol in _CERTIFIED and rest.startswith(("[::]:", "[::1]:")):
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

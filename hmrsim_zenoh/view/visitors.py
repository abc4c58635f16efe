"""Visitors of a page that is served by HTTPS: whose certificate they show, and what they may ask."""

from __future__ import annotations

import math
import ssl
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    import asyncio

    from hmrsim_zenoh.wire.enclave import Enclave

_VISITOR: Final = "hmrsim.visitor"
"""The key in the state of a connection."""


@dataclass(frozen=True)
class Visitor:
    """Who sends requests on a connection.

    Attributes:
        name: The name on the certificate; empty without one.
        expires: The end of the certificate's validity, in seconds since 1970.
    """

    name: str = ""
    expires: float = math.inf


_STRANGER: Final = Visitor()

May = Callable[[str], str]
"""Returns why a key below the prefix may not be queried; empty if it may."""


class NamedProtocol(H11Protocol):
    """Uvicorn's HTTP, which adds the visitor to the state of requests and WebSockets.

    The authority has signed the certificate, and it has not expired yet: the handshake checks that.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn's own
        """Look at the certificate."""
        super().connection_made(transport)
        secured = transport.get_extra_info("ssl_object")
        certificate = secured.getpeercert() if secured is not None else None
        self.app_state = {**self.app_state, _VISITOR: _visitor(certificate or {})}


def visitor_of(scope: Mapping[str, Any]) -> Visitor:
    """Return the visitor who sends a request."""
    found: Visitor = scope.get("state", {}).get(_VISITOR, _STRANGER)
    return found


def _visitor(certificate: Mapping[str, Any]) -> Visitor:
    names = [value for part in certificate.get("subject", ()) for key, value in part if key == "commonName"]
    return Visitor(names[0], ssl.cert_time_to_seconds(certificate["notAfter"])) if names else _STRANGER


@dataclass(frozen=True)
class Rights:
    """The rights of visitors, where the page's server has an enclave: their own, but no more than the server's.

    Without a certificate, visitors only read.

    Attributes:
        prefix: The prefix of the simulator's keys.
    """

    enclave: Enclave
    prefix: str

    def of(self, visitor: Visitor) -> May:
        """Return what a visitor may ask."""
        return lambda key: self._denial(visitor, f"{self.prefix}/{key}")

    def _denial(self, visitor: Visitor, key: str) -> str:
        policy = self.enclave.access_control
        if time.time() > visitor.expires:
            return f"the certificate of {visitor.name!r} has expired"
        if text := policy.denial(visitor.name, key):
            return text
        if not policy.may_query(self.enclave.name, key).allowed:
            return f"the page's server, {self.enclave.name!r}, may not ask on {key!r}; start it with --role operator"
        return ""


def anything(_key: str) -> str:
    """Return that everything may be asked, where there are no certificates."""
    return ""

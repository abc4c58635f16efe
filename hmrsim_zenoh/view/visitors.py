"""Visitors of a page that is served by HTTPS: whose certificate they show, and what they may ask."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    import asyncio

    from hmrsim_zenoh.wire.enclave import Enclave

_NAME: Final = "hmrsim.visitor"
"""The key in the state of a connection."""

May = Callable[[str], str]
"""Returns why a key below the prefix may not be queried; empty if it may."""


class NamedProtocol(H11Protocol):
    """Uvicorn's HTTP, which adds the name on the visitor's certificate to the state of requests and WebSockets.

    The authority has signed the certificate, and it has not expired: the handshake checks that.
    """

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn's own
        """Look at the certificate."""
        super().connection_made(transport)
        secured = transport.get_extra_info("ssl_object")
        certificate = secured.getpeercert() if secured is not None else None
        self.app_state = {**self.app_state, _NAME: _common_name(certificate or {})}


def name_of(scope: Mapping[str, Any]) -> str:
    """Return the name on the certificate of the visitor who sends a request; empty without one."""
    return str(scope.get("state", {}).get(_NAME, ""))


def _common_name(certificate: Mapping[str, Any]) -> str:
    names = [value for part in certificate.get("subject", ()) for key, value in part if key == "commonName"]
    return names[0] if names else ""


@dataclass(frozen=True)
class Rights:
    """The rights of visitors, where the page's server has an enclave: their own, but no more than the server's.

    Without a certificate, visitors only read.

    Attributes:
        prefix: The prefix of the simulator's keys.
    """

    enclave: Enclave
    prefix: str

    def of(self, visitor: str) -> May:
        """Return what a visitor may ask."""
        return lambda key: self._denial(visitor, f"{self.prefix}/{key}")

    def _denial(self, visitor: str, key: str) -> str:
        policy = self.enclave.access_control
        decision = policy.may_query(visitor, key) if visitor else policy.reads(key)
        if not decision.allowed:
            who = repr(visitor) if visitor else "a visitor without a certificate"
            others = ", ".join(policy.who_may_query(key)) or "no one"
            return f"{who} may not ask on {key!r}: {decision}; who may: {others}"
        if not policy.may_query(self.enclave.name, key).allowed:
            return f"the page's server, {self.enclave.name!r}, may not ask on {key!r}; start it with --role operator"
        return ""


def anything(_key: str) -> str:
    """Return that everything may be asked, where there are no certificates."""
    return ""

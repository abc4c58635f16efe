"""Access control: which requests the page's server accepts, and which keys a visitor may query.

Binding to the loopback alone does not protect a server from web pages: any page that is open in the browser can send
requests to it, and read the responses by DNS rebinding. So `Host` has to name this server, and `Origin`, if present,
has to be the page's own. From other machines a request needs the token. With HTTPS, a visitor may show a certificate.
"""

from __future__ import annotations

import hmac
import math
import secrets
import ssl
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from uvicorn.protocols.http.h11_impl import H11Protocol

from hmrsim_zenoh.wire.options import is_loopback

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Container

    from starlette.types import ASGIApp, Message, Receive, Scope, Send

    from hmrsim_zenoh.wire.enclave import Enclave

_VISITOR: Final = "hmrsim.visitor"
"""The key in the state of a connection."""


@dataclass(frozen=True)
class Visitor:
    """The client at the other end of a connection.

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
        """Read the visitor from the client's certificate."""
        super().connection_made(transport)
        secured = transport.get_extra_info("ssl_object")
        certificate = secured.getpeercert() if secured is not None else None
        self.app_state = {**self.app_state, _VISITOR: _visitor(certificate or {})}


def visitor_of(scope: Mapping[str, Any]) -> Visitor:
    """Return the visitor who sends a request."""
    visitor: Visitor = scope.get("state", {}).get(_VISITOR, _STRANGER)
    return visitor


def _visitor(certificate: Mapping[str, Any]) -> Visitor:
    names = [value for part in certificate.get("subject", ()) for key, value in part if key == "commonName"]
    return Visitor(names[0], ssl.cert_time_to_seconds(certificate["notAfter"])) if names else _STRANGER


@dataclass(frozen=True)
class VisitorRights:
    """The rights of visitors, where the page's server has an enclave: their own, but no more than the server's.

    Without a certificate, visitors only read.

    Attributes:
        prefix: The prefix of the simulator's keys.
    """

    enclave: Enclave
    prefix: str

    def of(self, visitor: Visitor) -> May:
        """Return the check of a visitor's queries."""
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
    """Allow any query, where there are no certificates."""
    return ""


_POLICY: Final = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
_HEADERS: Final = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-cache",
}
_LOOPBACK: Final = frozenset({"localhost", "127.0.0.1", "::1"})
_PUBLIC: Final = frozenset({".js", ".css", ".svg", ".png", ".ico", ".json", ".webmanifest", ".woff2"})
"""The suffixes of the page's files, which are the same in every installation and requested without the token."""
_POLICY_VIOLATED: Final = 1008
_FORBIDDEN: Final = 403
_TOKEN_BYTES: Final = 16


class Gate:
    """Passes requests to an ASGI application or rejects them; adds security headers to every response.

    Args:
        host: The address that it is bound to.
        members: The names whose certificates are accepted; None without certificates.

    Attributes:
        token: The required ``?token=`` of URLs; empty on the loopback, where none is required.
    """

    def __init__(self, app: ASGIApp, host: str, members: Container[str] | None = None) -> None:
        self._members = members
        self.token = "" if is_loopback(host) else secrets.token_urlsafe(_TOKEN_BYTES)
        self._app = app
        self._hosts = _LOOPBACK | {host.lower()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request, or refuse it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if scope["type"] == "websocket":
            if refusal:
                await send({"type": "websocket.close", "code": _POLICY_VIOLATED, "reason": refusal})
            else:
                await self._app(scope, receive, send)
            return
        app = PlainTextResponse(f"{refusal}\n", _FORBIDDEN) if refusal else self._app

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(_HEADERS)
            await send(message)

        await app(scope, receive, send_with_headers)

    def _refusal(self, scope: Scope) -> str:
        """Return why a request is rejected; empty if it is not."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = _name(host)
        if not name or (not self.token and name not in self._hosts):
            return f"this server is not {host!r}; use the address that it was started with"
        origin = headers.get("origin")
        # With certificates, this server's pages are never plain HTTP. Without, a proxy may add encryption.
        schemes = ("https",) if self._members is not None else ("http", "https")
        if origin is not None and origin.lower() not in {f"{scheme}://{host}".lower() for scheme in schemes}:
            return f"pages of {origin!r} may not send requests to this server"
        visitor = visitor_of(scope).name
        if self._members is not None and visitor and visitor not in self._members:
            return f"{visitor!r} has no rights here; the certificate may be revoked"
        if self.token and not self._is_public(scope["path"]) and not self._has_token(scope):
            return "the token is missing or wrong; open the URL that `hmrsim view` printed"
        return ""

    def _is_public(self, path: str) -> bool:
        return PurePosixPath(path).suffix in _PUBLIC

    def _has_token(self, scope: Scope) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return hmac.compare_digest(given.encode(), self.token.encode())


def _name(host: str) -> str:
    """Return the name in a ``Host`` header, without the port; empty if the header is invalid."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""

"""Who may ask: pages that this server itself has sent, and from elsewhere those that know its token.

A server on the loopback is not safe from the web by that alone: any page that is open in the browser can send it
requests, with a name that was made to lead here (DNS rebinding) even read the answers. So `Host` has to be ours, and
`Origin`, where a browser says it, the page's own.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Final
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

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
"""What the page is made of: the same in every installation, and asked for by the page's own tags."""
_POLICY_VIOLATED: Final = 1008
_FORBIDDEN: Final = 403
_TOKEN_BYTES: Final = 16


def is_loopback(host: str) -> bool:
    """Return whether only this machine can reach a host's address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class Gate:
    """Lets requests through to an ASGI application, or refuses them; gives every answer the headers of a careful page.

    Args:
        app: The application.
        host: Where it is bound.

    Attributes:
        token: What has to be in each URL's ``?token=``; empty on the loopback, where nothing has to.
    """

    def __init__(self, app: ASGIApp, host: str) -> None:
        self.token = "" if is_loopback(host) else secrets.token_urlsafe(_TOKEN_BYTES)
        self._app = app
        self._hosts = _LOOPBACK | {host.lower()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
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
        """Return why a request is not served; empty if it is."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        name = _name(host)
        if not name or (not self.token and name not in self._hosts):
            return f"this server is not {host!r}; ask for it by the address that it was started with"
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in {f"http://{host}".lower(), f"https://{host}".lower()}:
            return f"pages of {origin!r} may not ask here"
        if self.token and not self._is_public(scope["path"]) and not self._has_token(scope):
            return "the token is missing or wrong; open the URL that `hmrsim view` printed"
        return ""

    def _is_public(self, path: str) -> bool:
        return PurePosixPath(path).suffix in _PUBLIC

    def _has_token(self, scope: Scope) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return hmac.compare_digest(given.encode(), self.token.encode())


def _name(host: str) -> str:
    """Return the name in a ``Host`` header, without its port; empty if it is none."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""

"""Why a session can't be opened, though a process listens at the endpoint: Zenoh itself reports a timeout only."""

from __future__ import annotations

import socket
import ssl
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.wire.enclave import AUTHORITY, CERTIFICATE, KEY
from hmrsim_zenoh.wire.endpoints import address_of

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.enclave import Enclave

_PATIENCE: Final = 1.0
"""Wall seconds for each step of the handshake."""
_VERDICT: Final = 0.3
"""Wall seconds within which a server refuses a certificate: in TLS 1.3 that is after the client's handshake."""

_REASONS: Final = {
    "CERTIFICATE_EXPIRED": "the certificate has expired",
    "CERTIFICATE_REQUIRED": (
        "a certificate is required; give it with --secure DIR, or as connect_certificate in --zenoh-config"
    ),
    "UNKNOWN_CA": "the certificate is of another authority",
    "DECRYPT_ERROR": "the certificate is of another authority",
    "BAD_CERTIFICATE": "the certificate is invalid",
    "CERTIFICATE_UNKNOWN": "the certificate is invalid",
    "CERTIFICATE_REVOKED": "the certificate is revoked",
    "ACCESS_DENIED": "access is denied",
}
"""What servers say in TLS's alerts, by the ends of their names."""


_NOT_TLS: Final = frozenset({"WRONG_VERSION_NUMBER", "RECORD_LAYER_FAILURE", "UNEXPECTED_EOF_WHILE_READING"})
_PLAIN: Final = "it does not speak TLS; is the simulator started with --secure?"
_OPEN: Final = "TLS is spoken there; give --secure DIR, and the endpoint with tls/ in place of tcp/"


def why_denied(endpoint: str, enclave: Enclave | None) -> str:
    """Return why the process at an endpoint does not let this one in; empty if none listens, or it is unknown.

    Args:
        endpoint: Where Zenoh could not connect to.
        enclave: The certificate to show; None for none.
    """
    where = address_of(endpoint)
    if where is None or not endpoint.startswith(("tls/", "tcp/")):
        return ""
    try:
        with socket.create_connection(where, _PATIENCE) as connection:
            return _of_tls(connection, where[0], enclave) if endpoint.startswith("tls/") else _of_tcp(connection)
    except OSError:
        return ""


def _of_tls(connection: socket.socket, host: str, enclave: Enclave | None) -> str:
    """Return why a handshake fails."""
    context = ssl.create_default_context(cafile=str(enclave.folder / AUTHORITY) if enclave else None)
    if enclave:
        context.load_cert_chain(enclave.folder / CERTIFICATE, enclave.folder / KEY)
    else:
        context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with context.wrap_socket(connection, server_hostname=host) as secured:
            _wait_for_verdict(secured)
    except ssl.SSLCertVerificationError as error:
        return f"its certificate is not valid for {host} here: {error.verify_message.rstrip('.')}"
    except ssl.SSLError as error:
        reason = error.reason or ""
        if reason in _NOT_TLS:
            return _PLAIN
        return next((text for end, text in _REASONS.items() if reason.endswith(end)), "")
    except TimeoutError:
        return _PLAIN
    return ""


def _wait_for_verdict(secured: ssl.SSLSocket) -> None:
    """Wait for an alert of the server, which comes after the handshake if at all.

    Raises:
        ssl.SSLError: There is one.
    """
    secured.settimeout(_VERDICT)
    with suppress(TimeoutError):
        secured.recv(1)


def _of_tcp(connection: socket.socket) -> str:
    """Return that TLS is spoken on a plain endpoint, if it is."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    try:
        with context.wrap_socket(connection) as secured:
            _wait_for_verdict(secured)
    except ssl.SSLError as error:
        return _OPEN if (error.reason or "").endswith("CERTIFICATE_REQUIRED") else ""
    except OSError:
        return ""
    return _OPEN

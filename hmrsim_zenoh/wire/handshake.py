"""The reason why a process at an endpoint rejects a session, where Zenoh itself only reports a timeout."""

from __future__ import annotations

import socket
import ssl
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.wire.enclave import AUTHORITY, CERTIFICATE, KEY
from hmrsim_zenoh.wire.options import address_of

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
"""The reasons of TLS alerts, by the ends of the alerts' names."""


_NOT_TLS: Final = frozenset({"WRONG_VERSION_NUMBER", "RECORD_LAYER_FAILURE", "UNEXPECTED_EOF_WHILE_READING"})
_PLAIN: Final = "it does not speak TLS; is the simulator started with --secure?"
_OPEN: Final = "TLS is spoken there; give --secure DIR, and the endpoint with tls/ in place of tcp/"


def why_denied(endpoint: str, enclave: Enclave | None) -> str:
    """Return why the process at an endpoint rejects this one; empty if no process listens or the reason is unknown.

    Args:
        endpoint: The endpoint to which Zenoh could not connect.
        enclave: The certificate to show; None without a certificate.
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
    """Wait for an alert of the server, which may follow the handshake.

    Raises:
        ssl.SSLError: The server sent an alert.
    """
    secured.settimeout(_VERDICT)
    with suppress(TimeoutError):
        secured.recv(1)


def _of_tcp(connection: socket.socket) -> str:
    """Return the reason if the server at a plain endpoint expects TLS."""
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

"""Endpoints that are open to other machines, where certificates are a matter of the Zenoh configuration."""

from __future__ import annotations

from hmrsim_zenoh.wire.configuration import exposed
from hmrsim_zenoh.wire.options import SessionOptions

OPEN = ("tcp/0.0.0.0:7447", "udp/10.0.0.7:7447", "tcp/[::]:7447", "ws/sim.example.org:80")
HERE = ("tcp/127.0.0.1:7447", "tcp/localhost:7447", "tcp/[::1]:7447", "unixsock-stream//run/sim")
ENCRYPTED = ("tls/0.0.0.0:7447", "quic/0.0.0.0:7447")


def test_certificates_are_for_encrypted_endpoints(tmp_path):
    """A configuration that asks for certificates leaves others open; access control and passwords do not."""
    for config, expected in (
        ("{}", (*OPEN, *ENCRYPTED)),
        ("{transport: {link: {tls: {enable_mtls: true}}}}", OPEN),
        ("{access_control: {enabled: true, default_permission: 'deny'}}", ()),
        ("{transport: {auth: {usrpwd: {dictionary_file: 'users'}}}}", ()),
    ):
        file = tmp_path / "zenoh.json5"
        file.write_text(config, encoding="utf-8")

        assert list(expected) == exposed(SessionOptions(zenoh_config=file), (*OPEN, *HERE, *ENCRYPTED)), config
    assert [] == exposed(SessionOptions(secure=tmp_path), ENCRYPTED)

"""``hmrsim run --view`` with encrypted sessions."""

from __future__ import annotations

import json
import socket
import ssl
import urllib.request

import pytest

from hmrsim.cli import main
from tests import processes

FREE_PORT = ("--listen", "tls/127.0.0.1:0", "--view", "0", "--json")


@pytest.fixture
def start():
    """Return the function that starts hmrsim as a process, which is killed at the end of the test."""
    with processes.killed_at_the_end() as run:
        yield run


@pytest.fixture
def keys(tmp_path):
    assert main(["security", "create", str(tmp_path / "keys")]) == 0
    return tmp_path / "keys"


def test_a_secured_run_serves_its_page_over_https_as_a_viewer(start, keys):
    ready = json.loads(start("run", "scenario1", "--secure", keys, *FREE_PORT).stdout.readline())
    trusting = ssl.create_default_context(cafile=str(keys / "public" / "ca.cert.pem"))

    with urllib.request.urlopen(f"{ready['view']}source", context=trusting) as answer:
        assert {"kind": "live"} == json.loads(answer.read())


@pytest.mark.skipif(not socket.has_dualstack_ipv6(), reason="this machine has no IPv6")
def test_a_secured_run_at_all_ipv6_addresses_serves_its_page(start, keys):
    """The page's server connects by name, as Zenoh checks no certificate at such an address."""
    words = ("--listen", "tls/[::]:0", *FREE_PORT[2:])

    assert json.loads(start("run", "scenario1", "--secure", keys, *words).stdout.readline())["view"]


def test_the_page_uses_the_certificates_of_the_configuration(start, keys, tmp_path):
    enclave = keys / "enclaves" / "simulator"
    tls = {"root_ca_certificate": str(enclave / "ca.cert.pem"), "enable_mtls": True}
    for side in ("listen", "connect"):
        tls |= {f"{side}_certificate": str(enclave / "cert.pem"), f"{side}_private_key": str(enclave / "key.pem")}
    file = tmp_path / "tls.json5"
    file.write_text(json.dumps({"mode": "router", "transport": {"link": {"tls": tls}}}), encoding="utf-8")
    ready = json.loads(start("run", "scenario1", "--zenoh-config", file, *FREE_PORT).stdout.readline())

    with urllib.request.urlopen(f"{ready['view']}source") as answer:
        assert {"kind": "live"} == json.loads(answer.read())


def test_a_page_without_its_enclave_is_refused(keys, capsys):
    """The simulator's enclave has all rights."""
    code = main(["run", "scenario1", "--secure", str(keys / "enclaves" / "simulator"), *FREE_PORT])

    assert 2 == code
    assert "is the simulator's enclave; the page needs a viewer's" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "warned"),
    [
        (("--listen", "tcp/0.0.0.0:0"), True),
        (("--listen", "tcp/127.0.0.1:0", "--listen", "tcp/[::1]:0"), False),
        (("--listen", "tls/0.0.0.0:0", "--secure", "KEYS"), False),
    ],
)
def test_an_endpoint_open_without_certificates_is_a_warning(keys, capfd, words, warned):
    given = [str(keys) if word == "KEYS" else word for word in words]
    assert main(["run", "scenario1", *given, "--duration", "0.01", "--log-level", "error"]) == 0
    lines = [line for line in capfd.readouterr().err.splitlines() if "is open: anyone who can reach it" in line]

    assert warned == bool(lines)
    assert len(lines) <= 1

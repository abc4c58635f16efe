"""The page over HTTPS: strangers command nothing, and visitors with a certificate what it allows."""

from __future__ import annotations

import http.client
import json
import ssl
from collections import deque
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException

from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.view.access import VisitorRights
from hmrsim_zenoh.view.server import ViewServer
from hmrsim_zenoh.view.sources import Live
from hmrsim_zenoh.wire.session import enclave_of
from tests.cases import case
from tests.patience import PATIENCE
from tests.wire.security.conftest import FAULT, GOAL
from tests.wire.view.pages import opened

SEND = "wall_e/wait/_action/send_goal"
INJECT = "_world/inject_fault"


@contextmanager
def served(secured, role, **where):
    """Serve the page with a role's rights."""
    options = secured.of(role)
    enclave = enclave_of(options)
    with (
        Client(options, clock="realtime") as client,
        ViewServer(
            Live(client.session, client.keys, VisitorRights(enclave, "hmrsim")), port=0, enclave=enclave, **where
        ) as server,
    ):
        yield server


@pytest.fixture(scope="module")
def of_operator(secured):
    """Return the page's server, with an operator's rights."""
    with served(secured, "operator") as server:
        yield server


def context(secured, folder=None):
    """Return a visitor's TLS context: the authority, and a certificate if *folder* has one."""
    found = ssl.create_default_context(cafile=str(secured.store.path / "public" / "ca.cert.pem"))
    if folder is not None:
        found.load_cert_chain(folder / "cert.pem", folder / "key.pem")
    return found


def commands(url, tls):
    """Send a goal and a fault as a page does; return the errors."""
    with opened(url, ssl=tls) as page:
        return [page.get(SEND, payload=GOAL).get("error"), page.get(INJECT, payload=FAULT).get("error")]


def test_strangers_command_nothing_over_https(secured, of_operator, tmp_path):
    secured.ledger.commands.clear()
    folder = secured.store.path / "enclaves"
    for what, certificate in {"none": None, "viewer": folder / "viewer", "porters": folder / "porters"}.items():
        with case(what):
            assert all("may not ask on" in error for error in commands(of_operator.url, context(secured, certificate)))
    for name, there in {
        "former": secured.store.path.with_name("former"),
        "mallory": secured.store.stranger("mallory", 1.0, tmp_path / "mallory").folder,
    }.items():
        with case(name), pytest.raises(InvalidStatus, match="403"):
            commands(of_operator.url, context(secured, there))
    expired = secured.store.stranger("operator", -1.0, tmp_path / "expired").folder
    with pytest.raises((OSError, WebSocketException)):
        commands(of_operator.url, context(secured, expired))

    assert [] == secured.ledger.commands
    assert [None, None] == commands(of_operator.url, context(secured, folder / "operator"))
    assert ["SendGoal", "CallService"] == secured.ledger.commands


def test_a_controller_drives_only_its_robot_on_the_page(secured, of_operator):
    secured.ledger.commands.clear()
    first, second = commands(of_operator.url, context(secured, secured.store.path / "enclaves" / "nurses"))

    assert first is None
    assert "'nurses' may not ask on 'hmrsim/_world/inject_fault'" in second
    assert ["SendGoal"] == secured.ledger.commands


def test_an_operator_can_not_command_by_the_page_of_a_viewer(secured):
    secured.ledger.commands.clear()
    with served(secured, "viewer") as server:
        errors = commands(server.url, context(secured, secured.store.path / "enclaves" / "operator"))

    assert all("the page's server, 'viewer', may not ask" in error for error in errors)
    assert [] == secured.ledger.commands


def test_visitors_without_a_certificate_read_but_only_over_https(secured, of_operator):
    assert of_operator.url.startswith("https://127.0.0.1:")
    connection = http.client.HTTPSConnection(
        urlsplit(of_operator.url).netloc, timeout=PATIENCE, context=context(secured)
    )
    connection.request("GET", "/source")
    response = connection.getresponse()
    assert (200, {"kind": "live"}) == (response.status, json.loads(response.read()))
    connection.close()
    with opened(of_operator.url, ssl=context(secured)) as page:
        assert page.get("_world/scene")["replies"]
        page.say("subscribe", id=1, key="*/odom", every=0.05)
        assert page.samples(lambda payload: "pose" in payload)

    plain = http.client.HTTPConnection(urlsplit(of_operator.url).netloc, timeout=PATIENCE)
    with pytest.raises((http.client.HTTPException, OSError)):
        plain.request("GET", "/source") or plain.getresponse()
    plain.close()


def test_a_visitor_commands_until_its_certificate_expires(secured, of_operator, tmp_path):
    """The connection is then closed, with all its subscriptions."""

    def command(folder):
        with opened(of_operator.url, ssl=context(secured, folder)) as page:
            assert page.get(SEND, payload=GOAL).get("error") is None

    brief = secured.brief(tmp_path / "brief", lambda: command(secured.store.enclave("operator").folder))
    secured.ledger.commands.clear()
    with opened(of_operator.url, ssl=context(secured, brief.folder)) as page:
        assert page.get(SEND, payload=GOAL).get("error") is None
        with pytest.raises(ConnectionClosed, match=r"1008 .*the certificate of 'operator' has expired"):
            deque(iter(lambda: page.get("_world/scene"), None), maxlen=0)
    # Certificates count whole seconds.
    assert brief.left < 1.0
    assert ["SendGoal"] == secured.ledger.commands


def test_a_page_from_plain_http_may_not_use_the_visitors_certificate(secured, of_operator):
    own, tls = of_operator.url.rstrip("/"), context(secured)
    with opened(of_operator.url, ssl=tls, origin=own) as page:
        assert page.get("_world/scene")["replies"]
    with pytest.raises(InvalidStatus, match="403"), opened(of_operator.url, ssl=tls, origin=own.replace("s:", ":", 1)):
        pass


def test_beyond_this_machine_the_token_is_needed_too(secured):
    """The server's certificate does not give visitors permission to read."""
    with served(secured, "viewer", host="0.0.0.0") as server:
        port = urlsplit(server.url).port
        connection = http.client.HTTPSConnection(f"127.0.0.1:{port}", timeout=PATIENCE, context=context(secured))
        connection.request("GET", "/source")

        assert 403 == connection.getresponse().status
        connection.close()

"""The page's server: its files, headers, refusals and end."""

from __future__ import annotations

import gzip
import json
import logging
import socket
from contextlib import asynccontextmanager
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from hmrsim.drawing import PALETTE
from hmrsim.errors import HmrsimError
from hmrsim_zenoh.errors import BadOptions, PortTaken
from hmrsim_zenoh.view.server import ViewServer
from hmrsim_zenoh.view.sources import Recorded
from hmrsim_zenoh.wire.options import is_loopback
from tests.wire.view.pages import fetched, opened, viewed


class Tape:
    """A recording of three samples, or of one more that is damaged."""

    name, begin, end, truncated = "shift.mcap", 5, 7_000_000_000, False

    def __init__(self, *, damaged: bool = False) -> None:
        self.damaged = damaged

    def samples(self):
        yield 5, "_world/events", {"kind": "route", "robot": "wall_e"}
        yield 6, "_world/info", {"contract": 1}
        yield 7_000_000_000, "wall_e/battery_state", {"percentage": float("nan")}
        if self.damaged:
            raise HmrsimError("shift.mcap: chunk 3 is damaged")


@pytest.fixture
def tape():
    """Return a server of a recording."""
    with ViewServer(Recorded(Tape()), port=0) as server:
        yield server


def lines(body: bytes) -> list:
    return [json.loads(line) for line in body.splitlines()]


SAMPLES = [
    [5, "_world/events", {"kind": "route", "robot": "wall_e"}],
    [6, "_world/info", {"contract": 1}],
    [7_000_000_000, "wall_e/battery_state", {"percentage": None}],
]


def test_a_recording_is_described(tape):
    _, _, body = fetched(tape.url, "/source")

    expected = {"kind": "recording", "name": "shift.mcap", "begin": 5, "end": 7_000_000_000, "truncated": False}
    assert expected == json.loads(body)


def test_a_recording_is_sent_compressed_with_null_for_nan(tape):
    _, headers, body = fetched(tape.url, "/recording", **{"Accept-Encoding": "gzip"})

    assert "gzip" == headers["content-encoding"]
    assert lines(gzip.decompress(body)) == SAMPLES


def test_a_client_without_compression_gets_a_plain_recording(tape):
    _, headers, body = fetched(tape.url, "/recording", **{"Accept-Encoding": "identity"})

    assert "content-encoding" not in headers
    assert lines(body) == SAMPLES


def test_a_damaged_recording_is_sent_up_to_the_damage(caplog):
    with caplog.at_level(logging.WARNING), ViewServer(Recorded(Tape(damaged=True)), port=0) as server:
        _, _, body = fetched(server.url, "/recording", **{"Accept-Encoding": "identity"})

    assert lines(body) == SAMPLES
    assert ["shift.mcap: chunk 3 is damaged; only earlier samples are shown"] == [
        one.getMessage() for one in caplog.records
    ]


def test_a_recording_has_no_socket(tape):
    with pytest.raises(InvalidStatus, match=r"403|404"), opened(tape.url):
        pass


def test_a_simulator_is_described(server):
    assert b'{"kind":"live"}' == fetched(server.url, "/source")[2]


def test_the_palette_is_served(server):
    """The page uses the colors and shapes of the other drawings."""
    assert PALETTE == json.loads(fetched(server.url, "/palette.json")[2])


def test_scripts_have_the_type_of_scripts(server):
    """A browser runs no module of another type."""
    status, headers, _ = fetched(server.url, "/source/connection.js")

    assert (200, "text/javascript; charset=utf-8") == (status, headers["content-type"])


@pytest.mark.parametrize(
    "path",
    ["/../server.py", "/%2e%2e/server.py", "/map/../../server.py", "//etc/passwd", "/..%2fserver.py", "/nothing"],
)
def test_paths_outside_the_page_are_not_served(server, path):
    assert 404 == fetched(server.url, path)[0]


@pytest.mark.parametrize("path", ["/source", "/source/connection.js", "/nothing"])
def test_each_answer_has_security_headers(server, path):
    headers = fetched(server.url, path)[1]

    assert headers["content-security-policy"].startswith("default-src 'self'; ")
    assert ("nosniff", "no-referrer", "no-cache") == (
        headers["x-content-type-options"],
        headers["referrer-policy"],
        headers["cache-control"],
    )
    assert "server" not in headers


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:1", "[::1]:7448", "LOCALHOST:80"])
def test_each_name_of_the_loopback_is_accepted(server, host):
    """With `ssh -L` the port may differ."""
    assert 200 == fetched(server.url, "/source", Host=host)[0]


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:7448", "localhost@evil.example", "", "[::1"])
def test_foreign_host_names_are_refused(server, host):
    """A page of another origin could connect otherwise, by DNS rebinding."""
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
    upgrade["Sec-WebSocket-Key"] = "dGhlIHNhbXBsZSBub25jZQ=="

    assert 403 == fetched(server.url, "/source", Host=host)[0]
    assert 403 == fetched(server.url, "/ws", Host=host, **upgrade)[0]


@pytest.mark.parametrize("origin", ["https://evil.example", "null", "http://localhost:1", "file://"])
def test_pages_of_other_origins_are_refused(server, origin):
    assert 403 == fetched(server.url, "/source", Origin=origin)[0]
    with pytest.raises(InvalidStatus, match="403"), opened(server.url, origin=origin):
        pass


def test_the_servers_own_origin_is_accepted(server):
    with opened(server.url, origin=server.url.rstrip("/")) as page:
        assert "live" == page.hear("hello")["source"]


def test_the_url_on_the_loopback_has_no_token(server):
    assert server.url == f"http://127.0.0.1:{urlsplit(server.url).port}/"


@pytest.fixture
def elsewhere(simulator):
    """Serve beyond this machine; yield the URL here, and the token."""
    with viewed(simulator, host="0.0.0.0") as server:
        parts = urlsplit(server.url)
        yield f"http://127.0.0.1:{parts.port}/", parts.query.removeprefix("token=")


def test_the_token_gives_access_under_any_host_name(elsewhere):
    url, token = elsewhere

    assert 22 == len(token)
    assert 200 == fetched(url, f"/source?token={token}", Host="robots.lab:7448")[0]
    with opened(url, token=token) as page:
        assert "live" == page.hear("hello")["source"]


@pytest.mark.parametrize("query", ["", "?token=", "?token=x", "?token=%ff%c3%a9", "?other=1"])
@pytest.mark.parametrize("path", ["/", "/index.html", "/source"])
def test_without_the_token_the_page_explains_how_to_get_it(elsewhere, path, query):
    status, _, body = fetched(elsewhere[0], path + query)

    assert (403, b"the token is missing or wrong; open the URL that `hmrsim view` printed\n") == (status, body)


def test_without_the_token_there_is_no_socket(elsewhere):
    """Otherwise anybody could drive robots."""
    with pytest.raises(InvalidStatus, match="403"), opened(elsewhere[0]):
        pass


def test_scripts_need_no_token(elsewhere):
    """The page's own tags can't carry one."""
    assert 200 == fetched(elsewhere[0], "/source/connection.js")[0]


@pytest.mark.parametrize(
    ("host", "expected"),
    [("localhost", True), ("127.0.0.2", True), ("::1", True), ("0.0.0.0", False), ("::", False), ("robots.lab", False)],
)
def test_only_loopback_addresses_need_no_token(host, expected):
    assert expected == is_loopback(host)


def test_a_taken_port_is_an_error_with_address_and_option():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(PortTaken, match=f"^127.0.0.1:{port} is in use; give another with --port"):
            ViewServer(Recorded(Tape()), port=port)


@pytest.mark.parametrize("host", ["192.0.2.1", "nobody.invalid"])
def test_a_foreign_address_is_an_error_with_option_and_value(host):
    with pytest.raises(BadOptions, match=f"--host '{host}' is not an address of this machine"):
        ViewServer(Recorded(Tape()), host=host, port=0)


def test_the_server_ends_with_pages_open(simulator):
    """Pages get the code for a restart."""
    with viewed(simulator) as server, opened(server.url) as page:
        page.get("_world/info")
        server.close()

        with pytest.raises(ConnectionClosed, match="1012"):
            page.hear("never")


class Broken:
    """A source that fails to open."""

    def routes(self):
        return []

    @asynccontextmanager
    async def opened(self):
        raise OSError("no more files")
        yield


def test_a_server_that_fails_to_start_frees_its_port():
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with pytest.raises(HmrsimError, match="did not start"):
        ViewServer(Broken(), port=port)

    socket.create_server(("127.0.0.1", port)).close()

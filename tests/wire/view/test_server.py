"""The page's server: its files, its headers, its refusals, its end."""

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
from hmrsim_zenoh.wire.endpoints import is_loopback
from tests.wire.view.pages import fetched, opened, viewed


class Tape:
    """A recording of three samples; of more, if it is damaged, of which the last can't be read."""

    name, begin, end, truncated = "shift.mcap", 5, 7_000_000_000, False

    def __init__(self, *, damaged: bool = False) -> None:
        self.damaged = damaged

    def samples(self):
        """Yield them."""
        yield 5, "_world/events", {"kind": "route", "robot": "wall_e"}
        yield 6, "_world/info", {"contract": 1}
        yield 7_000_000_000, "wall_e/battery_state", {"percentage": float("nan")}
        if self.damaged:
            raise HmrsimError("shift.mcap: chunk 3 is damaged")


@pytest.fixture
def tape():
    """A server of a recording."""
    with ViewServer(Recorded(Tape()), port=0) as server:
        yield server


def lines(body: bytes) -> list:
    """Return what the lines of a body say."""
    return [json.loads(line) for line in body.splitlines()]


SAMPLES = [
    [5, "_world/events", {"kind": "route", "robot": "wall_e"}],
    [6, "_world/info", {"contract": 1}],
    [7_000_000_000, "wall_e/battery_state", {"percentage": None}],
]


def test_a_recording_is_described(tape):
    """The page asks first what it shows."""
    _, _, body = fetched(tape.url, "/source")

    expected = {"kind": "recording", "name": "shift.mcap", "begin": 5, "end": 7_000_000_000, "truncated": False}
    assert expected == json.loads(body)


def test_a_recording_is_sent_packed(tape):
    """A line a sample; what JSON has no number for is null."""
    _, headers, body = fetched(tape.url, "/recording", **{"Accept-Encoding": "gzip"})

    assert "gzip" == headers["content-encoding"]
    assert lines(gzip.decompress(body)) == SAMPLES


def test_a_recording_is_sent_plain(tape):
    """A client that doesn't accept compression gets it plain."""
    _, headers, body = fetched(tape.url, "/recording", **{"Accept-Encoding": "identity"})

    assert "content-encoding" not in headers
    assert lines(body) == SAMPLES


def test_a_damaged_recording_is_sent_as_far_as_it_goes(caplog):
    """What can be read is shown, and the log says what can't."""
    with caplog.at_level(logging.WARNING), ViewServer(Recorded(Tape(damaged=True)), port=0) as server:
        _, _, body = fetched(server.url, "/recording", **{"Accept-Encoding": "identity"})

    assert lines(body) == SAMPLES
    assert ["shift.mcap: chunk 3 is damaged; only earlier samples are shown"] == [
        one.getMessage() for one in caplog.records
    ]


def test_a_recording_has_no_socket(tape):
    """A recording has no simulator to query."""
    with pytest.raises(InvalidStatus, match=r"403|404"), opened(tape.url):
        pass


def test_a_simulator_is_described(server):
    """The page asks first what it shows."""
    assert b'{"kind":"live"}' == fetched(server.url, "/source")[2]


def test_the_palette_is_served(server):
    """The page draws in the colours and shapes of the other pictures."""
    assert PALETTE == json.loads(fetched(server.url, "/palette.json")[2])


def test_scripts_are_served_as_scripts(server):
    """A browser runs no module that is called otherwise."""
    status, headers, _ = fetched(server.url, "/source/connection.js")

    assert (200, "text/javascript; charset=utf-8") == (status, headers["content-type"])


@pytest.mark.parametrize(
    "path",
    ["/../server.py", "/%2e%2e/server.py", "/map/../../server.py", "//etc/passwd", "/..%2fserver.py", "/nothing"],
)
def test_nothing_but_the_page_is_served(server, path):
    """No way leads out of the page's folder."""
    assert 404 == fetched(server.url, path)[0]


@pytest.mark.parametrize("path", ["/source", "/source/connection.js", "/nothing"])
def test_each_answer_has_the_headers_of_a_careful_page(server, path):
    """The page loads nothing from elsewhere; browsers don't guess types, and other sites don't learn its URL."""
    headers = fetched(server.url, path)[1]

    assert headers["content-security-policy"].startswith("default-src 'self'; ")
    assert ("nosniff", "no-referrer", "no-cache") == (
        headers["x-content-type-options"],
        headers["referrer-policy"],
        headers["cache-control"],
    )
    assert "server" not in headers


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:1", "[::1]:7448", "LOCALHOST:80"])
def test_the_loopback_has_several_names(server, host):
    """A port may be another one, as with `ssh -L`."""
    assert 200 == fetched(server.url, "/source", Host=host)[0]


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:7448", "localhost@evil.example", "", "[::1"])
def test_other_names_are_refused(server, host):
    """A foreign name that resolves to this host is refused (DNS rebinding)."""
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
    upgrade["Sec-WebSocket-Key"] = "dGhlIHNhbXBsZSBub25jZQ=="

    assert 403 == fetched(server.url, "/source", Host=host)[0]
    assert 403 == fetched(server.url, "/ws", Host=host, **upgrade)[0]


@pytest.mark.parametrize("origin", ["https://evil.example", "null", "http://localhost:1", "file://"])
def test_other_pages_are_refused(server, origin):
    """A page of another origin may neither fetch nor open the socket."""
    assert 403 == fetched(server.url, "/source", Origin=origin)[0]
    with pytest.raises(InvalidStatus, match="403"), opened(server.url, origin=origin):
        pass


def test_its_own_page_is_welcome(server):
    """The browser says where its script is from."""
    with opened(server.url, origin=server.url.rstrip("/")) as page:
        assert "live" == page.hear("hello")["source"]


def test_no_token_on_the_loopback(server):
    """The URL is short."""
    assert server.url == f"http://127.0.0.1:{urlsplit(server.url).port}/"


@pytest.fixture
def elsewhere(simulator):
    """A server that others can reach; yields its URL on this machine, and its token."""
    with viewed(simulator, host="0.0.0.0") as server:
        parts = urlsplit(server.url)
        yield f"http://127.0.0.1:{parts.port}/", parts.query.removeprefix("token=")


def test_the_token_lets_in(elsewhere):
    """A browser with the URL sees the page, by whatever name the machine has."""
    url, token = elsewhere

    assert 22 == len(token)
    assert 200 == fetched(url, f"/source?token={token}", Host="robots.lab:7448")[0]
    with opened(url, token=token) as page:
        assert "live" == page.hear("hello")["source"]


@pytest.mark.parametrize("query", ["", "?token=", "?token=x", "?token=%ff%c3%a9", "?other=1"])
@pytest.mark.parametrize("path", ["/", "/index.html", "/source"])
def test_without_the_token_nothing_is_shown(elsewhere, path, query):
    """The text says what to do."""
    status, _, body = fetched(elsewhere[0], path + query)

    assert (403, b"the token is missing or wrong; open the URL that `hmrsim view` printed\n") == (status, body)


def test_without_the_token_there_is_no_socket(elsewhere):
    """Without the token, a page can't drive robots."""
    with pytest.raises(InvalidStatus, match="403"), opened(elsewhere[0]):
        pass


def test_scripts_need_no_token(elsewhere):
    """The page's own tags can't carry it, and everybody has the same scripts."""
    assert 200 == fetched(elsewhere[0], "/source/connection.js")[0]


@pytest.mark.parametrize(
    ("host", "expected"),
    [("localhost", True), ("127.0.0.2", True), ("::1", True), ("0.0.0.0", False), ("::", False), ("robots.lab", False)],
)
def test_what_only_this_machine_reaches(host, expected):
    """A name might lead anywhere."""
    assert expected == is_loopback(host)


def test_a_taken_port_is_an_error():
    """The text names the address and the option."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(PortTaken, match=f"^127.0.0.1:{port} is in use; give another with --port"):
            ViewServer(Recorded(Tape()), port=port)


@pytest.mark.parametrize("host", ["192.0.2.1", "nobody.invalid"])
def test_no_address_of_this_machine(host):
    """The text names the option and its value."""
    with pytest.raises(BadOptions, match=f"--host '{host}' is not an address of this machine"):
        ViewServer(Recorded(Tape()), host=host, port=0)


def test_it_ends_with_pages_open(simulator):
    """Pages get the code for a restart, and the server does not wait for them."""
    with viewed(simulator) as server, opened(server.url) as page:
        page.get("_world/info")
        server.close()

        with pytest.raises(ConnectionClosed, match="1012"):
            page.hear("never")


class Broken:
    """A source that can't be opened."""

    def routes(self):
        """Return nothing to ask."""
        return []

    @asynccontextmanager
    async def opened(self):
        """Fail."""
        raise OSError("no more files")
        yield


def test_a_server_that_can_not_begin_says_so():
    """At once, and its port is free again."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with pytest.raises(HmrsimError, match="did not start"):
        ViewServer(Broken(), port=port)

    socket.create_server(("127.0.0.1", port)).close()

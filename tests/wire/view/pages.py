"""Pages that speak to a server as a browser's do."""

from __future__ import annotations

import http.client
import json
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from websockets.sync.client import connect

from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.view.live import Live
from hmrsim_zenoh.view.server import ViewServer

PATIENCE = 20.0


class Page:
    """What a page's script does with its WebSocket."""

    def __init__(self, socket: Any) -> None:
        self.socket = socket

    def say(self, op: str, **fields: Any) -> None:
        """Send a frame."""
        self.socket.send(json.dumps({"op": op, **fields}))

    def hear(self, op: str) -> dict[str, Any]:
        """Return the next frame of a kind; frames of other kinds are skipped."""
        while (frame := json.loads(self.socket.recv(PATIENCE)))["op"] != op:
            pass
        return frame

    def get(self, key: str, **fields: Any) -> dict[str, Any]:
        """Ask a key, and return the answer."""
        self.say("get", id=77, key=key, **fields)
        return self.hear("reply")

    def samples(self, until) -> list[tuple[int, str, Any]]:
        """Return samples up to the first of which something is true."""
        heard = []
        while not any(until(payload) for _, _, payload in heard):
            heard.extend(tuple(sample) for sample in self.hear("samples")["samples"])
        return heard


@contextmanager
def opened(url: str, *, token: str = "", **options: Any):
    """Open a page."""
    query = f"?token={token}" if token else ""
    # Frames that are not read must not keep the socket from closing.
    with connect(f"{url.replace('http', 'ws', 1)}ws{query}", max_queue=None, **options) as socket:
        yield Page(socket)


@contextmanager
def viewed(options, **where: Any):
    """Serve the page of a simulator."""
    with (
        Client(options, clock="realtime") as client,
        ViewServer(Live(client.session, client.keys), port=0, **where) as server,
    ):
        yield server


def fetched(url: str, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Return status, headers and body of a path, which is sent as it is."""
    connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=PATIENCE)
    try:
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        return response.status, {name.lower(): value for name, value in response.getheaders()}, response.read()
    finally:
        connection.close()

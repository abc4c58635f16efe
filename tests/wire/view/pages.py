"""Pages that exchange frames with a server as a browser does."""

from __future__ import annotations

import asyncio
import http.client
import json
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from websockets.asyncio.client import connect

from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.view.server import ViewServer
from hmrsim_zenoh.view.sources import Live
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection


class Page:
    """A page's WebSocket, used like the page's script uses it.

    It reads and writes in one thread: OpenSSL allows no two at one connection, and with ``websockets.sync`` a request
    over TLS is lost once in a while.
    """

    def __init__(self, socket: ClientConnection, runner: asyncio.Runner) -> None:
        self._socket = socket
        self._runner = runner

    def say(self, op: str, **fields: Any) -> None:
        self.send(json.dumps({"op": op, **fields}))

    def send(self, frame: str | bytes) -> None:
        self._runner.run(self._socket.send(frame))

    def hear(self, op: str) -> dict[str, Any]:
        """Return the next frame of a kind; frames of other kinds are skipped."""
        while (frame := json.loads(self._runner.run(self._heard())))["op"] != op:
            pass
        return frame

    async def _heard(self) -> str | bytes:
        async with asyncio.timeout(PATIENCE):
            return await self._socket.recv()

    def vanish(self) -> None:
        self._socket.transport.abort()

    def get(self, key: str, **fields: Any) -> dict[str, Any]:
        """Query a key, and return the reply."""
        self.say("get", id=77, key=key, **fields)
        return self.hear("reply")

    def samples(self, until) -> list[tuple[int, str, Any]]:
        """Return samples up to the first one for which *until* holds."""
        heard = []
        while not any(until(payload) for _, _, payload in heard):
            heard.extend(tuple(sample) for sample in self.hear("samples")["samples"])
        return heard


@contextmanager
def opened(url: str, *, token: str = "", **options: Any):
    query = f"?token={token}" if token else ""
    with asyncio.Runner() as runner:
        # Frames that are not read must not keep the socket from closing.
        socket = runner.run(_connected(f"{url.replace('http', 'ws', 1)}ws{query}", max_queue=None, **options))
        try:
            yield Page(socket, runner)
        finally:
            runner.run(socket.close())


async def _connected(url: str, **options: Any) -> ClientConnection:
    return await connect(url, **options)


@contextmanager
def viewed(options, **where: Any):
    with (
        Client(options, clock="realtime") as client,
        ViewServer(Live(client.session, client.keys), port=0, **where) as server,
    ):
        yield server


def fetched(url: str, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Return status, headers and body of a path, which is sent unchanged."""
    connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=PATIENCE)
    try:
        connection.request("GET", path, headers=headers)
        response = connection.getresponse()
        return response.status, {name.lower(): value for name, value in response.getheaders()}, response.read()
    finally:
        connection.close()

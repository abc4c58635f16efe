"""A recording as the source of pages, sent as a whole, as the page does the playback."""

from __future__ import annotations

import logging
import zlib
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final, Protocol

from pydantic import ValidationError
from pydantic_core import to_json
from starlette.responses import JSONResponse, StreamingResponse
from starlette.routing import Route

from hmrsim.errors import HmrsimError
from hmrsim.world.model import World
from hmrsim.world_checks.resolved import shown

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.routing import BaseRoute

_CHUNK: Final = 256 * 1024
_GZIP: Final = 31
"""What zlib calls a window of 32 kB with gzip's header."""
_LEVEL: Final = 5

_log = logging.getLogger(__name__)


class Recording(Protocol):
    """The recording to show.

    Attributes:
        begin: Simulated nanoseconds of the first sample.
        end: Simulated nanoseconds of the last sample.
        truncated: Whether the end is missing, as after a crash.
    """

    begin: int
    end: int
    truncated: bool

    @property
    def name(self) -> str:
        """The name of the file."""

    def samples(self) -> Iterable[tuple[int, str, Any]]:
        """Return nanoseconds, key and payload of each sample, in order."""


class Recorded:
    """Serves a recording to pages."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording

    def routes(self) -> list[BaseRoute]:
        """Return the routes of the source beside the page's files."""
        return [Route("/source", self._source), Route("/recording", self._samples)]

    @asynccontextmanager
    async def opened(self) -> AsyncIterator[None]:
        """Do nothing: a recording does not change."""
        yield

    async def _source(self, _request: Request) -> Response:
        recording = self._recording
        return JSONResponse(
            {
                "kind": "recording",
                "name": recording.name,
                "begin": recording.begin,
                "end": recording.end,
                "truncated": recording.truncated,
            }
        )

    async def _samples(self, request: Request) -> Response:
        packed = "gzip" in request.headers.get("accept-encoding", "")
        chunks = _in_chunks(self._lines())
        return StreamingResponse(
            _gzip(chunks) if packed else chunks,
            media_type="application/x-ndjson",
            headers={"Vary": "Accept-Encoding", **({"Content-Encoding": "gzip"} if packed else {})},
        )

    def _lines(self) -> Iterator[bytes]:
        """Yield a line for each sample, up to the first unreadable one."""
        samples = self._recording.samples()
        try:
            for time, key, payload in samples:
                known = (
                    ("_world/view", shown(World.model_validate(payload))) if key == "_world/world" else (key, payload)
                )
                yield to_json((time, *known), inf_nan_mode="null") + b"\n"
        except (ValidationError, KeyError) as error:
            _log.warning("a world can't be read: %s; only earlier samples are shown", str(error).partition("\n")[0])
        except HmrsimError as error:
            _log.warning("%s; only earlier samples are shown", error)


def _in_chunks(lines: Iterable[bytes]) -> Iterator[bytes]:
    """Join lines to chunks: each chunk passes through a thread, which takes longer than encoding a line."""
    chunk = bytearray()
    for line in lines:
        chunk += line
        if len(chunk) >= _CHUNK:
            yield bytes(chunk)
            chunk.clear()
    yield bytes(chunk)


def _gzip(chunks: Iterable[bytes]) -> Iterator[bytes]:
    packer = zlib.compressobj(_LEVEL, wbits=_GZIP)
    for chunk in chunks:
        yield packer.compress(chunk)
    yield packer.flush()

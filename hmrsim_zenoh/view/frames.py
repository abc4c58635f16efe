"""The frames between a page and the server, as JSON text with embedded payloads, and the outbox of one page.

Each payload is validated as JSON before it is embedded, as any program may publish below the prefix and one invalid
payload would make the whole frame unreadable. The validation takes a few microseconds.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterable, Sequence
from operator import attrgetter
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import from_json

MIN_PERIOD: Final = 0.05
"""The default and smallest number of wall seconds between two frames of a subscription."""

_MAX_PERIOD: Final = 60.0
_MAX_SECONDS: Final = 60.0
_MAX_KEY: Final = 1_000

_Id = Annotated[int, Field(ge=0, lt=2**53)]
_Key = Annotated[str, Field(min_length=1, max_length=_MAX_KEY)]


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    id: _Id


class Subscribe(_Request):
    """Subscribes to a key expression; with *latest* a frame has only the newest sample of each key."""

    op: Literal["subscribe"]
    key: _Key
    latest: bool = False
    every: float = MIN_PERIOD

    @property
    def pause(self) -> float:
        """Wall seconds between two frames."""
        return min(max(self.every, MIN_PERIOD), _MAX_PERIOD)


class Unsubscribe(_Request):
    """A page's request to end a subscription."""

    op: Literal["unsubscribe"]


class Get(_Request):
    """Sends a query on a key."""

    op: Literal["get"]
    key: _Key
    payload: dict[str, Any] | None = None
    timeout: Annotated[float, Field(gt=0, le=_MAX_SECONDS)] = 5.0


Request = Subscribe | Unsubscribe | Get
_REQUEST: Final[TypeAdapter[Request]] = TypeAdapter(Annotated[Request, Field(discriminator="op")])


def read(text: str) -> Request:
    """Return the request in a frame of a page.

    Raises:
        ValueError: The frame is invalid; the text names the field and the problem.
    """
    try:
        return _REQUEST.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"{where}: {first['msg']}" if where else first["msg"]) from None


def is_json(payload: bytes) -> bool:
    """Return whether a payload can be embedded in a frame."""
    try:
        from_json(payload, allow_inf_nan=False)
    except ValueError:
        return False
    return True


def embedded(key: str, payload: bytes) -> str | None:
    """Return a key and its payload as the end of an array in a frame; None if the payload is not JSON."""
    return f"{json.dumps(key)},{payload.decode()}]" if is_json(payload) else None


def samples(entries: Iterable[tuple[int, str]]) -> str:
    """Return the frame of samples, each of which is a subscription's id and the result of `embedded`."""
    return f'{{"op":"samples","samples":[{",".join([f"[{id_},{text}" for id_, text in entries])}]}}'


def replies(id_: int, texts: Iterable[str]) -> str:
    """Return the frame that answers a get with replies, each of which is the result of `embedded`."""
    return f'{{"op":"reply","id":{id_},"replies":[{",".join([f"[{text}" for text in texts])}]}}'


def failure(id_: int, error: str, details: Sequence[dict[str, Any]] = ()) -> str:
    """Return the frame with the error of a get."""
    extra = {"details": [*details]} if details else {}
    return json.dumps({"op": "reply", "id": id_, "error": error, **extra})


def frame(op: str, **fields: object) -> str:
    """Return a frame of plain values."""
    return json.dumps({"op": op, **fields})


MAX_WAITING: Final = 4 * 2**20
"""The largest number of characters of a page's waiting samples; a slower page loses samples and is notified."""
MAX_WAITING_IN_ALL: Final = 16 * 2**20
"""The largest number of characters that wait for all pages together."""
_CROWDED: Final = 100


class _Pending:
    """The samples of one subscription."""

    def __init__(self, *, latest: bool) -> None:
        self.samples: list[str] = []
        self.newest: dict[str, str] | None = {} if latest else None
        self.size = 0
        self.lost = False

    def add(self, key: str, text: str) -> int:
        """Add a sample; return by how many characters the size grows."""
        before = ""
        if self.newest is None:
            self.samples.append(text)
        else:
            before = self.newest.get(key, "")
            self.newest[key] = text
        grown = len(text) - len(before)
        self.size += grown
        return grown

    def drain(self) -> list[str]:
        taken = [*self.samples, *(self.newest or {}).values()]
        self.clear()
        return taken

    def clear(self) -> None:
        self.samples.clear()
        if self.newest is not None:
            self.newest.clear()
        self.size = 0


_size = attrgetter("size")


class Outbox:
    """Frames, all of which are sent, and samples, of which the largest subscription loses some if there are too many.

    Args:
        max_size: The largest number of characters of waiting samples.
    """

    def __init__(self, max_size: int = MAX_WAITING) -> None:
        self._max_size = max_size
        self._frames: deque[str] = deque()
        self._frames_size = 0
        self._pending: dict[int, _Pending] = {}
        self._size = 0

    @property
    def crowded(self) -> bool:
        """True if so many frames are waiting that further requests have to wait, too."""
        return len(self._frames) >= _CROWDED or self.full

    @property
    def full(self) -> bool:
        """True if the waiting frames leave no room for another large one."""
        return self._frames_size > self._max_size

    def limit(self, max_size: int) -> None:
        """Set the largest number of characters of waiting samples from now on."""
        self._max_size = max_size

    def put(self, frame: str) -> None:
        """Send a frame to the page."""
        self._frames.append(frame)
        self._frames_size += len(frame)

    def open(self, id_: int, *, latest: bool) -> None:
        """Begin a subscription of the page."""
        self._pending[id_] = _Pending(latest=latest)

    def close(self, id_: int) -> None:
        """End a subscription; its waiting samples are dropped."""
        self._size -= self._pending.pop(id_).size

    def add(self, id_: int, entries: Iterable[tuple[str, str]], *, lost: bool) -> None:
        """Add samples of a subscription, each a key and a text; *lost* if some were dropped before already.

        After a loss no samples are added until the next `drain`: a page that receives `lost` queries all values again.
        """
        pending = self._pending[id_]
        if lost and pending.newest is None:
            self._lose(pending)
        if pending.lost:
            return
        for key, text in entries:
            self._size += pending.add(key, text)
        while self._size > self._max_size:
            self._lose(max(self._pending.values(), key=_size))

    def drain(self) -> list[str]:
        """Return and remove the frames to send now."""
        taken = [*self._frames]
        self._frames.clear()
        self._frames_size = 0
        texts: list[tuple[int, str]] = []
        for id_, pending in self._pending.items():
            texts.extend((id_, text) for text in pending.drain())
        self._size = 0
        if texts:
            taken.append(samples(texts))
        for id_, pending in self._pending.items():
            if pending.lost:
                pending.lost = False
                taken.append(frame("lost", id=id_))
        return taken

    def _lose(self, pending: _Pending) -> None:
        self._size -= pending.size
        pending.clear()
        pending.lost = True

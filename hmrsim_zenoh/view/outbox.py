"""What waits to be sent to one page: bounded, however slow the page is."""

from __future__ import annotations

from collections import deque
from operator import attrgetter
from typing import TYPE_CHECKING, Final

from hmrsim_zenoh.view import frames

if TYPE_CHECKING:
    from collections.abc import Iterable

MAX_WAITING: Final = 4 * 2**20
"""Characters of samples that wait for a page; who is slower than that, loses some and is told so."""
_CROWDED: Final = 100


class _Pending:
    """The samples of one subscription."""

    def __init__(self, *, latest: bool) -> None:
        self.samples: list[str] = []
        self.newest: dict[str, str] | None = {} if latest else None
        self.size = 0
        self.lost = False

    def add(self, key: str, text: str) -> int:
        """Add a sample; return by how much there is more."""
        before = ""
        if self.newest is None:
            self.samples.append(text)
        else:
            before = self.newest.get(key, "")
            self.newest[key] = text
        grown = len(text) - len(before)
        self.size += grown
        return grown

    def take(self) -> list[str]:
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
    """Frames as they are, which all are sent; and samples: if there are too many, the largest subscription's are lost.

    Args:
        most: Characters of samples that may wait.
    """

    def __init__(self, most: int = MAX_WAITING) -> None:
        self._most = most
        self._frames: deque[str] = deque()
        self._pending: dict[int, _Pending] = {}
        self._size = 0

    @property
    def crowded(self) -> bool:
        """Whether so many frames wait that no further request should be served."""
        return len(self._frames) >= _CROWDED

    def put(self, frame: str) -> None:
        """Send a frame."""
        self._frames.append(frame)

    def open(self, id_: int, *, latest: bool) -> None:
        """Begin a subscription."""
        self._pending[id_] = _Pending(latest=latest)

    def close(self, id_: int) -> None:
        """End a subscription: what waits of it is not sent."""
        self._size -= self._pending.pop(id_).size

    def add(self, id_: int, entries: Iterable[tuple[str, str]], *, lost: bool) -> None:
        """Send samples of a subscription, each a key and a text; *lost* says that some were dropped before already.

        Once some are lost, none is sent until what waits has been taken: a page that gets `lost` asks for all anew.
        """
        pending = self._pending[id_]
        if lost and pending.newest is None:
            self._lose(pending)
        if pending.lost:
            return
        for key, text in entries:
            self._size += pending.add(key, text)
        while self._size > self._most:
            self._lose(max(self._pending.values(), key=_size))

    def take(self) -> list[str]:
        """Return the frames to send now, and forget them."""
        taken = [*self._frames]
        self._frames.clear()
        texts: list[tuple[int, str]] = []
        for id_, pending in self._pending.items():
            texts.extend((id_, text) for text in pending.take())
        self._size = 0
        if texts:
            taken.append(frames.samples(texts))
        for id_, pending in self._pending.items():
            if pending.lost:
                pending.lost = False
                taken.append(frames.said("lost", id=id_))
        return taken

    def _lose(self, pending: _Pending) -> None:
        self._size -= pending.size
        pending.clear()
        pending.lost = True

"""The frames and samples to send to one page, bounded for slow pages."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from operator import attrgetter
from typing import Final

from hmrsim_zenoh.view import frames

MAX_WAITING: Final = 4 * 2**20
"""The largest number of characters of a page's waiting samples; a slower page loses samples and is notified."""
MAX_WAITING_IN_ALL: Final = 16 * 2**20
"""Likewise of all pages, which share it."""
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
        """Whether too many frames wait to serve further requests."""
        return len(self._frames) >= _CROWDED or self.full

    @property
    def full(self) -> bool:
        """Whether the frames that wait leave no room for one more that is large."""
        return self._frames_size > self._max_size

    def limit(self, max_size: int) -> None:
        """Set the largest number of characters of waiting samples from now on."""
        self._max_size = max_size

    def put(self, frame: str) -> None:
        """Send a frame."""
        self._frames.append(frame)
        self._frames_size += len(frame)

    def open(self, id_: int, *, latest: bool) -> None:
        """Begin a subscription."""
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
            taken.append(frames.samples(texts))
        for id_, pending in self._pending.items():
            if pending.lost:
                pending.lost = False
                taken.append(frames.frame("lost", id=id_))
        return taken

    def _lose(self, pending: _Pending) -> None:
        self._size -= pending.size
        pending.clear()
        pending.lost = True

"""Detection of subscribers in the same process, by what their sessions have declared."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping
from typing import TYPE_CHECKING, Generic, TypeVar

from hmrsim_zenoh.loopback.exchange import Kind

if TYPE_CHECKING:
    from hmrsim_zenoh.loopback.exchange import Exchange

K = TypeVar("K", bound="Hashable")


class LocalInterest(Generic[K]):
    """Whether there are subscribers, for each kind of keys; found out by each look.

    Args:
        exchange: Where they are.
        patterns: A key expression for each kind.

    Attributes:
        any: Whether any kind of keys had a subscriber at the last look.
    """

    def __init__(self, exchange: Exchange, patterns: Mapping[K, str]) -> None:
        self._exchange = exchange
        self._patterns = patterns
        self._listened = dict.fromkeys(patterns, False)
        self.any = False
        self._version = -1
        self._changes = 0

    def __getitem__(self, kind: K) -> bool:
        """Return whether a kind of keys had a subscriber at the last look."""
        return self._listened[kind]

    def look(self, kinds: Collection[K] | None = None) -> int:  # noqa: ARG002 - all of them are soon looked up
        """Check all kinds; return how often anything has changed."""
        if self._version != self._exchange.version:
            self._version = self._exchange.version
            for kind, pattern in self._patterns.items():
                listened = bool(self._exchange.matching(Kind.SUBSCRIBER, pattern))
                self._changes += listened != self._listened[kind]
                self._listened[kind] = listened
            self.any = any(self._listened.values())
        return self._changes

    def in_key(self, key: str) -> bool:
        """Return whether a key has a subscriber now."""
        return bool(self._exchange.matching(Kind.SUBSCRIBER, key))

    def join(self) -> None:
        """Do nothing: there is no thread."""

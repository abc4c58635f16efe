"""The ROS graph as a node sees it."""

from __future__ import annotations

import threading
from collections import Counter
from typing import TYPE_CHECKING, Any

import zenoh

from tests.patience import PATIENCE

if TYPE_CHECKING:
    from collections.abc import Callable


class Graph:
    """The liveliness tokens of a domain."""

    def __init__(self, session: zenoh.Session, domain: int) -> None:
        self.tokens: set[str] = set()
        self._endpoints: Counter[tuple[str, str, str]] = Counter()
        self._changed = threading.Condition(threading.RLock())
        self._subscriber = session.liveliness().declare_subscriber(
            f"@ros2_lv/{domain}/**", zenoh.handlers.Callback(self._take, indirect=False), history=True
        )

    def _take(self, sample: zenoh.Sample) -> None:
        token, here = str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT
        chunks = token.split("/")
        with self._changed:
            if here == (token in self.tokens):
                return
            (self.tokens.add if here else self.tokens.remove)(token)
            if len(chunks) in {13, 14}:
                self._endpoints[chunks[5], chunks[9], chunks[10]] += 1 if here else -1
            self._changed.notify_all()

    def wait(self, until: Callable[[set[str]], Any]) -> set[str]:
        """Return the tokens, once *until* holds for them."""
        with self._changed:
            assert self._changed.wait_for(lambda: until(self.tokens), PATIENCE), sorted(self.tokens)[:20]
            return set(self.tokens)

    def count(self, kind: str, name: str, type_: str) -> int:
        """Count the endpoints of a kind by name and type; like rmw_zenoh, ignore the hash."""
        with self._changed:
            return self._endpoints[kind, name.replace("/", "%"), type_]

    def wait_for(self, *wanted: tuple[str, str, str]) -> None:
        """Wait until there is an endpoint of each (kind, name, type)."""
        self.wait(lambda _tokens: all(self.count(*each) for each in wanted))

"""Subscriptions within one process."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hmrsim_zenoh.client.subscription import Subscription
from hmrsim_zenoh.loopback.session import LoopbackSession


class Session(LoopbackSession):
    """A session with one latched value and no new samples."""

    def __init__(self):
        """Do nothing, as there is no exchange."""

    def get(self, key):
        """Return the latched value."""
        payload = SimpleNamespace(to_bytes=lambda: b"latched")
        return [SimpleNamespace(ok=SimpleNamespace(key_expr=key, payload=payload))]

    def declare_subscriber(self, _key, _callback):
        """Return a subscriber to undeclare."""
        return SimpleNamespace(undeclare=lambda: None)


@pytest.mark.parametrize(("history", "expected"), [(True, [("w/map", b"latched")]), (False, [])])
def test_a_latched_value_is_delivered_to_who_asks_for_history(history, expected):
    seen = []
    with Subscription(Session(), "w/map", lambda key, payload: seen.append((key, payload)), history=history) as one:
        one.settle()

    assert expected == seen

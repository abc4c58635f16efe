"""Only the last event since the previous look is known, so two orders within seconds are one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher
from driving import listen

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

PERIOD = 10.0
"""Simulated seconds between two looks into the mailbox."""


class _Latest(Dispatcher):
    def __init__(self, client: Client) -> None:
        super().__init__(client)
        self._latest = ""
        self._known: list[str] = []
        self._next = 0.0
        listen(client, self._note)

    def _note(self, event: dict[str, Any]) -> None:
        if event["kind"] == "order_placed":
            self._latest = event["order"]  # the bug: there may be one in it

    def orders(self) -> Sequence[dict[str, Any]]:
        if self.client.now >= self._next:
            self._next = self.client.now + PERIOD
            self._known.append(self._latest)
        return [order for order in self.open_orders() if order["name"] in self._known]


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Latest if bug else Dispatcher)(client).serve()

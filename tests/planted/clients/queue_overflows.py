"""Orders wait in a queue with room for one, and a further order replaces it."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher
from driving import listen

if TYPE_CHECKING:
    from hmrsim_zenoh import Client

ROOM = 1
"""The bug: bursts are longer."""


class _Short(Dispatcher):
    def __init__(self, client: Client) -> None:
        super().__init__(client)
        self._queue: deque[str] = deque(maxlen=ROOM)
        listen(client, self._note)

    def _note(self, event: dict[str, Any]) -> None:
        if event["kind"] == "order_placed":
            self._queue.append(event["order"])

    def orders(self) -> Sequence[dict[str, Any]]:
        known = {order["name"]: order for order in self.open_orders()}
        return [known[name] for name in [*self._queue] if name in known]

    def begin(self, robot: str, order: dict[str, Any]) -> None:
        super().begin(robot, order)
        if order["name"] in self._queue:
            self._queue.remove(order["name"])


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Short if bug else Dispatcher)(client).serve()

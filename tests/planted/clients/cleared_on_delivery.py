"""The list of orders is cleared at each delivery, and orders that came meanwhile are lost."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher
from driving import listen

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Clears(Dispatcher):
    def __init__(self, client: Client) -> None:
        super().__init__(client)
        self._todo: list[str] = []
        listen(client, self._note)

    def _note(self, event: dict[str, Any]) -> None:
        if event["kind"] == "order_placed":
            self._todo.append(event["order"])
        if event["kind"] == "order_delivered":
            self._todo.clear()  # the bug: there may be others

    def orders(self) -> Sequence[dict[str, Any]]:
        return [order for order in self.open_orders() if order["name"] in self._todo]


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Clears if bug else Dispatcher)(client).serve()

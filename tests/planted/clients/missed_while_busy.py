"""Orders come as events, and those that come while the robot is busy are not noted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher
from driving import listen

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Deaf(Dispatcher):
    def __init__(self, client: Client) -> None:
        super().__init__(client)
        self._heard: list[str] = []
        listen(client, self._note)

    def _note(self, event: dict[str, Any]) -> None:
        if event["kind"] == "order_placed" and not self.work:  # the bug: busy robots do not listen
            self._heard.append(event["order"])

    def orders(self) -> Sequence[dict[str, Any]]:
        return [order for order in self.open_orders() if order["name"] in self._heard]

    def is_over(self) -> bool:
        return super().is_over() or (self.client.now >= 800.0 and not self.work)


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Deaf if bug else Dispatcher)(client).serve()

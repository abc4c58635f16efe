"""The nearest free robot gets an order, whether it can pick up items or not."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Careless(Dispatcher):
    def choose(self, order: dict[str, Any]) -> str | None:
        free = [robot for robot in self.drivers if robot not in self.work]  # the bug: not only those that are able
        return self.nearest(free, order["at"])


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Careless if bug else Dispatcher)(client).serve()

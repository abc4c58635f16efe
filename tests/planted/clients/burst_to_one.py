"""Each order is given to the nearest robot, whether it is free or not; the order that it had is forgotten."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Bursts(Dispatcher):
    def give(self, order: dict[str, Any]) -> None:
        """Give an order to the nearest robot."""
        if robot := self.nearest(self.able, order["at"]):  # the bug: it may be busy
            self.begin(robot, order)


def serve(client: Client, *, bug: bool = False) -> bool:
    """Serve the orders of a shift."""
    return (_Bursts if bug else Dispatcher)(client).serve()

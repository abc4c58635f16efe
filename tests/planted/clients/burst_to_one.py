"""Each order goes to the nearest robot, free or not, and the robot's earlier order is forgotten."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Bursts(Dispatcher):
    def give(self, order: dict[str, Any]) -> None:
        if robot := self.nearest(self.able, order["at"]):  # the bug: it may be busy
            self.begin(robot, order)


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Bursts if bug else Dispatcher)(client).serve()

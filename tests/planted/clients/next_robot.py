"""A failed order goes to the next robot of the list, and after the last one there is none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher, Job, Pause
from driving import PAUSE, scene

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Next(Dispatcher):
    def errand(self, robot: str, order: dict[str, Any]) -> Job:
        succeeded = yield from self.attempt(robot, order)
        if not succeeded:
            yield Pause(self.client.now + PAUSE)
        return succeeded

    def ended(self, robot: str, order: dict[str, Any], *, succeeded: bool) -> None:
        if succeeded:
            return
        self.taken.remove(order["name"])
        item = next((item for item in scene(self.client)["items"] if item["name"] == order["item"]), None)
        if item is None or item["carrier"] is not None:
            return
        other = self.able[self.able.index(robot) + 1]  # the bug: the last one has no next
        if other not in self.work:
            self.begin(other, order)


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Next if bug else Dispatcher)(client).serve()

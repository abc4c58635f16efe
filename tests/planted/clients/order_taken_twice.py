"""The order of a failed robot goes to another one, and stays with the first one, too."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher, Job, Pause

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _TakesTwice(Dispatcher):
    def errand(self, robot: str, order: dict[str, Any]) -> Job:
        driver = self.drivers[robot]
        steps = (
            lambda: driver.start_to(order["at"]),
            lambda: driver.start_pickup(order["item"]),
            lambda: driver.start_to(order["to"]),
            lambda: driver.start_place(order["item"]),
        )
        for step in steps:
            while not (yield step()):
                if order["name"] in self.taken:
                    self.taken.remove(order["name"])  # the bug: this robot goes on with it all the same
                yield Pause(self.client.now + 5)
        return True

    def ended(self, robot: str, order: dict[str, Any], *, succeeded: bool) -> None:
        """Do nothing: it has succeeded."""


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_TakesTwice if bug else Dispatcher)(client).serve()

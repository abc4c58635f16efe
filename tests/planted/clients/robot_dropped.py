"""A robot that has failed once gets no further order, until no robot is left."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher, Job

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Drops(Dispatcher):
    def ended(self, robot: str, order: dict[str, Any], *, succeeded: bool) -> None:
        super().ended(robot, order, succeeded=succeeded)
        if not succeeded and robot in self.able:
            self.able.remove(robot)  # the bug: for ever

    def errand(self, robot: str, order: dict[str, Any]) -> Job:
        return (yield from self.attempt(robot, order))


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Drops if bug else Dispatcher)(client).serve()

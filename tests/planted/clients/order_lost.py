"""The order of a failed robot stays assigned to that robot, which does not try again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dispatching import Dispatcher, Job

if TYPE_CHECKING:
    from hmrsim_zenoh import Client


class _Forgets(Dispatcher):
    def ended(self, robot: str, order: dict[str, Any], *, succeeded: bool) -> None:
        """Do nothing: the bug is that a failed order stays taken."""

    def errand(self, robot: str, order: dict[str, Any]) -> Job:
        return (yield from self.attempt(robot, order))


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Forgets if bug else Dispatcher)(client).serve()

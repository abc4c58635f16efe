"""A robot is busy until its goal has a terminal status, which a rejected goal never has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dispatching import Dispatcher

if TYPE_CHECKING:
    from driving import Handle

    from hmrsim_zenoh import Client


class _Stuck(Dispatcher):
    def has_ended(self, handle: Handle) -> bool:
        return handle.status.terminal  # the bug: a rejected goal is done without one


def serve(client: Client, *, bug: bool = False) -> bool:
    return (_Stuck if bug else Dispatcher)(client).serve()

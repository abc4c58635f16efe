"""Nav2's SingleTrigger: a child that has its turn once."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Decoration
from bt_controller.core.ports import BOOL, input_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from collections.abc import Generator

    from py_trees.behaviour import Behaviour


class SingleTrigger(Decoration):
    """Ticks its child until it has ended, and is what it is; after that it fails until it is reset.

    With ``is_global`` it fails for as long as the tree is run, however often it is reset.
    """

    INPUTS: ClassVar = {"is_global": input_port(BOOL, "Whether a reset changes nothing", default=False)}

    _triggered = False

    def initialise(self) -> None:
        """Be ready, if the node is idle."""
        if self.status is Status.INVALID and not self.read("is_global"):
            self._triggered = False

    def advance(self) -> Generator[Behaviour, None, Status]:
        """Tick the child, if it has not ended before."""
        if self._triggered:
            return Status.FAILURE
        status = yield from self.tick_child()
        self._triggered = status in (Status.SUCCESS, Status.FAILURE)
        return status


FAMILY = Family("single_trigger", {"SingleTrigger": SingleTrigger})

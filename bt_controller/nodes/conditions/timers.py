"""Nav2's conditions on simulated time."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import FINITE, PATH, input_port
from bt_controller.core.sim_time import now, reached
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from hmrsim.interfaces.nav_msgs import Path

_SECONDS = input_port(FINITE, "Duration in seconds", default=1.0)


class TimeExpired(Condition):
    """Succeeds each time ``seconds`` have passed since its last success or its first tick."""

    INPUTS: ClassVar = {"seconds": _SECONDS}

    _until = 0.0

    def next_tick_time(self) -> float:
        """Return the end of the duration."""
        return self._until

    def update(self) -> Status:
        """Check the time."""
        begins = self.status is Status.INVALID
        over = not begins and reached(self._until)
        if begins or over:
            self._until = now() + self.read("seconds")
        return Status.SUCCESS if over else Status.FAILURE


class PathExpiringTimer(Condition):
    """Succeeds each time ``seconds`` have passed since its first tick, its last success or the last change of path."""

    INPUTS: ClassVar = {"seconds": _SECONDS, "path": input_port(PATH, "The path", required=False)}

    _until: float | None = None
    _path: Path | None = None

    def next_tick_time(self) -> float:
        """Return the end of the duration."""
        return 0.0 if self._until is None else self._until

    def update(self) -> Status:
        """Check the time."""
        path = self.read("path")
        if self._until is None or path != self._path:
            self._path = path
            self._until = now() + self.read("seconds")
            return Status.FAILURE
        if not reached(self._until):
            return Status.FAILURE
        self._until = now() + self.read("seconds")
        return Status.SUCCESS


FAMILY = Family.of("timers", PathExpiringTimer, TimeExpired)

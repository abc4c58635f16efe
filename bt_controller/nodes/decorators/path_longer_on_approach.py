"""Nav2's PathLongerOnApproach: handling of a detour shortly before the goal."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Decoration, Ticks
from bt_controller.core.ports import FINITE, PATH, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.paths import length_of
from hmrsim.interfaces.nav_msgs import Path


class PathLongerOnApproach(Decoration):
    """Ticks its child when a new path to the same goal is much longer than the previous, short one.

    The previous path has to be shorter than ``prox_len``, in the world's unit of length, and the new one more than
    ``length_factor`` times as long. Otherwise the node succeeds at once.
    """

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "prox_len": input_port(FINITE, "Largest length of the previous path", default=3.0),
        "length_factor": input_port(FINITE, "Smallest ratio of the lengths", default=2.0),
    }

    _old = Path()

    def advance(self) -> Ticks:
        """Compare the path with the previous one, and tick the child if it is much longer."""
        new = self.read("path") or Path()
        if self.child.status is not Status.RUNNING and not self._is_detour(new):
            self._old = new
            return Status.SUCCESS
        status = yield from self.tick_child()
        if status is not Status.RUNNING:
            self._old = new
        return status

    def _is_detour(self, new: Path) -> bool:
        old = self._old
        if not (old.poses and new.poses) or old.poses[-1].pose != new.poses[-1].pose:
            return False
        before = length_of(old)
        detour: bool = before < self.read("prox_len") and length_of(new) > self.read("length_factor") * before
        return detour


FAMILY = Family.of("path_longer_on_approach", PathLongerOnApproach)

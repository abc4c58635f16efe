"""The controller ends before the limit of simulated time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.results import Ended, Tell, Verdict


class MissionEnds(Watcher):
    """Knows how the run has ended."""

    def __init__(self, tell: Tell) -> None:
        super().__init__("mission_ends", tell)
        self._at = 0
        self._ending = ""

    def end(self, at: int, ended: Ended | None) -> None:
        """Tell if the run has come to its limit."""
        self._at, self._ending = at, ended.ending if ended else ""
        if self._ending == "timeout":
            self.violate(at, "", "timeout", f"the controller had not ended by {at / NANOSECONDS:g} s")

    def unless_violated(self) -> Verdict:
        """Return whether the controller has ended by itself."""
        if self._ending in {"", "stopped"}:
            return self._is("undecided", 0.0, "the run was stopped before the controller ended")
        return self._is("holds", 1.0, f"the controller ended after {self._at / NANOSECONDS:.1f} s")

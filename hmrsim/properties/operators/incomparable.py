"""A property that compares a run with one without faults, where there is none to compare with."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.properties.watcher import Watcher

if TYPE_CHECKING:
    from hmrsim.properties.results import Verdict


class Incomparable(Watcher):
    """Is never violated, and says why nothing is known."""

    def unless_violated(self) -> Verdict:
        """Return that it is undecided."""
        return self._is("undecided", 0.0, "there is no run without faults to compare with")

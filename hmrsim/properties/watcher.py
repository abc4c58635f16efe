"""The base of what watches over one property."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.properties.results import Verdict, Violation

if TYPE_CHECKING:
    from hmrsim.properties.results import Ended, State, Tell

_STOPPED: Final = "stopped"


class Watcher:
    """Watches over one property; a subclass wants occurrences of a timeline.

    Args:
        name: The property's name.
        tell: Takes violations.

    Attributes:
        first: The first violation; None if there is none.
        count: How many violations there are.
    """

    def __init__(self, name: str, tell: Tell) -> None:
        self.name = name
        self.first: Violation | None = None
        self.count = 0
        self._tell = tell

    def violate(self, at: int, subject: str, reason: str, text: str, *, fatal: bool = False) -> None:
        """Tell of a violation."""
        found = Violation(self.name, subject, at, reason, text, fatal)
        self.count += 1
        self.first = self.first or found
        self._tell(found)

    def begin(self, at: int) -> None:
        """Take note of the begin of the run."""

    def end(self, at: int, ended: Ended | None) -> None:
        """Take note of the end of the run; *ended* is None where it is not known how."""

    def verdict(self) -> Verdict:
        """Return what has become of the property."""
        if self.first is None:
            return self.unless_violated()
        more = f", and {self.count - 1} more" if self.count > 1 else ""
        return Verdict(self.name, "violated", self.robustness_violated, f"{self.first.text}{more}")

    @property
    def robustness_violated(self) -> float:
        """The robustness of a violated property."""
        return -1.0

    def unless_violated(self) -> Verdict:
        """Return the verdict on a property that is not violated."""
        raise NotImplementedError

    def _is(self, state: State, robustness: float, text: str) -> Verdict:
        return Verdict(self.name, state, max(-1.0, min(1.0, robustness)), text)


def cut_off(ended: Ended | None) -> bool:
    """Return whether a run was ended by something else than itself, so that what has not come might have come."""
    return ended is not None and ended.ending == _STOPPED

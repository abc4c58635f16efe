"""The results of checking a run: violations, a verdict on each property, the run's ending and its items at the end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

if TYPE_CHECKING:
    from hmrsim.geometry import Point

State = Literal["holds", "violated", "undecided", "never_exercised"]


class Violation(NamedTuple):
    """A property does not hold.

    Attributes:
        subject: The robot, order or place that it is about; empty for the whole run.
        at: When, in nanoseconds of simulated time since the run began.
        reason: Why, as a short text that stays the same where only times, ids and robots differ.
        text: Why, as a sentence without a full stop.
        fatal: Whether the run may as well end, as it can no longer succeed.
    """

    property: str
    subject: str
    at: int
    reason: str
    text: str
    fatal: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON values, with the time in seconds."""
        return {**self._asdict(), "at": self.at / NANOSECONDS}


class Verdict(NamedTuple):
    """The verdict on a property at the end of a run.

    Attributes:
        state: ``undecided`` if the run ended too early to decide; ``never_exercised`` if nothing that the property is
            about has happened, so that it says nothing.
        robustness: How far it was from the opposite, from -1 to 1; negative if it is violated.
        text: Why, as a sentence without a full stop.
    """

    property: str
    state: State
    robustness: float
    text: str

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return self._asdict()


class Ended(NamedTuple):
    """The ending of a run.

    Attributes:
        ending: ``succeeded`` or ``failed`` if the controller has ended by itself, ``crashed``, ``hung``,
            ``deadlock``, ``out_of_memory`` or ``died`` if it has not lived to the end, ``timeout`` at the limit of
            simulated time, ``stopped`` if something else has ended the run.
        cause: Why, as one line; may be empty.
    """

    ending: str
    cause: str = ""


OnViolation = Callable[[Violation], None]
"""A function to call with each violation."""


class ItemEnd(NamedTuple):
    """The location of an item at the end of a run.

    Attributes:
        at: Where it lies, in the world's unit.
        carried: Whether a robot holds it.
    """

    at: Point
    carried: bool


Reference = Mapping[str, ItemEnd]
"""The items at the end of a run, by name."""


def reference_of(scene: Mapping[str, Any]) -> Reference:
    """Return the items of a scene, as `hmrsim.simulation.snapshot.scene` returns it."""
    return {
        item["name"]: ItemEnd((item["at"][0], item["at"][1]), item["carrier"] is not None) for item in scene["items"]
    }

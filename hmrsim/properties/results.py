"""What a monitor finds: violations, and a verdict on each property."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS

State = Literal["holds", "violated", "undecided", "never_exercised"]


class Violation(NamedTuple):
    """A property does not hold.

    Attributes:
        property: The property's name.
        subject: Whose fault it is: a robot, an order, a place; empty for the whole run.
        at: When, in nanoseconds of simulated time since the run began.
        reason: Why, as a short text that stays the same where only times, ids and robots differ.
        text: Why, as a sentence without a full stop.
        fatal: Whether nothing good can come any more, so that the run may as well end.
    """

    property: str
    subject: str
    at: int
    reason: str
    text: str
    fatal: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return it in plain values of JSON, with the time in seconds."""
        return {**self._asdict(), "at": self.at / NANOSECONDS}


class Verdict(NamedTuple):
    """What has become of a property at the end of a run.

    Attributes:
        state: ``undecided`` if the run ended before it could be said; ``never_exercised`` if nothing of what it speaks
            of has happened, so that it says nothing.
        robustness: How far it was from the opposite, from -1 to 1; negative if it is violated.
        text: Why, as a sentence without a full stop.
    """

    property: str
    state: State
    robustness: float
    text: str

    def as_dict(self) -> dict[str, Any]:
        """Return it in plain values of JSON."""
        return self._asdict()


class Ended(NamedTuple):
    """How a run has ended.

    Attributes:
        ending: ``succeeded`` or ``failed`` if the controller has ended by itself, ``crashed``, ``hung``,
            ``deadlock``, ``out_of_memory`` or ``died`` if it has not lived to the end, ``timeout`` at the limit of
            simulated time, ``stopped`` if something else has ended the run.
        cause: Why, as one line; may be empty.
    """

    ending: str
    cause: str = ""


Tell = Callable[[Violation], None]
"""Takes a violation."""

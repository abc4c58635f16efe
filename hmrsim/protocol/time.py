"""The requests and replies of controllers that take part in lockstep, and those about the clock.

The terms are those of conservative synchronization: a participant joins, asks to advance, and is granted time.
Epochs count the grants. Times are simulated seconds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

REALTIME = "realtime"
LOCKSTEP = "lockstep"
CLOCKS = (REALTIME, LOCKSTEP)
"""The clocks that a simulation can have."""

KINDS = ("status", "feedback", "result")
"""The kinds of events that can wake a participant."""


class Join(NamedTuple):
    """Join lockstep; answered by `Joined`.

    Attributes:
        token: A secret by which the simulator recognizes a repeated request, which gets the same answer; may be empty.
    """

    name: str
    reply_to: Any = None
    token: str = ""


class Leave(NamedTuple):
    """Leave lockstep; answered by `HasLeft`."""

    participant: str
    reply_to: Any = None


class TokenSeen(NamedTuple):
    """A participant's liveliness token has appeared, or has gone."""

    participant: str
    alive: bool


class SetClock(NamedTuple):
    """Change the clock; answered by `TimeState`.

    Attributes:
        clock: One of `CLOCKS`; None to keep it.
        real_time_factor: Simulated seconds per wall second, 0 for as fast as possible; None to keep it.
    """

    clock: str | None = None
    real_time_factor: float | None = None
    reply_to: Any = None


class ReadTime(NamedTuple):
    """Ask for the state of time; answered by `TimeState`."""

    reply_to: Any = None


class CheckWatchdog(NamedTuple):
    """Check whether any participant has taken too long to answer."""


class Intervene(NamedTuple):
    """Call a function in the simulation's thread, after all events of the current instant."""

    act: Callable[[], None]


class Joined(NamedTuple):
    """The answer to `Join`: the participant may now ask to advance.

    Attributes:
        epoch: The epoch of its first request to advance.
        goals: The number of goals that were sent under this name before.
    """

    participant: str
    epoch: int
    now: float
    goals: int


class HasLeft(NamedTuple):
    """The answer to `Leave`: the participant has left."""

    participant: str


class TimeState(NamedTuple):
    """The state of simulated time.

    Attributes:
        clock: One of `CLOCKS`.
        real_time_factor: The intended simulated seconds per wall second; 0 for as fast as possible.
        epoch: The epoch of the next grant in lockstep.
        waiting_for: The participants that have yet to ask to advance, or to join for the first time; a number if their
            names are unknown. ``_planner`` while an external planner has yet to answer.
        lag: The wall seconds by which simulated time is late in total because the machine could not keep up.
    """

    now: float
    clock: str
    real_time_factor: float
    paused: bool
    epoch: int
    participants: tuple[str, ...]
    waiting_for: tuple[str, ...]
    lag: float

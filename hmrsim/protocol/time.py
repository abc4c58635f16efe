"""Requests and replies of the controllers that take part in lockstep: plain frozen values.

The terms are those of conservative synchronization: a participant joins, asks to advance, and is granted time.
Epochs count the grants. Times are simulated seconds here, as they are in requests and replies.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

REALTIME = "realtime"
LOCKSTEP = "lockstep"
CLOCKS = (REALTIME, LOCKSTEP)
"""The clocks."""

KINDS = ("status", "feedback", "result")
"""The kinds of events that can wake a participant."""


class Join(NamedTuple):
    """Join lockstep; answered by `Joined`.

    Attributes:
        token: A secret of this participant, so that a repeated request gets the first answer again; empty for no token.
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
    """Check whether a participant has exceeded its time to answer."""


class Intervene(NamedTuple):
    """Call a function in the simulation's thread, when all of this instant has been taken."""

    act: Callable[[], None]


class Joined(NamedTuple):
    """A participant may ask to advance.

    Attributes:
        epoch: The epoch to begin with.
        goals: How many goals were sent under this name before.
    """

    participant: str
    epoch: int
    now: float
    goals: int


class HasLeft(NamedTuple):
    """The notice that a participant has left."""

    participant: str


class TimeState(NamedTuple):
    """The state of simulated time.

    Attributes:
        clock: One of `CLOCKS`.
        real_time_factor: Simulated seconds a wall second that are aimed at; 0 for as fast as possible.
        epoch: In lockstep, which grant is next.
        waiting_for: The participants that have yet to ask to advance, or to join for the first time; a number in
            place of names that are not known. ``_planner`` while an external planner has yet to answer.
        lag: Total wall seconds that simulated time lags behind, as the machine could not keep up.
    """

    now: float
    clock: str
    real_time_factor: float
    paused: bool
    epoch: int
    participants: tuple[str, ...]
    waiting_for: tuple[str, ...]
    lag: float

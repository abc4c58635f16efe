"""The liveliness tokens of the simulator and its robots."""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress
from typing import TYPE_CHECKING

import zenoh

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.keys import Keys

MAX_TOKENS = 1000
"""The largest number of robots with tokens: declaring them takes quadratic time."""


class LivelinessTokens:
    """The tokens of one simulation."""

    def __init__(self, session: zenoh.Session, keys: Keys) -> None:
        self._liveliness = session.liveliness()
        self._keys = keys
        self._simulator: zenoh.LivelinessToken | None = None
        self._robots: dict[str, zenoh.LivelinessToken] = {}

    def declare(self, robots: Collection[str]) -> None:
        """Declare the robots' tokens and then the simulator's."""
        self._follow(robots)
        self._simulator = self._liveliness.declare_token(self._keys.alive())

    def follow(self, robots: Collection[str], lost: Collection[str] = ()) -> None:
        """Declare the tokens of exactly these robots, if the simulator has its own; lost robots have none."""
        if self._simulator is not None:
            with suppress(zenoh.ZError):
                self._follow(robots, lost)

    def undeclare(self) -> None:
        """Undeclare all tokens."""
        tokens = [*self._robots.values(), *([self._simulator] if self._simulator else [])]
        self._robots, self._simulator = {}, None
        for token in tokens:
            token.undeclare()

    def _follow(self, robots: Collection[str], lost: Collection[str] = ()) -> None:
        wanted = dict.fromkeys(robot for robot in robots if robot not in lost) if len(robots) <= MAX_TOKENS else {}
        for robot in [robot for robot in self._robots if robot not in wanted]:
            self._robots.pop(robot).undeclare()
        for robot in wanted:
            if robot not in self._robots:
                self._robots[robot] = self._liveliness.declare_token(self._keys.alive(robot))

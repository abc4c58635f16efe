"""Random numbers for everything that a world leaves to chance.

There is a stream for each subject and use, and each occurrence has its number: the third time that a door
opens takes as long whatever else has happened before. So two controllers under one seed meet the same world, in
whatever order they do things: common random numbers (Law, Simulation Modeling and Analysis, 5th edition, 11.2).
"""

from __future__ import annotations

import hashlib
import random
from collections import defaultdict
from typing import TYPE_CHECKING, Final

from hmrsim.distributions import Distribution

if TYPE_CHECKING:
    from hmrsim.distributions import RandomValue

_BITS: Final = 53
"""Bits of a random number: those of a float's mantissa."""

_WHOLE: Final = 2.0**_BITS


class Chance:
    """The random streams of a run; `begin` restarts all of them.

    Attributes:
        used: Whether any random number was asked for: if not, the seed has decided nothing so far.
    """

    def __init__(self) -> None:
        self.used = False
        self._seed = 0
        self._occurrences: defaultdict[tuple[str, str], int] = defaultdict(int)

    def begin(self, seed: int) -> None:
        """Begin all streams of a seed."""
        self._seed = seed
        self._occurrences.clear()

    def draw(self, value: RandomValue, subject: str, use: str) -> float:
        """Return the value of the next occurrence; a number stands for itself.

        Args:
            value: A number or a distribution.
            subject: Whom it concerns: a robot, a door, an order.
            use: The purpose, such as ``opening_time``.
        """
        if not isinstance(value, Distribution):
            return value
        self._occurrences[subject, use] += 1
        return self.drawn(value, subject, use, self._occurrences[subject, use])

    def stream(self, seed: str) -> random.Random:
        """Return a sequence of random numbers for a consumer that needs any number of them."""
        # Not for cryptography: the numbers have to be the same in each run.
        return _Stream(seed, self)

    def choose(self, count: int, subject: str, use: str, occurrence: int) -> int:
        """Return a random index below a count, each with the same probability."""
        return 0 if count == 1 else int(self._number(subject, use, occurrence) * count)

    def drawn(self, value: RandomValue, subject: str, use: str, occurrence: int) -> float:
        """Return the value of an occurrence by its number; it is the same each time."""
        if not isinstance(value, Distribution):
            return value
        return value.value(self._number(subject, use, occurrence))

    def _number(self, subject: str, use: str, occurrence: int) -> float:
        """Return a random number between 0 and 1, both excluded."""
        self.used = True
        text = f"{self._seed}/{subject}/{use}/{occurrence}".encode()
        number = int.from_bytes(hashlib.blake2b(text, digest_size=8).digest()) >> (64 - _BITS)
        return (number + 0.5) / _WHOLE


class _Stream(random.Random):
    """A sequence of random numbers that notes that it is used."""

    def __init__(self, seed: str, chance: Chance) -> None:
        super().__init__(seed)
        self._chance = chance

    def random(self) -> float:
        self._chance.used = True
        return super().random()

    def getrandbits(self, k: int, /) -> int:
        self._chance.used = True
        return super().getrandbits(k)

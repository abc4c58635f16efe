"""Which of its times a run has used up: that in which it waits, or that of the processor."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Final, Protocol

from hmrsim.trials.processor import Usage

_BETWEEN_LOOKS: Final = 0.02
"""Wall seconds between two looks at least."""
_PATIENCE: Final = 0.5
"""The part of the shortest limit within which a run has to end when its time is over."""
_GRACE: Final = 5.0
"""Wall seconds to add to that."""


class Limits(Protocol):
    """What a run may take."""

    @property
    def wall(self) -> float:
        """Seconds of the wall's clock in which it computes nothing."""

    @property
    def processor(self) -> float | None:
        """Seconds of processor time; None for as many as *wall* says."""

    @property
    def memory(self) -> int | None:
        """Bytes that it may take beyond what its worker has."""


class Meter:
    """Measures what a run takes, from now on.

    Time of the wall in which the run could compute, but other processes have the processor, counts for no limit.

    Args:
        limits: What the run may take.
        seconds: Wall seconds after which its time is over in any case.
        clock: Returns the wall's time, in seconds.
        usage: Returns what was used of the processor.

    Attributes:
        why: Which of its times is over, in words; empty while none is.
    """

    def __init__(
        self,
        limits: Limits,
        seconds: float = math.inf,
        clock: Callable[[], float] = time.monotonic,
        usage: Callable[[], Usage] = Usage.now,
    ) -> None:
        self.why = ""
        self._wall, self._seconds = limits.wall, seconds
        self._processor = limits.wall if limits.processor is None else limits.processor
        self._clock, self._usage = clock, usage
        # In this order, and in that of `look`, what happens between the two readings counts as no wait.
        self._at_first = self._before = usage()
        self._began = self._looked = clock()
        self._busy = 0.0

    @property
    def left(self) -> float:
        """Wall seconds until one of its times may be over."""
        used = self._before.used - self._at_first.used
        since = self._looked - self._began
        return max(_BETWEEN_LOOKS, min(self._wall - since + self._busy, self._processor - used, self._seconds - since))

    @property
    def patience(self) -> float:
        """Wall seconds until a run does not mind that its time is over, if nobody looks before."""
        return self.left + _PATIENCE * min(self._wall, self._processor) + _GRACE

    def look(self) -> bool:
        """Measure; return whether one of its times is over."""
        self._looked = self._clock()
        usage, before = self._usage(), self._before
        self._before = usage
        # A thread that ends takes its delays with it, and so does a process.
        self._busy += max(0.0, usage.used - before.used) + max(0.0, usage.delayed - before.delayed)
        since = self._looked - self._began
        if usage.used - self._at_first.used >= self._processor:
            self.why = f"it takes longer than {self._processor:g} s of processor time"
        elif since - self._busy >= self._wall:
            self.why = f"it has waited for {self._wall:g} wall seconds without computing anything"
        elif since >= self._seconds:
            self.why = f"it takes longer than the {self._seconds:.3g} wall seconds that were left for it"
        return bool(self.why)

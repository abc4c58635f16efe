"""The order in which a demo prints the output of two processes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.cli.demo_story import Line

_OTHER: Final = {"tree": "world", "world": "tree"}


class CausalOrder:
    """Puts the lines of the world and of the trees in the order of cause and effect.

    They arrive by different ways, and the controller reads the time from a clock that ticks, so neither arrival nor
    time gives the order. But a robot's behaviour begins, its goal executes, and then the behaviour ends: a line
    waits for its source's turn.

    Args:
        patience: Maximum wall seconds that a line waits.
    """

    def __init__(self, patience: float) -> None:
        self._patience = patience
        self._waiting: list[tuple[float, Line]] = []
        self._turns: dict[str, str] = {}
        self._times: dict[str, float] = {}

    def add(self, line: Line, now: float) -> None:
        """Add a line that arrived *now*, in wall seconds."""
        self._waiting.append((now + self._patience, line))

    def ready(self, now: float) -> Iterator[Line]:
        """Yield the lines whose turn it is *now*, in wall seconds, with times that never go back for a robot."""
        while (i := self._next(now)) is not None:
            _, line = self._waiting.pop(i)
            self._turns[line.robot] = _OTHER[line.source] if line.hands_over else line.source
            time = max(line.sim_time or 0.0, self._times.get(line.robot, 0.0))
            self._times[line.robot] = time
            yield line._replace(sim_time=time or None)

    def _next(self, now: float) -> int | None:
        """Return the first line that may be printed; None if all have to wait."""
        for i, (until, line) in enumerate(self._waiting):
            # A line without a robot does not wait.
            if not line.robot or line.source == self._turns.get(line.robot, "tree") or until <= now:
                return i
        return None

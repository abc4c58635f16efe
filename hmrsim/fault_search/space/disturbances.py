"""The disturbances of the wire and of the controller that can be tried."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

_LASTING: Final = ("controller_stalled",)
_RESTART: Final = 5.0
"""Simulated seconds until a controller that was killed is started again."""

KINDS: Final = (
    "controller_stalled",
    "controller_killed",
    "reply_lost",
    "request_repeated",
    "second_controller",
    "simulation_reset",
)
"""The kinds of disturbances, the mildest first."""


def disturbances_of(durations: Sequence[float]) -> Iterator[dict[str, Any]]:
    """Yield the disturbances that can be tried, without the time at which they begin.

    Args:
        durations: Simulated seconds that those last that last.
    """
    for kind in KINDS:
        said: dict[str, Any] = {"disturbance": kind}
        if kind in _LASTING:
            yield from ({**said, "duration": seconds} for seconds in durations)
        elif kind == "controller_killed":
            yield {**said, "restart_after": _RESTART}
        else:
            yield said

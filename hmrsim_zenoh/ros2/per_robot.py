"""Caches of what is found out for each robot: they hold the robots of the fleet, and not all that ever were there."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Final, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

_SPARE: Final = 100
"""Robots that are kept beyond twice the fleet."""

_caches: Final[list[Any]] = []


def cached_per_robot(function: F) -> F:
    """Keep what a function returns for each robot, until `trim`."""
    kept: Any = cache(function)
    _caches.append(kept)
    found: F = kept
    return found


def trim(robots: int) -> None:
    """Forget all robots where many more are kept than the fleet has."""
    for kept in _caches:
        if kept.cache_info().currsize > 2 * robots + _SPARE:
            kept.cache_clear()

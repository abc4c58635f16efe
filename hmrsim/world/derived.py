"""What follows from a world alone: computed once for each world, and forgotten with it."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from hmrsim.world.model import World

T = TypeVar("T")


class Derived(Generic[T]):
    """A function of a world whose values are kept by the world's identity: to compare worlds takes as long as to read.

    Args:
        function: Its value must not refer to the world, which would never be forgotten.
    """

    def __init__(self, function: Callable[[World], T]) -> None:
        self._function = function
        self._known: dict[int, T] = {}

    def __call__(self, world: World) -> T:
        """Return the value for a world."""
        key = id(world)
        if key not in self._known:
            self._known[key] = self._function(world)
            weakref.finalize(world, self._known.pop, key, None).atexit = False
        return self._known[key]

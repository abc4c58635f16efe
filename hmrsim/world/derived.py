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
        *parts: The fields of a world that alone decide the value; all if left out. A copy with the same parts, such as
            one with other faults, has the value of the world that it was copied from.
    """

    def __init__(self, function: Callable[[World], T], *parts: str) -> None:
        self._function = function
        self._parts = parts
        self._known: dict[tuple[int, ...], T] = {}

    def __call__(self, world: World) -> T:
        """Return the value for a world."""
        key = tuple([id(getattr(world, part)) for part in self._parts]) or (id(world),)
        try:
            return self._known[key]
        except KeyError:
            value = self._known[key] = self._function(world)
            # As long as the world is there, nothing else has the identity of it or of its parts.
            weakref.finalize(world, self._known.pop, key, None).atexit = False
            return value

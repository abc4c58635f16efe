"""A cache of values that depend only on a world, such as its hash."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from hmrsim.world.model import World

T = TypeVar("T")


class Derived(Generic[T]):
    """A function of a world that computes its value once for each world, and drops it with the world.

    Worlds are compared by identity, because comparing their content takes as long as reading them.

    Args:
        function: Computes the value, which must not refer to the world, or else the world would never be freed.
        **parts: The fields of a world that determine the value; all by default. A copy with the same parts, such as
            one with other faults, has the value of the world that it was copied from.
    """

    def __init__(self, function: Callable[[World], T], *parts: str) -> None:
        self._function = function
        self._parts = parts
        self._known: dict[tuple[int, ...], T] = {}

    def __call__(self, world: World) -> T:
        """Return the value for a world."""
        key = tuple(map(id, map(partial(getattr, world), self._parts))) or (id(world),)
        try:
            return self._known[key]
        except KeyError:
            value = self._known[key] = self._function(world)
            # No other object has the identity of the world or of its parts while the world exists. Copies for single
            # runs end soon, and the next one has the same parts.
            owner = world.origin
            if not self._parts or any(getattr(owner, part) is not getattr(world, part) for part in self._parts):
                owner = world
            weakref.finalize(owner, self._known.pop, key, None).atexit = False
            return value

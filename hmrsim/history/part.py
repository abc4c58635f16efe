"""A part of the state of a run."""

from __future__ import annotations

from collections.abc import Callable, Hashable


class Part:
    """A part of the state, such as that of all doors; watchers follow one member of it by name."""

    def __init__(self) -> None:
        self._watchers: dict[Hashable, list[Callable[[], object]]] = {}

    def watch(self, name: Hashable, call: Callable[[], object]) -> None:
        """Call a function after each change of a member."""
        self._watchers.setdefault(name, []).append(call)

    def changed(self, name: Hashable) -> None:
        """Call the watchers of a member."""
        for call in self._watchers.get(name, ()):
            call()

    def begin_anew(self) -> None:
        """Return to the initial state, as after a reset."""
        raise NotImplementedError

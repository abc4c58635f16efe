"""A blackboard per robot: py_trees has one for the whole process."""

from __future__ import annotations

import re
from collections import defaultdict
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, Final

from py_trees.blackboard import Blackboard

if TYPE_CHECKING:
    import uuid

    from py_trees.blackboard import KeyMetaData


GENERATED: Final = re.compile(r"__(?:const|own)|[0-9a-f]{8}([-_]?[0-9a-f]{4}){3}[-_]?[0-9a-f]{12}")
"""A part of the keys that are generated for values in a file and for unconnected ports, here and in py_trees."""


class Entries(dict[str, Any]):
    """The entries of a blackboard.

    Attributes:
        writes: The number of writes of each entry, including unchanged values.
        changes: The number of writes that changed a value.
    """

    def __init__(self) -> None:
        super().__init__()
        self.writes: defaultdict[str, int] = defaultdict(int)
        self.changes = 0

    def __setitem__(self, key: str, value: Any) -> None:
        """Write an entry and count the write."""
        self.writes[key] += 1
        self.changes += key not in self or self[key] != value
        super().__setitem__(key, value)


class Board:
    """The blackboard of one tree.

    It works with any tree: while in use, it replaces py_trees' global blackboard. So trees have to be built, set
    up, ticked and stopped by one thread, one after the other.

    Attributes:
        storage: The entries, as py_trees keeps them; read-only.
        in_use: A context in which py_trees uses this blackboard; it may be entered many times.
    """

    def __init__(self) -> None:
        self.storage = Entries()
        metadata: dict[str, KeyMetaData] = {}
        clients: dict[uuid.UUID, str] = {}
        self.in_use: AbstractContextManager[None] = _InUse(self.storage, metadata, clients)


class _InUse(AbstractContextManager[None]):
    """Puts a blackboard in the place of py_trees' own; for every tick, so no generator."""

    def __init__(self, *parts: dict[Any, Any]) -> None:
        self._parts = parts
        self._others: list[tuple[dict[Any, Any], ...]] = []

    def __enter__(self) -> None:
        self._others.append((Blackboard.storage, Blackboard.metadata, Blackboard.clients))
        Blackboard.storage, Blackboard.metadata, Blackboard.clients = self._parts

    def __exit__(self, *_error: object) -> None:
        Blackboard.storage, Blackboard.metadata, Blackboard.clients = self._others.pop()

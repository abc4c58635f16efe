"""A blackboard for each robot: py_trees has one for the whole process."""

from __future__ import annotations

from collections import Counter
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from py_trees.blackboard import Blackboard

if TYPE_CHECKING:
    import uuid
    from collections.abc import Iterator, Mapping

    from py_trees.blackboard import KeyMetaData


class Entries(dict[str, Any]):
    """What is on a blackboard.

    Attributes:
        writes: How often each entry was written, also with the value that it had.
        changes: How often any was written with another value.
    """

    def __init__(self) -> None:
        super().__init__()
        self.writes: Counter[str] = Counter()
        self.changes = 0

    def __setitem__(self, key: str, value: Any) -> None:
        """Write an entry, and count it."""
        self.writes[key] += 1
        self.changes += key not in self or self[key] != value
        super().__setitem__(key, value)


class Board:
    """The blackboard of one tree.

    Any tree works with it, whatever keys it uses: while it is in use it stands where py_trees looks. So trees
    have to be built, set up, ticked and stopped by one thread, one after the other.
    """

    def __init__(self) -> None:
        self._storage = Entries()
        self._metadata: dict[str, KeyMetaData] = {}
        self._clients: dict[uuid.UUID, str] = {}

    @property
    def changes(self) -> int:
        """How often an entry was written with another value."""
        return self._storage.changes

    @property
    def storage(self) -> Mapping[str, Any]:
        """What is on it, as py_trees keeps it."""
        return self._storage

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Let py_trees use this blackboard."""
        others = Blackboard.storage, Blackboard.metadata, Blackboard.clients
        Blackboard.storage, Blackboard.metadata, Blackboard.clients = (
            self._storage,
            self._metadata,
            self._clients,
        )
        try:
            yield
        finally:
            Blackboard.storage, Blackboard.metadata, Blackboard.clients = others

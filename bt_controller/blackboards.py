"""A blackboard for each robot: py_trees has one for the whole process."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from py_trees.blackboard import Blackboard

if TYPE_CHECKING:
    import uuid
    from collections.abc import Iterator

    from py_trees.blackboard import KeyMetaData


class Board:
    """The blackboard of one tree.

    Any tree works with it, whatever keys it uses: while it is in use it stands where py_trees looks. So trees
    have to be built, set up, ticked and stopped by one thread, one after the other.
    """

    def __init__(self) -> None:
        self._storage: dict[str, Any] = {}
        self._metadata: dict[str, KeyMetaData] = {}
        self._clients: dict[uuid.UUID, str] = {}

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

"""The declarations of the sessions of a process: who receives what is sent on a key."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto
from functools import partial
from typing import TYPE_CHECKING, Any

import zenoh

if TYPE_CHECKING:
    from hmrsim_zenoh.loopback.delivery import Delivery


class Kind(Enum):
    """A kind of declaration of a session."""

    __hash__ = object.__hash__
    """Enum's own is written in Python."""

    SUBSCRIBER = auto()
    QUERYABLE = auto()
    TOKEN = auto()
    TOKEN_SUBSCRIBER = auto()


class Declaration:
    """A declaration on a key expression, in force until `undeclare`.

    Attributes:
        key_expr: The key expression.
        call: Receives the messages.
        owner: The session that declared it.
    """

    def __init__(
        self,
        key_expr: str,
        call: Callable[[Any], object],
        owner: object,
        take_back: Callable[[Declaration], bool],
    ) -> None:
        self.key_expr = zenoh.KeyExpr(key_expr)
        self.call = call
        self.owner = owner
        self._take_back = take_back

    def undeclare(self) -> bool:
        """Withdraw the declaration; return whether it was in force."""
        return self._take_back(self)


class Exchange:
    """The declarations of all sessions of a process.

    Args:
        delivery: Delivers what is sent; its lock guards the declarations.

    Attributes:
        version: Changes with each declaration.
    """

    def __init__(self, delivery: Delivery) -> None:
        self.version = 0
        self._lock = delivery.lock
        self._declared: dict[Kind, list[Declaration]] = {kind: [] for kind in Kind}
        self._matching: dict[tuple[Kind, str], list[Declaration]] = {}

    def declare(self, kind: Kind, key_expr: str, call: Callable[[Any], object], owner: object) -> Declaration:
        """Add a declaration.

        Raises:
            zenoh.ZError: *key_expr* is not a valid key expression.
        """
        declaration = Declaration(key_expr, call, owner, partial(self._take_back, kind))
        with self._lock:
            self._declared[kind].append(declaration)
            self._note_change()
        return declaration

    def matching(self, kind: Kind, key_expr: str) -> list[Declaration]:
        """Return the declarations of a kind whose key expressions intersect with one, in order."""
        with self._lock:
            found = self._matching.get((kind, key_expr))
            if found is None:
                wanted = zenoh.KeyExpr(key_expr)
                found = [each for each in self._declared[kind] if wanted.intersects(each.key_expr)]
                self._matching[kind, key_expr] = found
            return found

    def _take_back(self, kind: Kind, declaration: Declaration) -> bool:
        with self._lock:
            found = declaration in self._declared[kind]
            if found:
                self._declared[kind].remove(declaration)
                self._note_change()
            return found

    def _note_change(self) -> None:
        self.version += 1
        self._matching.clear()

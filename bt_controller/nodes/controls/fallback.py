"""BehaviorTree.CPP's fallbacks: one child has to succeed."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.nodes import Family
from bt_controller.nodes.controls._in_order import InOrder, Reactive


class Fallback(InOrder):
    """Succeeds with the first child that does. Fails when all children have, one after the other.

    A child that runs is ticked again, those before it are not. Skipped children are passed over; if all are
    skipped, so is the fallback.
    """

    passes = Status.FAILURE


class AsyncFallback(Fallback):
    """Is a ``Fallback``: in BehaviorTree.CPP the others have a look between two children, here a tick is an instant."""


class ReactiveFallback(Reactive):
    """Succeeds with the first child that does. Fails when all children have, in one tick.

    At each tick it begins with the first child, so that conditions are looked at again. When a child runs or
    succeeds those after it are halted. Skipped children are passed over; if all are skipped, so is the fallback.
    """

    passes: ClassVar = Status.FAILURE


FAMILY = Family("fallback", {node.__name__: node for node in (Fallback, AsyncFallback, ReactiveFallback)})

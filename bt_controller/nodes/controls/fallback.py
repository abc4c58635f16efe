"""BehaviorTree.CPP's fallbacks: one child has to succeed."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.nodes import Family
from bt_controller.nodes.controls._in_order import InOrder, Reactive


class Fallback(InOrder):
    """Ticks its children in order until one succeeds; fails if all fail.

    A RUNNING child is ticked again, earlier ones are not. Skipped children are ignored; if all are skipped, so is the
    fallback.
    """

    passes = Status.FAILURE


class AsyncFallback(Fallback):
    """Same as ``Fallback``: BehaviorTree.CPP yields between two children, but here a tick takes no time."""


class ReactiveFallback(Reactive):
    """Ticks its children from the first at each tick until one succeeds; fails if all fail in one tick.

    So conditions are evaluated again at each tick. When a child is RUNNING or succeeds, the following ones are halted.
    Skipped children are ignored; if all are skipped, so is the fallback.
    """

    passes: ClassVar = Status.FAILURE


FAMILY = Family.of("fallback", Fallback, AsyncFallback, ReactiveFallback)

"""BehaviorTree.CPP's decorators that change a child's status: Inverter, ForceSuccess, ForceFailure."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Decoration, Ticks
from bt_controller.nodes import Family


class _Changed(Decoration):
    """Ticks its child and maps its status; RUNNING and skipped are unchanged."""

    becomes: ClassVar[Mapping[Status, Status]]

    def advance(self) -> Ticks:
        """Tick the child, and map its status."""
        status = yield from self.tick_child()
        return self.becomes.get(status, status)


class Inverter(_Changed):
    """Succeeds when its child fails, and fails when its child succeeds."""

    becomes = MappingProxyType({Status.SUCCESS: Status.FAILURE, Status.FAILURE: Status.SUCCESS})


class ForceSuccess(_Changed):
    """Succeeds when its child has ended, whatever its status."""

    becomes = MappingProxyType({Status.FAILURE: Status.SUCCESS})


class ForceFailure(_Changed):
    """Fails when its child has ended, whatever its status."""

    becomes = MappingProxyType({Status.SUCCESS: Status.FAILURE})


FAMILY = Family.of("results", Inverter, ForceSuccess, ForceFailure)

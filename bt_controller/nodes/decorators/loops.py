"""BehaviorTree.CPP's LoopInt, LoopBool, LoopDouble and LoopString: a child for each value of a queue."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, PortError, Ticks
from bt_controller.core.ports import BOOL, DOUBLE, INT, STATUS, STRING, Kind, input_port, output_port
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from bt_controller.core.ports import Places


class Loop(Decoration):
    """Removes the values from a queue one by one, and ticks its child with each until the child has ended.

    Fails when the child does; returns *if_empty* when the queue is empty. A queue is a list on the blackboard, from
    which values are removed, or a string of values separated by ``;``, which each start of the node reads again.
    Values that are appended while the child takes no time follow at the next tick.
    """

    kind: ClassVar[Kind[Any]]
    OUTPUTS: ClassVar = {}

    def initialise(self) -> None:
        """Begin with the first value."""
        text = isinstance(self.entry("queue"), str)
        self._own: list[Any] | None = self.read("queue") if text else None

    def next_tick_time(self) -> float:
        """Return that the queue has to be polled, unless the child is RUNNING."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD

    def advance(self) -> Ticks:
        """Tick the child with the current values, until it is RUNNING or fails."""
        turns = len(self._queue()) + (self.child.status is Status.RUNNING)
        for _ in range(turns + 1):
            if self.child.status is not Status.RUNNING:
                queue = self._queue()
                if not queue:
                    empty: Status = self.read("if_empty")
                    return empty
                self.write("value", self._value(queue.pop(0)))
            status = yield from self.tick_child()
            if status in (Status.RUNNING, Status.FAILURE):
                return status
        return Status.RUNNING

    def _queue(self) -> list[Any]:
        """Return the remaining values.

        Raises:
            PortError: The value of the port is not a queue.
        """
        if self._own is not None:
            return self._own
        queue = self.entry("queue")
        if queue is None:
            return []
        if not isinstance(queue, list):
            raise PortError(f"{self._whose('queue')} takes a list, got {type(queue).__name__} {queue!r:.80}")
        return queue

    def _value(self, item: object) -> Any:
        """Return a value of the queue.

        Raises:
            PortError: The value is of another kind.
        """
        try:
            value = self.kind.read(item, None) if isinstance(item, str) else item
        except ValueError as error:
            raise PortError(f"{self._whose('queue')}: {error}") from None
        if not self.kind.holds(value):
            raise PortError(f"{self._whose('queue')} holds {self.kind.name}, got {item!r:.80}")
        return value


def _queue_of(kind: Kind[Any]) -> Kind[Any]:
    """Return the kind of a queue: a list, or a string with the values."""

    def values(text: str, places: Places | None) -> list[Any]:
        return [kind.read(part.strip(), places) for part in text.split(";")] if text.strip() else []

    return Kind("any", object, values)


def _loop(tag: str, kind: Kind[Any]) -> type[Loop]:
    parts = {
        "__doc__": Loop.__doc__,
        "__module__": __name__,
        "kind": kind,
        "INPUTS": {
            "queue": input_port(_queue_of(kind), f"The values: a list of {kind.name}, or a string separated by ';'"),
            "if_empty": input_port(STATUS, "Status when the queue is empty", default=Status.SUCCESS),
        },
        "OUTPUTS": {"value": output_port(kind, "The current value")},
    }
    return type(tag, (Loop,), parts)


_KINDS: Final[Mapping[str, Kind[Any]]] = MappingProxyType(
    {"LoopInt": INT, "LoopBool": BOOL, "LoopDouble": DOUBLE, "LoopString": STRING}
)

FAMILY = Family("loops", {tag: _loop(tag, kind) for tag, kind in _KINDS.items()})

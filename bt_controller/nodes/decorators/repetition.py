"""BehaviorTree.CPP's decorators that tick a child again: a number of times, until it fails, or for each value."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.common import Status

from bt_controller.core.node import EACH_PERIOD, Decoration, PortError, Ticks
from bt_controller.core.ports import BOOL, DOUBLE, INT, STATUS, STRING, Kind, input_port, output_port
from bt_controller.core.sim_time import MAX_TURNS, now
from bt_controller.nodes import Family

if TYPE_CHECKING:
    from bt_controller.core.ports import Places

_FOREVER: Final = -1


class _Again(Decoration):
    """A decorator that may be RUNNING while its child is not.

    A child that was RUNNING and ended at the same instant starts again only after time has advanced: its goals ended at
    once, and would do so again and again at this instant.
    """

    _began = 0.0
    _instant = False

    def initialise(self) -> None:
        """Start over."""
        self._instant = False

    @property
    def rests(self) -> bool:
        """True if the child must not start again before time has advanced."""
        return self._instant and now() == self._began

    def take_turn(self) -> Ticks:
        """Tick the child, and return its status; INVALID if it was skipped."""
        ran = self.child.status is Status.RUNNING
        if not ran:
            self._began = now()
        status = yield from self.tick_child()
        self._instant = ran and status is not Status.RUNNING
        return status

    def next_tick_time(self) -> float:
        """Return that the node needs polling if the child is not RUNNING, as it starts again."""
        return super().next_tick_time() if self.child.status is Status.RUNNING else EACH_PERIOD


class _Counted(_Again):
    """Ticks its child again after one status, as often as a port says; ends with any other status.

    The next repetition follows at once; an endless one of a child that takes no time, at the next tick.
    """

    port: ClassVar[str]
    again: ClassVar[Status]

    def initialise(self) -> None:
        """Start counting the repetitions at zero."""
        super().initialise()
        self._count = 0

    def advance(self) -> Ticks:
        """Tick the child until it is RUNNING or the repetitions are over."""
        for _ in range(MAX_TURNS):
            limit = self.read(self.port)
            if self._count >= limit != _FOREVER:
                return self.again
            if self.rests:
                break
            ran = self.child.status is Status.RUNNING
            status = yield from self.take_turn()
            if status is not self.again:
                return status
            self._count += 1
            if limit == _FOREVER and not ran:
                break
        return Status.RUNNING


class Repeat(_Counted):
    """Ticks its child until it has succeeded *num_cycles* times; fails when the child does.

    Repetitions follow each other at once. After one that took no time the next follows a period later if the child was
    RUNNING, and at the next tick if the number is unlimited (-1) or after a thousand. If the child is skipped, so is
    the node.
    """

    INPUTS: ClassVar = {"num_cycles": input_port(INT, "Number of successes; -1 for unlimited")}
    port = "num_cycles"
    again = Status.SUCCESS


class RetryUntilSuccessful(_Counted):
    """Ticks its child until it succeeds; fails when the child has failed *num_attempts* times.

    Repetitions follow each other at once. After one that took no time the next follows a period later if the child was
    RUNNING, and at the next tick if the number is unlimited (-1) or after a thousand. If the child is skipped, so is
    the node.
    """

    INPUTS: ClassVar = {"num_attempts": input_port(INT, "Number of attempts; -1 for unlimited")}
    port = "num_attempts"
    again = Status.FAILURE


class KeepRunningUntilFailure(_Again):
    """Runs until its child fails, and then fails; a child that has ended otherwise starts again at the next tick."""

    def advance(self) -> Ticks:
        """Tick the child, unless it rests at this instant."""
        if self.rests:
            return Status.RUNNING
        status = yield from self.take_turn()
        return Status.FAILURE if status is Status.FAILURE else Status.RUNNING


class _Loop(Decoration):
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


def _loop(tag: str, kind: Kind[Any]) -> type[_Loop]:
    parts = {
        "__doc__": _Loop.__doc__,
        "__module__": __name__,
        "kind": kind,
        "INPUTS": {
            "queue": input_port(_queue_of(kind), f"The values: a list of {kind.name}, or a string separated by ';'"),
            "if_empty": input_port(STATUS, "Status when the queue is empty", default=Status.SUCCESS),
        },
        "OUTPUTS": {"value": output_port(kind, "The current value")},
    }
    return type(tag, (_Loop,), parts)


_KINDS: Final[Mapping[str, Kind[Any]]] = MappingProxyType(
    {"LoopInt": INT, "LoopBool": BOOL, "LoopDouble": DOUBLE, "LoopString": STRING}
)


FAMILY = Family.of_module(__name__, *map(_loop, _KINDS, _KINDS.values()))

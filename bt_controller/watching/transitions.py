"""A log of the behaviors' statuses with simulated times: one line for each change.

What runs and is reset within one tick is in it, too: the log listens to each behavior's ``tick`` and ``stop``.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, Protocol

from py_trees.common import Status

from bt_controller.core.tree_paths import paths

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.running.mission import Mission

_log = logging.getLogger(__name__)


class Writer(Protocol):
    """Takes text: whole lines."""

    def write(self, text: str, /) -> object:
        """Take some."""


class Transitions:
    """Logs the transitions of trees as lines of JSON, and as log messages.

    Args:
        out: Takes the lines of JSON; None for none.
        missions: The trees, before their first tick.
    """

    def __init__(self, out: Writer | None, missions: Iterable[Mission]) -> None:
        self._out = out
        # Of the tree that is being ticked: only the runner knows the time of the tick.
        self._noted: list[dict[str, Any]] = []
        for mission in missions:
            for node, path in paths(mission.root):
                self._listen(mission.robot, node, path)

    @staticmethod
    def wanted() -> bool:
        """Return whether log messages of transitions are enabled."""
        return _log.isEnabledFor(logging.INFO)

    def ticked(self, _mission: Mission, now: float | None) -> None:
        """Log the transitions of a tick."""
        self.flush(now)

    def flush(self, now: float | None) -> None:
        """Log the pending transitions at this time."""
        noted, self._noted = self._noted, []
        if noted and self._out is not None:
            self._out.write("".join(json.dumps({"sim_time": now, **line}) + "\n" for line in noted))
        for line in noted:
            self._tell(now, **line)

    @staticmethod
    def _tell(now: float | None, **line: str) -> None:
        when = "" if now is None else f"{now:.3f} "
        why = f": {line['message']}" if line["message"] else ""
        _log.info("%s%s: %s: %s -> %s%s", when, line["robot"], line["node"], line["from"], line["to"], why)

    def _listen(self, robot: str, node: Behaviour, path: str) -> None:
        last = node.status
        tick: Callable[[], Iterator[Behaviour]] = node.tick
        stop: Callable[[Status], None] = node.stop

        def note() -> None:
            nonlocal last
            if node.status is not last:
                # py_trees leaves the last message on a behavior that it has reset.
                message = "" if node.status is Status.INVALID else node.feedback_message
                change = {"from": last.value, "to": node.status.value, "message": message}
                self._noted.append({"robot": robot, "node": path, **change})
                last = node.status

        def ticked() -> Iterator[Behaviour]:
            for each in tick():
                if each is node:
                    note()
                yield each

        def stopped(new_status: Status = Status.INVALID) -> None:
            stop(new_status)
            note()

        node.tick = ticked  # type: ignore[method-assign]
        node.stop = stopped  # type: ignore[method-assign]

"""Displays of running trees: plain lines, JSON for programs, and a log of the changes of statuses.

`live_display` is the display for terminals.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import IO, TYPE_CHECKING, Any, ClassVar, Final, Protocol

from py_trees.common import Status

from bt_controller.core.subtrees import paths
from bt_controller.running.snapshot import ASCII, UNICODE, Snapshot

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.running.mission import Mission

_UTF_8: Final = "utf-8"


class Watcher(Protocol):
    """A display of ticks of trees."""

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Process a tick of a tree at a simulated time."""


class _Display:
    """Writes a tree whenever it has changed.

    Attributes:
        blackboard: Whether it is also written when only its blackboard has changed.
    """

    blackboard: ClassVar = False

    def __init__(self, out: IO[str]) -> None:
        self._out = out
        self._shown: dict[str, Snapshot] = {}

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Show the tree."""
        self.show(mission.snapshot(now, blackboard=self.blackboard))

    def show(self, snapshot: Snapshot) -> None:
        """Write the tree, if it has changed."""
        if snapshot.differs(self._shown.get(snapshot.robot)):
            self._shown[snapshot.robot] = snapshot
            self._out.write(self._text(snapshot))
            self._out.flush()

    def _text(self, snapshot: Snapshot) -> str:
        raise NotImplementedError


class PlainDisplay(_Display):
    """Writes a tree as text."""

    def _text(self, snapshot: Snapshot) -> str:
        symbols, encoding = symbols_for(self._out), getattr(self._out, "encoding", None) or _UTF_8
        lines = [snapshot.title, *(node.line(symbols) for node in snapshot.nodes), "", ""]
        return "\n".join(lines).encode(encoding, "replace").decode(encoding)


class JsonDisplay(_Display):
    """Writes a tree and its blackboard as one line of JSON."""

    blackboard = True

    def _text(self, snapshot: Snapshot) -> str:
        return json.dumps(snapshot.to_json()) + "\n"


def symbols_for(out: IO[str]) -> Mapping[Status, str]:
    """Return the symbols that a stream can encode."""
    try:
        "".join(UNICODE.values()).encode(getattr(out, "encoding", None) or _UTF_8)
    except UnicodeError:
        return ASCII
    return UNICODE


_log = logging.getLogger(__name__)


class Writer(Protocol):
    """An output that takes whole lines of text."""

    def write(self, text: str, /) -> object:
        """Write a text of whole lines."""


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

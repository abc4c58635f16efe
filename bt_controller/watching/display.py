"""Displays of running trees: plain lines, and JSON for programs. `live_display` is the one for terminals."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import IO, TYPE_CHECKING, Final, Protocol

from bt_controller.running.snapshot import ASCII, UNICODE, Snapshot

if TYPE_CHECKING:
    from py_trees.common import Status

    from bt_controller.running.mission import Mission

_UTF_8: Final = "utf-8"


class Watcher(Protocol):
    """A display of ticks."""

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Process a tick of a tree at a simulated time."""


class PlainDisplay:
    """Writes a tree as text whenever it has changed."""

    def __init__(self, out: IO[str]) -> None:
        self._out = out
        self._symbols = symbols_for(out)
        self._encoding = getattr(out, "encoding", None) or _UTF_8
        self._shown: dict[str, Snapshot] = {}

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Show the tree."""
        self.show(mission.snapshot(now))

    def show(self, snapshot: Snapshot) -> None:
        """Write the tree, if it has changed."""
        if snapshot.differs(self._shown.get(snapshot.robot)):
            self._shown[snapshot.robot] = snapshot
            lines = [snapshot.title, *(node.line(self._symbols) for node in snapshot.nodes), ""]
            text = "\n".join(lines) + "\n"
            self._out.write(text.encode(self._encoding, "replace").decode(self._encoding))
            self._out.flush()


class JsonDisplay:
    """Writes a tree as one line of JSON whenever the tree or its blackboard has changed."""

    def __init__(self, out: IO[str]) -> None:
        self._out = out
        self._shown: dict[str, Snapshot] = {}

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Show the tree."""
        self.show(mission.snapshot(now, blackboard=True))

    def show(self, snapshot: Snapshot) -> None:
        """Write the tree, if it has changed."""
        if snapshot.differs(self._shown.get(snapshot.robot)):
            self._shown[snapshot.robot] = snapshot
            self._out.write(json.dumps(snapshot.to_json()) + "\n")
            self._out.flush()


def symbols_for(out: IO[str]) -> Mapping[Status, str]:
    """Return the symbols that a stream can encode."""
    try:
        "".join(UNICODE.values()).encode(getattr(out, "encoding", None) or _UTF_8)
    except UnicodeError:
        return ASCII
    return UNICODE

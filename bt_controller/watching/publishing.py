"""The publisher of trees: publishes changes of their state to subscribers, and answers queries."""

from __future__ import annotations

import json
import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, Self

import zenoh

if TYPE_CHECKING:
    from bt_controller.running.mission import Mission
    from bt_controller.running.snapshot import Snapshot
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_JSON: Final = "application/json"


class Publisher:
    """Publishes the trees of some robots until it is closed.

    One wildcard declaration serves all robots, since one per robot would be slow in large fleets. A subscriber to one
    tree thus makes the controller publish every tree that changes.

    Args:
        session: An open session, which the caller closes.
    """

    def __init__(self, session: zenoh.Session, keys: Keys, missions: Sequence[Mission]) -> None:
        self._session = session
        self._keys = keys
        self._missions = {keys.tree(mission.robot): mission for mission in missions}
        self._times: dict[str, float | None] = {}
        self._published: dict[str, Snapshot] = {}
        self._publisher = session.declare_publisher(keys.trees())
        # Other controllers may serve trees of other robots: Zenoh queries all that match.
        self._declared: list[Any] = [
            self._publisher,
            session.declare_queryable(keys.trees(), self._answer, complete=False),
            session.declare_queryable(keys.history_of(keys.trees()), self._answer, complete=False),
        ]
        # zenoh-python raises RuntimeError when a publisher is undeclared while another thread reads its matching
        # status: only the caller's thread reads it, at the next tick.
        self._matching_changed = True
        self._wanted = False
        self._publisher.declare_matching_listener(zenoh.handlers.Callback(self._mark_changed))

    def __enter__(self) -> Self:
        """Return the publisher."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close the publisher."""
        self.close()

    def ticked(self, mission: Mission, now: float | None) -> None:
        """Publish the mission's tree, if it has changed and there are subscribers."""
        self._times[mission.robot] = now
        if self._has_subscribers():
            self._publish(mission)

    def close(self) -> None:
        """Publish the end of all trees, and nothing afterwards."""
        if self._declared and self._has_subscribers():
            for mission in self._missions.values():
                self._publish(mission)
        while self._declared:
            self._declared.pop().undeclare()

    def _mark_changed(self, _status: zenoh.MatchingStatus | None = None) -> None:
        """Make the next tick check for subscribers; thread-safe."""
        self._matching_changed = True

    def _has_subscribers(self) -> bool:
        if self._matching_changed:
            self._matching_changed = False
            self._wanted = self._publisher.matching_status.matching  # type: ignore[attr-defined]  # the stub errs
        return self._wanted

    def _publish(self, mission: Mission) -> None:
        snapshot = self._snapshot(mission)
        if not snapshot.differs(self._published.get(mission.robot)):
            return
        self._published[mission.robot] = snapshot
        # A slow subscriber must not delay a tree, but every subscriber has to receive its end.
        control = zenoh.CongestionControl.BLOCK if snapshot.ended else zenoh.CongestionControl.DROP
        key = self._keys.tree(mission.robot)
        self._session.put(key, _payload(snapshot), encoding=_JSON, congestion_control=control)

    def _answer(self, query: zenoh.Query) -> None:
        """Answer a query with the current trees; called in a thread of Zenoh."""
        # A client that subscribes and then queries has to receive all changes after the answer.
        self._mark_changed()
        try:
            pattern = self._keys.without_history(str(query.key_expr))
            for key in self._matching_keys(pattern):
                query.reply(key, _payload(self._snapshot(self._missions[key])), encoding=_JSON)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", query.key_expr, error)
        finally:
            query.drop()

    def _matching_keys(self, pattern: str) -> list[str]:
        if "*" not in pattern and "$" not in pattern:
            return [pattern] if pattern in self._missions else []
        expression = zenoh.KeyExpr(pattern)
        return [key for key in self._missions if expression.intersects(zenoh.KeyExpr(key))]

    def _snapshot(self, mission: Mission) -> Snapshot:
        return mission.snapshot(self._times.get(mission.robot), blackboard=True)


def _payload(snapshot: Snapshot) -> bytes:
    return json.dumps(snapshot.to_json()).encode()

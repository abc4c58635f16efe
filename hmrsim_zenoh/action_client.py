"""Sending one robot goals of one action."""

from __future__ import annotations

import logging
import threading
import uuid
from typing import TYPE_CHECKING, Generic

from hmrsim.actions import F, G, R
from hmrsim.goal import parse_goal_id
from hmrsim_zenoh.envelopes import FeedbackMessage, UnreadableError, around, read
from hmrsim_zenoh.goal_exchange import ActionPorts, GoalExchange
from hmrsim_zenoh.keys import Verb

if TYPE_CHECKING:
    from collections.abc import Callable

    import zenoh

    from hmrsim.actions import Action
    from hmrsim_zenoh.goal_handle import GoalHandle
    from hmrsim_zenoh.link import Link

_log = logging.getLogger(__name__)


class ActionClient(Generic[G, R, F]):
    """Sends one robot goals of one action; `Client.action_client` makes it.

    Attributes:
        robot: The robot's name.
        action: The action.
    """

    def __init__(self, link: Link, robot: str, action: Action[G, R, F]) -> None:
        self.robot = robot
        self.action = action
        self._link = link
        self._ports = ActionPorts.of(link.keys, robot, action)
        self._lock = threading.Lock()
        self._listening: dict[str, GoalExchange[R, F]] = {}
        self._subscribed = False

    def send_goal(
        self,
        goal: G,
        *,
        goal_id: str | None = None,
        on_feedback: Callable[[F], None] | None = None,
        on_change: Callable[[GoalHandle[R, F]], None] | None = None,
    ) -> GoalHandle[R, F]:
        """Send a goal and return its ticket; never waits.

        Args:
            goal: What to do.
            goal_id: 32 hex digits, hyphens optional; made here if not given.
            on_feedback: Called for each feedback, never after the goal is done.
            on_change: Called whenever *accepted*, *status*, *error* or *done* have changed.

        Callbacks may come before this returns, are mostly in Zenoh's thread, and must not wait.

        Raises:
            ClientClosed: The client was closed.
            ValueError: *goal_id* is no goal id.
            TypeError: *goal* is of another action.
        """
        if not isinstance(goal, self.action.goal):
            raise TypeError(f"{self.action.name} takes {self.action.goal.ros_type}, got {goal!r}")
        exchange = GoalExchange[R, F](
            self._link,
            self._ports,
            goal,
            uuid.uuid4().hex if goal_id is None else parse_goal_id(goal_id),
            on_feedback=on_feedback,
            on_change=on_change,
            on_done=self._forget,
        )
        self._link.enter(exchange)
        if on_feedback is not None:
            self._listen(exchange)
        exchange.start()
        return exchange

    def _forget(self, exchange: GoalExchange[R, F]) -> None:
        self._link.leave(exchange)
        self._listening.pop(exchange.goal_id, None)

    def _listen(self, exchange: GoalExchange[R, F]) -> None:
        self._listening[exchange.goal_id] = exchange
        with self._lock:
            if not self._subscribed:
                key = self._link.keys.action(self.robot, self.action.name, Verb.FEEDBACK)
                self._link.subscribe(key, self._on_feedback)
                self._subscribed = True

    def _on_feedback(self, sample: zenoh.Sample) -> None:
        if not self._listening:
            return
        try:
            message: FeedbackMessage[F] = read(around(FeedbackMessage, self.action.feedback), sample.payload.to_bytes())
        except UnreadableError as error:
            _log.warning("%s: feedback that can't be read: %s", sample.key_expr, error)
            return
        if exchange := self._listening.get(message.goal_id):
            exchange.take_feedback(message.feedback)

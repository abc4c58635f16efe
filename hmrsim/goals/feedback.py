"""The feedback of executing goals, which is sampled at a rate while there is a subscriber."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from hmrsim.engine.internal_errors import BUGS
from hmrsim.protocol.outputs import FeedbackSent
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.engine.environment import Environment
    from hmrsim.engine.internal_errors import InternalErrors
    from hmrsim.engine.subscriptions import EventPublisher, Telemetry
    from hmrsim.goals.fault_effects import DisconnectedRobots
    from hmrsim.goals.servers import ActionServers, ServedGoal
    from hmrsim.interfaces.message import Message


class Feedback:
    """Publishes the feedback of executing goals.

    Args:
        env: The clock of the simulation.
        servers: The action servers, with their goals.
        cut_off: The robots that clients can't reach.
        telemetry: Samples topics at a rate.
        publisher: Publishes feedback, and knows whether there is a subscriber.
        errors: Handles errors of actions while they compute feedback.
        rate: Samples per second of simulated time.
    """

    def __init__(
        self,
        env: Environment,
        servers: ActionServers,
        cut_off: DisconnectedRobots,
        telemetry: Telemetry,
        *,
        publisher: EventPublisher,
        errors: InternalErrors,
        rate: float,
    ) -> None:
        self._env = env
        self._servers = servers
        self._cut_off = cut_off
        self._telemetry = telemetry
        self._emit = publisher.emit
        self._interest = publisher.interest
        self._errors = errors
        self._rate = rate
        self._ever_sampled = False

    def send(self, goal: ServedGoal, feedback: Message | Mapping[str, Any], *, last: bool = False) -> None:
        """Publish the feedback of an executing goal, if there is a subscriber."""
        if not goal.status.terminal and self._interest.feedback:
            server = goal.server
            self._emit(FeedbackSent(server.robot.name, server.action.name, goal.goal_id, feedback, last))

    def sample(self, goal: ServedGoal, source: Callable[[], Message | Mapping[str, Any]]) -> None:
        """Publish the feedback that *source* returns, at the rate and once more when the goal ends.

        Do nothing if the goal has ended: one that is canceled at the instant of its acceptance ends before it begins.
        """
        if goal.status.terminal:
            return
        goal.sample, goal.sampled_from = source, self._env.now
        if self._interest.feedback:
            self._start(goal)

    def finish(self, goal: ServedGoal) -> None:
        """Publish the last feedback of a goal just before it ends."""
        if goal.sample is not None:
            if not self._ever_sampled:
                goal.sample = None
                return
            feedback = self._current_of(goal) if self._interest.feedback else None
            self.stop(goal)
            if feedback is not None:
                self.send(goal, feedback, last=True)

    def stop(self, goal: ServedGoal) -> None:
        """Stop the feedback of a goal."""
        goal.sample = None
        self._telemetry.stop(goal)

    def current(self) -> list[FeedbackSent]:
        """Return the current feedback of all executing goals."""
        return [
            FeedbackSent(goal.server.robot.name, goal.server.action.name, goal.goal_id, feedback)
            for goal in self._servers.active()
            if goal.server.robot.name not in self._cut_off and (feedback := self._current_of(goal)) is not None
        ]

    def interest_changed(self) -> None:
        """Start sampling the executing goals if there is a subscriber now."""
        if self._interest.feedback:
            for goal in self._servers.active():
                if goal.sample is not None and goal not in self._telemetry:
                    self._start(goal)

    def _start(self, goal: ServedGoal) -> None:
        def publish_sample() -> None:
            feedback = self._current_of(goal)
            if feedback is not None:
                self.send(goal, feedback)

        self._ever_sampled = True
        self._telemetry.start(goal, Topic.FEEDBACK, goal.sampled_from, self._rate, publish_sample, now=self._env.now)

    def _current_of(self, goal: ServedGoal) -> Message | Mapping[str, Any] | None:
        """Return the current feedback of a goal; None if it has none, or if its action raised an error.

        The goal continues after an error, since a subscriber must not change what happens in the simulation.
        """
        if goal.sample is None:
            return None
        try:
            return goal.sample()
        except BUGS as bug:
            self.stop(goal)
            server = goal.server
            self._errors.handle(f"action {server.action.name}", bug, server.robot.name, replayed=False)
            return None

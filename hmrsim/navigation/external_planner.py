"""Paths from an external planner: an event requests a path, and a command answers it."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import TYPE_CHECKING, Any

from hmrsim.events.simulation import PlannerChanged, PlanRequested
from hmrsim.protocol.outputs import PlanWanted

if TYPE_CHECKING:
    import simpy

    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.interfaces.nav2_msgs import ComputePathToPose
    from hmrsim.protocol.commands import PlanAnswered
    from hmrsim.protocol.outputs import Output


class Plans:
    """The requests to an external planner that have no answer yet.

    Attributes:
        awaited: The events of the requests that have not been answered, by number, in order.
        present: Whether one has announced itself.
    """

    def __init__(self, env: simpy.Environment, emit: Callable[[Output], None], publisher: EventPublisher) -> None:
        self._env = env
        self._emit = emit
        self._publisher = publisher
        self._asked = 0
        self.awaited: dict[int, simpy.Event] = {}
        self._kept: dict[int, PlanAnswered] = {}
        self.present = False

    def ask(self, robot: str, goal: ComputePathToPose.Goal) -> Generator[Any, Any, ComputePathToPose.Result]:
        """Ask for a path and wait for it; an interrupt forgets the request."""
        self._asked += 1
        number = self._asked
        answered = self.awaited[number] = self._env.event()
        self._publisher.publish(lambda: PlanRequested(robot, number))
        self._emit(PlanWanted(number, robot, goal))
        try:
            result: ComputePathToPose.Result = yield answered
        finally:
            self.awaited.pop(number, None)
        return result

    def answer(self, command: PlanAnswered) -> None:
        """Resume the goal that waits for a path; an answer without a waiting goal is dropped."""
        answered = self.awaited.pop(command.request, None)
        if answered is not None:
            answered.succeed(command.result)

    def keep(self, command: PlanAnswered) -> None:
        """Keep an answer for later; an answer without a waiting goal is dropped."""
        if command.request in self.awaited:
            self._kept[command.request] = command

    @property
    def all_kept(self) -> bool:
        """Return whether each request has a stored answer."""
        return self.awaited.keys() <= self._kept.keys()

    def take_kept(self) -> list[PlanAnswered]:
        """Return the answers that were kept, in the order of their requests, and forget them."""
        kept, self._kept = self._kept, {}
        return [kept[request] for request in sorted(kept)]

    def announce(self, *, present: bool) -> None:
        """Record that an external planner has appeared or left."""
        if present != self.present:
            self.present = present
            self._publisher.publish(lambda: PlannerChanged(present))

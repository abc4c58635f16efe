"""The scripts of a world file: goals that robots execute one after the other, without a controller.

A script gives its robot one goal after the other, each when the one before has succeeded. It ends with the first
goal that does not: also when a controller on the network takes the robot over.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

from hmrsim.actions import error_of
from hmrsim.diagnostics import shown
from hmrsim.events.robots import ScriptEnded
from hmrsim.goals.script_orders import Order, read_order
from hmrsim.protocol.commands import GetResult, SendGoal
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    import simpy

    from hmrsim.engine.subscriptions import EventPublisher
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.goal import GoalResponse, ResultResponse
    from hmrsim.world.model import World


class ScriptState(Enum):
    """The progress of a script."""

    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"


@dataclass
class Script:
    """The script of one robot, and its progress.

    Attributes:
        done: How many orders have succeeded.
        error: Why it failed; empty if it did not.
        ended: When it ended, in simulated seconds; None while it runs.
    """

    robot: str
    orders: Sequence[Order]
    done: int = 0
    state: ScriptState = ScriptState.RUNNING
    error: str = ""
    ended: float | None = None

    def event(self) -> ScriptEnded:
        """Return the event that reports the end of the script."""
        return ScriptEnded(self.robot, len(self.orders), self.done, self.state.value, self.error)


class Scripts:
    """Runs all scripts of a world.

    Args:
        env: The simulation's clock and events; the scripts begin at its first instant.
        world: Its robots' scripts must have been checked.

    Attributes:
        all: By robot, in the order of names: that of the file must not matter.
    """

    def __init__(
        self,
        env: simpy.Environment,
        world: World,
        *,
        submit: Callable[[Command], None],
        publisher: EventPublisher,
    ) -> None:
        self._env = env
        self._submit = submit
        self._ended = False
        self._publisher = publisher
        self.all = {
            name: Script(name, [read_order(text, world) for text in robot.script])
            for name, robot in sorted(world.robots.items())
            if robot.script
        }
        for script in self.all.values():
            env.process(self._run(script))

    def end(self) -> None:
        """Stop all scripts, including those that wait for an answer."""
        self._ended = True

    @property
    def running(self) -> bool:
        """Return whether any script is still running."""
        return any(script.state is ScriptState.RUNNING for script in self.all.values())

    def _run(self, script: Script) -> Generator[Any, Any, None]:
        for order in script.orders:
            script.error = yield from self._carry_out(script.robot, order)
            if self._ended:
                return
            if script.error:
                break
            script.done += 1
        script.state = ScriptState.FAILED if script.error else ScriptState.DONE
        script.ended = self._env.now
        self._publisher.publish(script.event)

    def _carry_out(self, robot: str, order: Order) -> Generator[Any, Any, str]:
        """Make a robot execute a step; return why it did not, or ""."""
        accepted, ended = self._env.event(), self._env.event()
        self._submit(SendGoal(robot, order.action.name, order.goal, reply_to=accepted))
        response: GoalResponse = yield accepted
        if not response.accepted:
            return f"{shown(order.text)} was rejected: {response.error_msg}"
        self._submit(GetResult(robot, order.action.name, response.goal_id, reply_to=ended))
        end: ResultResponse = yield ended
        if end.status is GoalStatus.SUCCEEDED:
            return ""
        why = error_of(end.result)
        return f"{shown(order.text)} ended {end.status.name}{f': {why}' if why else ''}"

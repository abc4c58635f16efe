"""From commands to running actions and back: accept or reject, preempt, cancel, keep results.

Every accepted goal gets exactly one terminal status, also when the simulation stops or an action has a bug.
All that waits for a goal waits here, in the simulation's thread.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from simpy import Interrupt

from hmrsim.errors import GoalAborted, GoalRejected
from hmrsim.gateway import (
    Answered,
    CancelGoal,
    CancelResponse,
    FeedbackSent,
    GetResult,
    GoalChanged,
    GoalEntry,
    GoalResponse,
    Refused,
    ResultResponse,
    SendGoal,
    StatusChanged,
    Topic,
)
from hmrsim.goal import ZERO_ID, GoalEvent, GoalStatus, next_status, parse_goal_id
from hmrsim.interfaces.action_msgs import CancelGoal as CancelGoalService
from hmrsim.sim_time import stamp

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterator, Mapping

    import simpy

    from hmrsim.actions import AnyAction
    from hmrsim.gateway import Event
    from hmrsim.interest import Interest
    from hmrsim.interfaces.message import Message
    from hmrsim.robot import Robot
    from hmrsim.telemetry import Telemetry

_FRAMES = ("", "map")
_CANCEL = CancelGoalService.Response


@dataclass(eq=False, slots=True)
class _Goal:
    """An accepted goal; many are kept after their end, so that they hold no more than is asked for."""

    server: _Server
    goal_id: str
    stamp: int
    from_client: bool
    status: GoalStatus = GoalStatus.ACCEPTED
    result: Message | None = None
    process: simpy.Process | None = None
    waiting: list[Any] = field(default_factory=list)
    sample: Callable[[], Message | Mapping[str, Any]] | None = None
    sampled_from: float = 0.0
    failure: Callable[[int, str], Message] | None = None

    def failed(self, code: int, message: str) -> Message:
        """Return the result of a goal that did not succeed."""
        made: Message = (self.failure or self.server.action.failure)(code, message)
        return made

    def entry(self) -> GoalEntry:
        return GoalEntry(self.goal_id, self.stamp, self.status)


@dataclass(eq=False, slots=True)
class _Server:
    """One action of one robot, and its goals in order of acceptance."""

    robot: Robot
    action: AnyAction
    goals: dict[str, _Goal] = field(default_factory=dict)
    forgotten: dict[str, GoalStatus] = field(default_factory=dict)
    made: int = 0


class _Report:
    """What a running action tells about its goal."""

    def __init__(self, dispatcher: Dispatcher, goal: _Goal) -> None:
        self._dispatcher = dispatcher
        self._goal = goal

    def send(self, feedback: Message | Mapping[str, Any]) -> None:
        self._dispatcher.send_feedback(self._goal, feedback, last=True)

    def sample(self, source: Callable[[], Message | Mapping[str, Any]]) -> None:
        self._dispatcher.sample_feedback(self._goal, source)

    def on_failure(self, make: Callable[[int, str], Message]) -> None:
        self._goal.failure = make


class Dispatcher:
    """Serves the actions of all robots.

    Args:
        env: The simulation's clock and events.
        actions: All actions, by name.
        telemetry: Takes feedback samples.
        emit: Where events go.
        interest: Who listens to what.
        seed: From which the ids of goals that have none are made.
        keep_results: Most ended goals that a robot remembers.
        feedback_rate: Samples of feedback a second of simulated time.
    """

    def __init__(
        self,
        env: simpy.Environment,
        actions: Mapping[str, AnyAction],
        telemetry: Telemetry,
        *,
        emit: Callable[[Event], None],
        interest: Interest,
        seed: int = 0,
        keep_results: int = 1000,
        feedback_rate: float = 10.0,
    ) -> None:
        self._env = env
        self._actions = actions
        self._telemetry = telemetry
        self._emit = emit
        self._interest = interest
        self._seed = seed
        self._keep_results = keep_results
        self._feedback_rate = feedback_rate
        self._instant, self._instant_stamp = -1.0, 0
        self._robots: dict[str, Robot] = {}
        self._offered: dict[tuple[str, ...], dict[str, AnyAction]] = {}
        self._servers: dict[tuple[str, str], _Server] = {}
        self._holders: dict[str, _Goal] = {}
        self._ended: dict[str, dict[_Goal, None]] = {}

    def add(self, robot: Robot) -> None:
        """Serve a robot: all actions that its components allow."""
        self._robots[robot.name] = robot

    def actions_of(self, robot: str) -> list[str]:
        """Return the names of the actions that a robot serves."""
        return list(self._offers(self._robots[robot]))

    def _offers(self, robot: Robot) -> dict[str, AnyAction]:
        """Return the actions that a robot serves; one table for all robots with the same components."""
        carried = tuple(robot.components)
        if carried not in self._offered:
            self._offered[carried] = {
                name: action
                for name, action in self._actions.items()
                if action.component is None or action.component in carried
            }
        return self._offered[carried]

    def goal_of(self, robot: str) -> tuple[str, str] | None:
        """Return action and id of the goal that holds a robot's base; None when none does."""
        goal = self._holders.get(robot)
        return (goal.server.action.name, goal.goal_id) if goal else None

    # --- sending --------------------------------------------------------------------------------------------------

    def send_goal(self, command: SendGoal) -> None:
        """Accept or reject a goal, and answer; an accepted one begins at this instant."""
        try:
            server = self._server(command.robot, command.action)
            goal_id = self._goal_id(server, command.goal_id)
            known = server.goals.get(goal_id)
            if known or goal_id in server.forgotten:
                self._answer_duplicate(command, goal_id, known, server)
                return
            message = self._acceptable(server, command)
        except GoalRejected as rejection:
            action = self._actions.get(command.action)
            answer = GoalResponse(
                accepted=False,
                goal_id=_as_answered(command.goal_id),
                stamp=self._stamp(),
                reason=rejection.reason,
                error_code=action.codes.rejected if action else 1,
                error_msg=str(rejection),
            )
            self._answer(command.reply_to, answer)
            return
        goal = _Goal(server, goal_id, self._stamp(), from_client=command.goal_id is not None)
        self._answer(command.reply_to, GoalResponse(True, goal_id, goal.stamp))
        self._start(goal, message)

    def _server(self, robot: str, action: str) -> _Server:
        """Return who serves an action; made when it is first asked for, as most are never.

        Raises:
            GoalRejected: There is no such robot or action.
        """
        server = self._servers.get((robot, action))
        if server is not None:
            return server
        if robot not in self._robots:
            there = ", ".join(self._robots) or "none"
            raise GoalRejected("unknown_robot", f"no robot {robot!r}; there are: {there}")
        offers = self._offers(self._robots[robot])
        if action not in offers:
            raise GoalRejected("unknown_action", f"{robot} has no action {action!r}; it has: {', '.join(offers)}")
        server = self._servers[robot, action] = _Server(self._robots[robot], offers[action])
        return server

    def _goal_id(self, server: _Server, text: str | None) -> str:
        """Return the id in its canonical form; one made from the seed where there is none."""
        if text is None:
            server.made += 1
            name = f"{self._seed}/{server.robot.name}/{server.action.name}/{server.made}"
            return hashlib.blake2b(name.encode(), digest_size=16).hexdigest()
        try:
            goal_id = parse_goal_id(text)
        except ValueError as error:
            raise GoalRejected("invalid_goal_id", str(error)) from None
        if goal_id == ZERO_ID:
            raise GoalRejected("invalid_goal_id", "the goal id is zero, which stands for all goals; make another")
        return goal_id

    def _answer_duplicate(self, command: SendGoal, goal_id: str, known: _Goal | None, server: _Server) -> None:
        status = known.status if known else server.forgotten[goal_id]
        answer = GoalResponse(
            accepted=False,
            goal_id=goal_id,
            stamp=known.stamp if known else self._stamp(),
            reason="duplicate_goal_id",
            error_code=server.action.codes.rejected,
            error_msg=f"goal {goal_id} was sent before and is {status.name}",
            status=status,
        )
        self._answer(command.reply_to, answer)

    def _acceptable(self, server: _Server, command: SendGoal) -> Message:
        action = server.action
        if not isinstance(command.goal, action.goal):
            raise GoalRejected("invalid_goal", f"{command.goal!r} is no {action.goal.ros_type}")
        for frame in action.frames(command.goal):
            if frame not in _FRAMES:
                raise GoalRejected("invalid_goal", f"unknown frame_id {frame!r}; use 'map' or leave it empty")
        flaw = action.flaw(command.goal)
        if flaw:
            raise GoalRejected("invalid_goal", flaw)
        reason = action.not_ready(server.robot)
        if reason:
            raise GoalRejected("not_ready", reason)
        goal: Message = command.goal
        return goal

    # --- running --------------------------------------------------------------------------------------------------

    def _start(self, goal: _Goal, message: Message) -> None:
        """Let an accepted goal run; it takes the base from another goal, or finds it busy."""
        action, name = goal.server.action, goal.server.robot.name
        holder = self._holders.get(name) if action.holds_base else None
        if holder is not None and action.codes.busy is None:
            # Before the new one is published: nobody ever sees two that execute on one base.
            code = holder.server.action.codes.preempted
            self._halt(holder, GoalEvent.ABORT, code, f"preempted by goal {goal.goal_id}")
        goal.server.goals[goal.goal_id] = goal
        self._publish(goal, message)
        self._change(goal, GoalEvent.EXECUTE)
        if holder is not None and action.codes.busy is not None:
            running = f"{holder.server.action.name} goal {holder.goal_id}"
            self._end(goal, GoalEvent.ABORT, action.failure(action.codes.busy, f"{name} is busy with {running}"))
            return
        if action.holds_base:
            self._holders[name] = goal
        goal.process = self._env.process(self._pursue(goal, message))

    def _pursue(self, goal: _Goal, message: Message) -> Generator[Any, Any, None]:
        """Run the action's process and give the goal its verdict; who halts a goal has given it already."""
        action = goal.server.action
        try:
            result = yield from action.process(goal.server.robot, message, _Report(self, goal))
            if not isinstance(result, action.result):
                raise TypeError(f"{action.name} returned {result!r} and no {action.result.ros_type}")  # noqa: TRY301
        except Interrupt:
            return
        except GoalAborted as aborted:
            self._end(goal, GoalEvent.ABORT, goal.failed(aborted.code, str(aborted)))
        except Exception as bug:
            self._end(goal, GoalEvent.ABORT, goal.failed(action.codes.unknown, f"bug in {action.name}: {bug!r}"))
            raise
        else:
            self._end(goal, GoalEvent.SUCCEED, result)
        finally:
            goal.process = None

    def _halt(self, goal: _Goal, event: GoalEvent, code: int, message: str) -> None:
        """End a running goal from outside; its process is interrupted at this instant, before anything else."""
        self._end(goal, event, goal.failed(code, message))
        process, goal.process = goal.process, None
        if process is not None and process.is_alive:
            process.interrupt()

    def _end(self, goal: _Goal, event: GoalEvent, result: Message) -> None:
        """Give a goal its terminal status: last feedback, status, results, in this order."""
        if goal.status.terminal:
            return
        name = goal.server.robot.name
        if goal.sample is not None:
            self._telemetry.stop(goal)
            if self._interest.feedback:
                self.send_feedback(goal, goal.sample(), last=True)
            goal.sample = None
        if self._holders.get(name) is goal:
            del self._holders[name]
        goal.result, goal.failure = result, None
        self._change(goal, event)
        for reply_to in goal.waiting:
            self._answer(reply_to, ResultResponse(goal.status, result))
        goal.waiting.clear()
        ended = self._ended.setdefault(name, {})
        ended[goal] = None
        if len(ended) > self._keep_results:
            self._forget(next(iter(ended)))

    def _change(self, goal: _Goal, event: GoalEvent) -> None:
        goal.status = next_status(goal.status, event)
        self._publish(goal)

    def _publish(self, goal: _Goal, message: Message | None = None) -> None:
        server = goal.server
        robot, action = server.robot.name, server.action.name
        self._emit(GoalChanged(self._stamp(), robot, action, goal.goal_id, goal.status, message, goal.result))
        if self._interest.status:
            self._emit(self._status(server))

    # --- feedback -------------------------------------------------------------------------------------------------

    def send_feedback(self, goal: _Goal, feedback: Message | Mapping[str, Any], *, last: bool = False) -> None:
        """Send feedback of a goal that runs, if anybody listens."""
        if not goal.status.terminal and self._interest.feedback:
            server = goal.server
            self._emit(FeedbackSent(server.robot.name, server.action.name, goal.goal_id, feedback, last))

    def sample_feedback(self, goal: _Goal, source: Callable[[], Message | Mapping[str, Any]]) -> None:
        """Send what *source* says at the feedback rate, and once more when the goal ends."""
        goal.sample, goal.sampled_from = source, self._env.now
        if self._interest.feedback:
            self._start_sampling(goal, source)

    def interest_changed(self) -> None:
        """Begin to sample the feedback of the goals that run, if somebody has come to listen."""
        if self._interest.feedback:
            for goal in self._active():
                if goal.sample is not None and goal not in self._telemetry:
                    self._start_sampling(goal, goal.sample)

    def _start_sampling(self, goal: _Goal, source: Callable[[], Message | Mapping[str, Any]]) -> None:
        def take() -> None:
            self.send_feedback(goal, source())

        self._telemetry.start(goal, Topic.FEEDBACK, goal.sampled_from, self._feedback_rate, take)

    # --- cancel and results ---------------------------------------------------------------------------------------

    def cancel_goal(self, command: CancelGoal) -> None:
        """Cancel what the command selects (rcl's rules), and answer; the goals end at this instant."""
        server = self._find(command)
        if server is None:
            return
        chosen = [goal for goal in server.goals.values() if _selects(command, goal)]
        code = _CANCEL.ERROR_NONE
        if not chosen and command.goal_id != ZERO_ID and not command.stamp:
            known = command.goal_id in server.goals
            code = _CANCEL.ERROR_GOAL_TERMINATED if known else _CANCEL.ERROR_UNKNOWN_GOAL_ID
        for goal in chosen:
            self._change(goal, GoalEvent.CANCEL)
        self._answer(command.reply_to, CancelResponse(code, tuple(goal.entry() for goal in chosen)))
        for goal in chosen:
            self._halt(goal, GoalEvent.CANCELED, server.action.codes.canceled, "canceled")

    def get_result(self, command: GetResult) -> None:
        """Answer with the goal's result: now if it has ended or isn't known, else when it ends."""
        server = self._find(command)
        if server is None:
            return
        goal = server.goals.get(command.goal_id)
        if goal is None:
            self._answer(command.reply_to, ResultResponse(GoalStatus.UNKNOWN, server.action.result()))
        elif goal.result is not None and goal.status.terminal:
            self._answer(command.reply_to, ResultResponse(goal.status, goal.result))
        else:
            goal.waiting.append(command.reply_to)

    def status(self, robot: str, action: str) -> StatusChanged:
        """Return the latest status list of a robot's action.

        Raises:
            GoalRejected: There is no such robot or action.
        """
        return self._status(self._server(robot, action))

    def forget(self, robot: str, action: str, goal_id: str) -> None:
        """Drop a result that is kept no longer; nothing happens if it isn't there or still awaited."""
        server = self._servers.get((robot, action))
        goal = server.goals.get(goal_id) if server else None
        if goal and goal.status.terminal:
            self._forget(goal)

    def _forget(self, goal: _Goal) -> None:
        """Drop a goal but for its id, so that a late resend is not executed again; ours nobody can resend."""
        del goal.server.goals[goal.goal_id]
        if goal.from_client:
            goal.server.forgotten[goal.goal_id] = goal.status
        self._ended[goal.server.robot.name].pop(goal, None)

    def stop(self, reason: str) -> int:
        """Abort every goal that runs, saying why; return how many there were."""
        running = list(self._active())
        for goal in running:
            # It may be what the simulation dies of, and the other goals need their verdicts, too.
            goal.sample = None
            self._halt(goal, GoalEvent.ABORT, goal.server.action.codes.unknown, reason)
        return len(running)

    def _stamp(self) -> int:
        """Return the stamp of this instant, at which more may happen."""
        now = self._env.now
        if now != self._instant:
            self._instant, self._instant_stamp = now, stamp(now)
        return self._instant_stamp

    # --- small things ---------------------------------------------------------------------------------------------

    def _active(self) -> Iterator[_Goal]:
        for server in self._servers.values():
            yield from (goal for goal in server.goals.values() if not goal.status.terminal)

    def _find(self, command: CancelGoal | GetResult) -> _Server | None:
        """Return the server that a command names; answer that there is none."""
        try:
            return self._server(command.robot, command.action)
        except GoalRejected as error:
            field_ = "robot" if error.reason == "unknown_robot" else "action"
            self._answer(command.reply_to, Refused(field_, getattr(command, field_), str(error)))
            return None

    def _answer(self, reply_to: Any, answer: Any) -> None:
        if reply_to is not None:
            self._emit(Answered(reply_to, answer))

    def _status(self, server: _Server) -> StatusChanged:
        entries = tuple(goal.entry() for goal in server.goals.values())
        return StatusChanged(server.robot.name, server.action.name, entries)


def _as_answered(goal_id: str | None) -> str:
    """Return an id as answers have it, without hyphens; what is no id as it was sent."""
    try:
        return parse_goal_id(goal_id or "")
    except ValueError:
        return goal_id or ""


def _selects(command: CancelGoal, goal: _Goal) -> bool:
    """Return whether a cancel request selects a goal, as action_msgs/srv/CancelGoal says."""
    if not goal.status.cancelable:
        return False
    if goal.goal_id == command.goal_id:
        return True
    if command.stamp:
        return goal.stamp <= command.stamp
    return command.goal_id == ZERO_ID

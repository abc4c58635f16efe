"""The dispatcher of goals: accepts or rejects, executes, preempts and cancels them, and keeps their results.

Every accepted goal gets exactly one terminal status, also when the simulation stops or an action has a bug.
All requests that wait for a result are held here, in the simulation's thread.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Mapping
from types import GeneratorType
from typing import TYPE_CHECKING, Any, Final

from simpy import Event as SimpyEvent
from simpy import Interrupt
from simpy.events import Interruption, Process

from hmrsim.engine.internal_errors import BUGS, described
from hmrsim.errors import GoalAborted, GoalRejected
from hmrsim.events.goals import SendGoalRejected
from hmrsim.goals.fault_effects import DelayedUpdates, DisconnectedRobots, GoalFaults, no_connection
from hmrsim.goals.feedback import Feedback
from hmrsim.goals.node_states import ACTIVE, NodeStates
from hmrsim.goals.servers import ActionServers, ServedGoal, as_answered, selects
from hmrsim.interfaces.action_msgs import CancelGoal as CancelGoalService
from hmrsim.interfaces.message import lists_messages
from hmrsim.protocol.goal import (
    ZERO_ID,
    CancelResponse,
    Cause,
    GoalEvent,
    GoalResponse,
    GoalStatus,
    Refused,
    ResultResponse,
    Verdict,
    next_status,
)
from hmrsim.protocol.outputs import Answered, GoalChanged, GoalTold, Receiver, RosterChanged, StatusChanged

if TYPE_CHECKING:
    import simpy

    from hmrsim.actions import AnyAction
    from hmrsim.engine.environment import Environment
    from hmrsim.engine.internal_errors import InternalErrors
    from hmrsim.engine.subscriptions import EventPublisher, Telemetry
    from hmrsim.goals.fault_effects import Abortion
    from hmrsim.goals.servers import ActionServer, Owner
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import CancelGoal, ChangeState, ForgetResult, GetResult, SendGoal, StopWaiting

_CANCEL = CancelGoalService.Response

_UNPACKED: Final = 256
"""Ended goals whose results are kept as they are: most clients ask for one soon, if they do at all.

Only the last one if it lists messages, such as the poses of a path, of which there may be many.
"""


class _Report:
    """The feedback and the result of an executing goal."""

    def __init__(self, feedback: Feedback, goal: ServedGoal) -> None:
        self._feedback = feedback
        self._goal = goal

    def send(self, feedback: Message | Mapping[str, Any]) -> None:
        self._feedback.send(self._goal, feedback, last=True)

    def sample(self, source: Callable[[], Message | Mapping[str, Any]]) -> None:
        self._feedback.sample(self._goal, source)

    def on_failure(self, make: Callable[[int, str], Message]) -> None:
        if not self._goal.status.terminal:
            self._goal.failure = make


class Dispatcher:
    """Serves the actions of all robots.

    Args:
        publisher: Publishes rejected goals, and knows the topics that have subscribers.
        errors: Handles what actions raise because of a bug.
        seed: From which the ids of goals that have none are made.
        keep_results: Maximum number of ended goals kept per robot.
        feedback_rate: Samples of feedback a second of simulated time.

    Attributes:
        cut_off: The robots that clients can't reach: requests are rejected, results are withheld.
        nodes: The states of the ROS nodes that serve the actions.
        faults: The faults that reject or abort goals.
        updates: The goal updates that have not reached clients yet.
        feedback: Publishes the feedback of goals.
    """

    def __init__(
        self,
        env: Environment,
        actions: Mapping[str, AnyAction],
        telemetry: Telemetry,
        *,
        publisher: EventPublisher,
        errors: InternalErrors,
        seed: str = "0",
        keep_results: int = 1000,
        feedback_rate: float = 10.0,
    ) -> None:
        self._env = env
        self.servers = ActionServers(actions, seed)
        self.cut_off = DisconnectedRobots()
        self.nodes = NodeStates()
        self.faults = GoalFaults(env, self.servers.active, self._abort_by_fault)
        self.feedback = Feedback(
            env, self.servers, self.cut_off, telemetry, publisher=publisher, errors=errors, rate=feedback_rate
        )
        self.updates = DelayedUpdates(env, lambda robot: map(self._status, self.servers.of(robot)))
        self._emit = publisher.emit
        self._handlers = publisher.handlers
        self._publisher = publisher
        self._interest = publisher.interest
        self._errors = errors
        self._keep_results = keep_results
        self._holders: dict[str, ServedGoal] = {}
        self._ended: dict[str, dict[ServedGoal, None]] = {}
        self._unpacked: deque[ServedGoal] = deque()

    def goal_of(self, robot: str) -> tuple[str, str] | None:
        """Return action and id of the goal that holds a robot's base; None when none does."""
        goal = self._holders.get(robot)
        return (goal.server.action.name, goal.goal_id) if goal else None

    def settled(self, command: SendGoal) -> SendGoal:
        """Return the command with the default verdict if its verdict makes no difference, so that traces are equal."""
        plain = command._replace(verdict=Verdict.REJECT)
        try:
            self.servers.acceptable(self.servers.find(command.robot, command.action), plain)
        except BUGS:  # `send_goal` handles it
            return command
        return plain

    def send_goal(self, command: SendGoal, *, in_real_time: bool = False) -> None:
        """Accept or reject a goal, and answer; an accepted one begins at this instant.

        A client *in_real_time* sends its next goal some time after this one has ended, not at the same instant.
        """
        flaw: tuple[int, str] | None = None
        try:
            server = self.servers.find(command.robot, command.action)
            if self.cut_off:
                self.cut_off.check(command)
            goal_id = self.servers.goal_id(server, command.goal_id)
            known = server.goals.get(goal_id)
            status = known.status if known else self.servers.forgotten(server, goal_id)
            if status is not None:
                stamp = known.stamp if known else self._env.stamp
                self._answer_duplicate(command, goal_id, status, stamp, server.action.codes.rejected)
                return
            self.nodes.check(command)
            try:
                message = self.servers.acceptable(server, command)
            except GoalRejected as rejection:
                if rejection.code is None or command.goal is None or not _aborts(command.verdict, rejection):
                    raise
                message, flaw = command.goal, (rejection.code, str(rejection))
            self.faults.check(command)
        except GoalRejected as rejection:
            self._reject(command, rejection.reason, str(rejection))
            return
        except BUGS as bug:
            self._errors.handle(f"action {command.action}", bug, command.robot)
            self._reject(command, "internal_error", f"bug in {command.action}: {described(bug)}")
            return
        from_client = command.goal_id is not None
        goal = ServedGoal(server, goal_id, self._env.stamp, from_client=from_client, in_real_time=in_real_time)
        if command.result_to is not None:
            goal.waiting[id(command.result_to)] = command.result_to
        if command.reply_to is not None:
            self._answer(command.reply_to, GoalResponse(True, goal_id, goal.stamp))
        if flaw is not None:
            self._begin(goal, message)
            self._end(goal, GoalEvent.ABORT, self._failed(goal, *flaw), Cause.FAILED)
            return
        self._start(goal, message)

    def _reject(self, command: SendGoal, reason: str, why: str) -> None:
        answer = GoalResponse(
            accepted=False,
            goal_id=as_answered(command.goal_id),
            stamp=self._env.stamp,
            reason=reason,
            error_code=self.servers.rejected_code(command.action),
            error_msg=why,
        )
        self._answer(command.reply_to, answer)
        self._publisher.announce(_rejected(command, answer))

    def _answer_duplicate(self, command: SendGoal, goal_id: str, status: GoalStatus, stamp: int, code: int) -> None:
        answer = GoalResponse(
            accepted=False,
            goal_id=goal_id,
            stamp=stamp,
            reason="duplicate_goal_id",
            error_code=code,
            error_msg=f"goal {goal_id} was sent before and is {status.name}",
            status=status,
        )
        self._answer(command.reply_to, answer)

    def _start(self, goal: ServedGoal, message: Message) -> None:
        """Execute an accepted goal; it preempts the goal that holds its resource, or is aborted if the base is busy."""
        action, name = goal.server.action, goal.server.robot.name
        needed = goal.server.needs
        holder = self._holders.get(needed)
        if holder is not None and action.codes.busy is None:
            # Before the new goal is published, so that no client sees two goals that execute on one base.
            code = holder.server.action.codes.preempted
            self._halt(holder, GoalEvent.ABORT, code, f"preempted by goal {goal.goal_id}", Cause.PREEMPTED)
        self._begin(goal, message)
        if holder is not None and action.codes.busy is not None:
            running = f"{holder.server.action.name} goal {holder.goal_id}"
            result = self._failed(goal, action.codes.busy, f"{name} is busy with {running}")
            self._end(goal, GoalEvent.ABORT, result, Cause.BUSY)
            return
        faulty = self.faults.armed
        hit = self.faults.met(name, action.name) if faulty else None
        if hit is not None:
            self._end(goal, GoalEvent.ABORT, self._failed(goal, self._code_of(hit, goal), hit.why), hit.cause)
            hit.done()
            return
        if needed:
            self._holders[needed] = goal
        goal.process = Process(self._env, self._pursue(goal, message))
        if faulty:
            self.faults.begun(goal)

    def _begin(self, goal: ServedGoal, message: Message) -> None:
        """Publish that a goal executes."""
        server = goal.server
        server.goals[goal.goal_id] = goal
        goal.message = message
        if self._interest.motion:
            self._publisher.publish_untraced(goal.accepted)
        self._publish(goal, goal.stamp, message)
        self._change(goal, GoalEvent.EXECUTE, goal.stamp)
        server.robot.act(server.action.name, holds=server.needs != "", in_real_time=goal.in_real_time)

    def _abort_by_fault(self, goal: ServedGoal, hit: Abortion) -> None:
        """Abort an executing goal because of an injected fault."""
        self._halt(goal, GoalEvent.ABORT, self._code_of(hit, goal), hit.why, hit.cause)

    @staticmethod
    def _code_of(hit: Abortion, goal: ServedGoal) -> int:
        return goal.server.action.codes.unknown if hit.code is None else hit.code

    def _pursue(self, goal: ServedGoal, message: Message) -> Generator[Any, Any, None]:
        """Run the action's process and set the goal's terminal status, unless it was halted."""
        action, process = goal.server.action, self._env.active_process
        try:
            steps = action.process(goal.server.robot, message, _Report(self.feedback, goal))
            if type(steps) is not GeneratorType and not isinstance(steps, Generator):
                raise TypeError(
                    "its process has no `yield`: write `yield from robot.hold(…)`, not `robot.hold(…)`, for each step;"
                    " one that takes no time has `yield from ()`"
                )
            result = _checked(action, (yield from steps))
        except Interrupt:
            return
        except GoalAborted as aborted:
            self._end(goal, GoalEvent.ABORT, self._failed(goal, aborted.code, str(aborted)), aborted.cause)
        except BUGS as bug:
            if self._env.active_process is not process:
                # It is closed from outside.
                raise
            goal.process = None
            self._abort_for(goal, bug)
        else:
            self._end(goal, GoalEvent.SUCCEED, result)
        finally:
            goal.process = None

    def _halt(self, goal: ServedGoal, event: GoalEvent, code: int, message: str, cause: str) -> None:
        """End an executing goal; its process is interrupted at this instant, before any other event."""
        self._end(goal, event, self._failed(goal, code, message), cause)
        process, goal.process = goal.process, None
        if process is None or not process.is_alive:
            return
        if process is self._env.active_process:
            # Its own action has ended it; a process can't interrupt itself.
            self._env.call_soon(lambda: self._interrupt(goal, process))
        else:
            self._interrupt(goal, process)

    def _interrupt(self, goal: ServedGoal, process: simpy.Process) -> None:
        """Interrupt the process of a goal that has ended; the base may be another goal's at this instant."""
        if not process.is_alive:
            return

        def check(_event: SimpyEvent) -> None:
            if process.is_alive:
                self._kill(goal, process)
                self._bug_in(goal, RuntimeError("it goes on after it was interrupted"))

        interruption = Interruption(process, None)
        interruption.callbacks.append(check)

    def _kill(self, goal: ServedGoal, process: simpy.Process) -> None:
        try:
            self._env.kill(process)
        except BUGS as bug:
            self._bug_in(goal, bug)

    def process_failed(self, process: simpy.Process, bug: BaseException) -> bool:
        """Abort a goal whose process can't continue, for instance because it yielded something other than an event.

        Returns:
            Whether there is such a goal.
        """
        goal = next((goal for goal in self.servers.active() if goal.process is process), None)
        if goal is None:
            return False
        goal.process = None
        try:
            self._abort_for(goal, bug)
        finally:
            self._kill(goal, process)
        return True

    def _abort_for(self, goal: ServedGoal, bug: BaseException) -> None:
        """Abort a goal whose action has raised an unexpected error."""
        action = goal.server.action
        # Its feedback may fail for the same reason.
        self.feedback.stop(goal)
        self._halt(goal, GoalEvent.ABORT, action.codes.unknown, f"bug in {action.name}: {described(bug)}", Cause.BUG)
        self._bug_in(goal, bug)

    def _bug_in(self, goal: ServedGoal, bug: BaseException) -> None:
        self._errors.handle(f"action {goal.server.action.name}", bug, goal.server.robot.name)

    def _failed(self, goal: ServedGoal, code: int, message: str) -> Message:
        """Return the result of a goal that did not succeed; an empty one if its action can't make it."""
        action = goal.server.action
        try:
            return _checked(action, goal.failed(code, message))
        except BUGS as bug:
            self._bug_in(goal, bug)
            empty: Message = action.result()
            return empty

    def _end(self, goal: ServedGoal, event: GoalEvent, result: Message, cause: str = "") -> None:
        """Give a goal its terminal status: last feedback, status, results, in this order."""
        if goal.status.terminal:
            return
        name = goal.server.robot.name
        self.feedback.finish(goal)
        if self.faults.armed:
            self.faults.ended(goal)
        needed = goal.server.needs
        if self._holders.get(needed) is goal:
            del self._holders[needed]
        status = next_status(goal.status, event)
        goal.server.robot.act(goal.server.action.name, status, holds=needed != "")
        stamp = self._env.stamp
        goal.end(stamp, result, cause)
        goal.status = status
        self._publish(goal, stamp)
        late = name in self.updates.late
        if late:
            self.updates.hold(goal, lambda: self._tell(goal, inside=name in self.cut_off))
        if goal.waiting:
            self._tell(goal, inside=late or name in self.cut_off)
        ended = self._ended.setdefault(name, {})
        ended[goal] = None
        if len(ended) > self._keep_results:
            self._forget(next(iter(ended)))
        unpacked = self._unpacked
        unpacked.append(goal)
        most = 1 if lists_messages(result) else _UNPACKED
        while (forgotten := unpacked[0].goal_id not in unpacked[0].server.goals) or len(unpacked) > most:
            oldest = unpacked.popleft()
            if not forgotten:
                oldest.pack_result(result)

    def _tell(self, goal: ServedGoal, *, inside: bool = False) -> None:
        """Answer all requests that wait for a goal that has ended, or only that of the robot's own script."""
        if not goal.waiting:
            return
        waiting, goal.waiting = goal.waiting, {}
        for key, reply_to in waiting.items():
            if inside and not isinstance(reply_to, SimpyEvent):
                goal.waiting[key] = reply_to
            elif (result := goal.result) is not None:
                self._answer(reply_to, ResultResponse(goal.status, result, goal.cause))

    def _change(self, goal: ServedGoal, event: GoalEvent, stamp: int) -> None:
        goal.status = next_status(goal.status, event)
        self._publish(goal, stamp)

    def _publish(self, goal: ServedGoal, stamp: int, message: Message | None = None) -> None:
        if self._handlers.get(GoalChanged) == [] and not (self._interest.status or self.updates.late):
            return
        server = goal.server
        result = None if goal.ended is None else goal.result
        robot, action = server.robot.name, server.action.name
        change = GoalChanged(stamp, robot, action, goal.goal_id, goal.status, message, result, goal.cause)
        self._emit(change)
        if robot in self.updates.late:
            status = self._status(server)
            self.updates.send(status, lambda: self._tell_change(change, status))
        elif self._interest.status:
            self._emit(self._status(server))

    def _tell_change(self, change: GoalChanged, status: StatusChanged) -> None:
        """Tell clients of a change that has happened before."""
        self._emit(GoalTold(change))
        if self._interest.status:
            self._emit(status)

    def cancel_goal(self, command: CancelGoal) -> None:
        """Cancel the goals that a command selects by the rules of rcl, and answer; the goals end at this instant."""
        server = self._find(command)
        if server is None:
            return
        if not self.cut_off.reach(command):
            self._answer(command.reply_to, Refused("robot", command.robot, no_connection(command.robot)))
            return
        chosen = [goal for goal in server.goals.values() if selects(command, goal)]
        code = _CANCEL.ERROR_NONE
        if not chosen and command.goal_id != ZERO_ID and not command.stamp:
            known = command.goal_id in server.goals
            code = _CANCEL.ERROR_GOAL_TERMINATED if known else _CANCEL.ERROR_UNKNOWN_GOAL_ID
        for goal in chosen:
            self._change(goal, GoalEvent.CANCEL, self._env.stamp)
        self._answer(command.reply_to, CancelResponse(code, tuple(goal.entry() for goal in chosen)))
        for goal in chosen:
            self._halt(goal, GoalEvent.CANCELED, server.action.codes.canceled, "canceled", Cause.CANCELED)

    def get_result(self, command: GetResult) -> None:
        """Answer with the result of a goal, at once if it has ended or is unknown, else when it ends."""
        server = self._find(command)
        if server is None:
            return
        goal = server.goals.get(command.goal_id)
        if goal is None:
            self._answer(command.reply_to, ResultResponse(GoalStatus.UNKNOWN, server.action.result()))
        elif self._is_known(goal) and self.cut_off.reach(command) and (result := goal.result) is not None:
            self._answer(command.reply_to, ResultResponse(goal.status, result, goal.cause))
        else:
            goal.waiting[id(command.reply_to)] = command.reply_to

    def _is_known(self, goal: ServedGoal) -> bool:
        """Return whether clients may know the result of a goal."""
        return goal.status.terminal and not self.updates.holds(goal)

    def withdraw(self, command: StopWaiting) -> None:
        """Drop some requests that wait for a result."""
        goal = self.servers.goal(command.robot, command.action, command.goal_id)
        for reply_to in command.reply_tos if goal else ():
            if goal and goal.waiting.pop(id(reply_to), None) is not None and command.tell:
                self._answer(reply_to, ResultResponse(goal.status, goal.server.action.result()))

    def status(self, robot: str, action: str) -> StatusChanged:
        """Return the latest status list of a robot's action that clients can know.

        Raises:
            GoalRejected: There is no such robot or action.
        """
        server = self.servers.find(robot, action)
        return self.updates.known(robot, action) or self._status(server)

    def forget(self, command: ForgetResult) -> None:
        """Drop an expired result; ignore one that is unknown or still awaited."""
        goal = self.servers.goal(command.robot, command.action, command.goal_id)
        if goal and goal.status.terminal and not goal.waiting:
            self._forget(goal)

    def _forget(self, goal: ServedGoal) -> None:
        self._tell(goal)
        self.servers.forget(goal)
        self._ended[goal.server.robot.name].pop(goal, None)

    def stop(
        self,
        reason: str,
        robot: str | None = None,
        *,
        cause: str = Cause.ENDED,
        stuck: Callable[[], Mapping[str, str]] = dict,
    ) -> None:
        """Abort every active goal of one robot or of all, with the reason and the cause.

        *stuck* returns why robots did not go on, by name; that follows the reason.
        """
        goals = list(self.servers.active(robot))
        reasons = stuck() if goals else {}
        for goal in goals:
            # Its feedback may be the call that failed, and the other goals must end, too.
            goal.sample = None
            why = reasons.get(goal.server.robot.name)
            text = f"{reason}; {why}" if why else reason
            self._halt(goal, GoalEvent.ABORT, goal.server.action.codes.unknown, text, cause)
        self.updates.flush(robot)
        # A client of a disconnected robot would wait for its result for ever.
        for name in sorted(self.cut_off) if robot is None else [robot]:
            self.connect(name, connected=True)

    def connect(self, robot: str, *, connected: bool) -> None:
        """Connect a robot to its clients, or disconnect it; connecting sends the results that were withheld."""
        if connected == (robot not in self.cut_off):
            return
        (self.cut_off.remove if connected else self.cut_off.add)(robot)
        self._emit(RosterChanged())
        for server in self.servers.of(robot) if connected else ():
            if self._interest.status:
                self._emit(self.status(robot, server.action.name))
            for goal in server.goals.values():
                if self._is_known(goal):
                    self._tell(goal)

    def free(self, robot: str, reason: str, cause: str) -> None:
        """Abort the goal that holds a robot's base, if any, saying why: as a text, and as an identifier."""
        holder = self._holders.get(robot)
        if holder is not None:
            self._halt(holder, GoalEvent.ABORT, holder.server.action.codes.unknown, reason, cause)

    def disable(self, robot: str, reason: str, cause: str) -> None:
        """Abort the goal that holds the base of a robot that is disabled, unless its action works on all the same."""
        holder = self._holders.get(robot)
        if holder is not None and holder.server.action.disabled_by(cause):
            self.free(robot, reason, cause)

    def change_state(self, command: ChangeState) -> None:
        """Change the state of a node, and answer; its goals end if it is no longer active."""
        there = self.servers.serves(command.robot) and self.cut_off.reach(command)
        changed = there and self.nodes.change(command)
        if changed and self.nodes.of(command.robot, command.node) != ACTIVE:
            for goal in list(self.servers.active(command.robot)):
                if goal.server.action.name in command.actions:
                    code = goal.server.action.codes.unknown
                    self._halt(goal, GoalEvent.ABORT, code, f"{command.node} was deactivated", Cause.DEACTIVATED)
        self._answer(command.reply_to, changed)

    def serve(self, robots: Mapping[str, Owner]) -> None:
        """Serve exactly these robots; no goal of another robot may be executing."""
        for name in self.servers.serve(robots):
            self._ended.pop(name, None)
            self.nodes.forget(name)

    def _find(self, command: CancelGoal | GetResult) -> ActionServer | None:
        """Return the server that a command names; if there is none, answer that and return None."""
        try:
            return self.servers.find(command.robot, command.action)
        except GoalRejected as error:
            field_ = "robot" if error.reason == "unknown_robot" else "action"
            self._answer(command.reply_to, Refused(field_, getattr(command, field_), str(error)))
            return None

    def _answer(self, reply_to: Any, answer: Any) -> None:
        if isinstance(reply_to, (Receiver, SimpyEvent)):
            # A participant in lockstep waits for it, or the script of a robot.
            reply_to.succeed(answer)
        elif reply_to is not None:
            self._emit(Answered(reply_to, answer))

    def _status(self, server: ActionServer) -> StatusChanged:
        entries = tuple(goal.entry() for goal in server.goals.values())
        return StatusChanged(server.robot.name, server.action.name, entries)


def _checked(action: AnyAction, result: Any) -> Message:
    """Return the result of an action.

    Raises:
        TypeError: It is none.
    """
    if not isinstance(result, action.result):
        raise TypeError(f"{action.name} returned {result!r} and no {action.result.ros_type}")
    message: Message = result
    return message


def _aborts(verdict: Verdict, rejection: GoalRejected) -> bool:
    """Return whether a goal that can't be executed is accepted all the same, and aborted."""
    return verdict is Verdict.ABORT or (verdict is Verdict.ABORT_OR_REJECT and not rejection.early)


def _rejected(command: SendGoal, answer: GoalResponse) -> SendGoalRejected:
    return SendGoalRejected(command.robot, command.action, answer.goal_id, answer.reason, answer.error_msg)

"""The client's handle of a goal, which keeps it up to date over a transport that may lose any message.

Zenoh delivers at most once, and a missing reply means nothing. So the client generates the goal id and sends the goal
again with the same id; a duplicate then counts as accepted. A get_result request whose reply was lost is repeated.
The client requests the result right after the goal, before the goal is accepted, which saves a round trip.
By ``execute`` both are one query; what it does not bring is requested as above.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

from hmrsim.interfaces.message import Message
from hmrsim.protocol.commands import CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import CancelResponse, GoalResponse, GoalStatus, ResultResponse
from hmrsim_zenoh.client.connection import message_of
from hmrsim_zenoh.errors import GoalRejectedError, GoalTimeout, ResultExpired, SimulatorGone
from hmrsim_zenoh.wire.envelopes import UnreadableError

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Connection
    from hmrsim_zenoh.client.link import Link
    from hmrsim_zenoh.client.lockstep import Lockstep

R = TypeVar("R", bound=Message)
F = TypeVar("F", bound=Message)

_log = logging.getLogger(__name__)

_DUPLICATE: Final = "duplicate_goal_id"
_CANCEL_REJECTED: Final = 1

# Zenoh's default query timeout is 10 s; a mission takes longer.
_FOR_EVER: Final = 1e6
# The timeout of one attempt at a request that is answered at once. The request is idempotent.
_ONE_TRY: Final = 3.0
_FIRST_PAUSE: Final = 0.05
_MAX_PAUSE: Final = 0.4
_PAUSE_FACTOR: Final = 1.5


class GoalHandle(Generic[R, F]):
    """A goal that was sent, and its status. Any thread may read it and wait for it.

    A goal ends in one of three ways: with a terminal *status* and its *result_message*; rejected, *accepted* is
    False and *error* says why; or failed, *error* says why and the robot's state is unknown.

    Callbacks run one at a time, in order, mostly in Zenoh's thread, in lockstep in the waiting thread. They must be
    quick and must not block.

    Attributes:
        goal_id: The goal's id, 32 hex digits.
        status: The goal's status as last received; UNKNOWN until it is accepted.
        accepted: Whether the goal was accepted; None until that is known.
        found: The status of the goal when it was adopted; None if this client sent it.
        error: Why the goal was rejected or failed, or has no result; else None.
        result_message: The result; None until the status is terminal, and if it was not to be read.
        cause: Why it was aborted or canceled, as an identifier such as ``preempted``; empty if it was not, or unknown.
        feedback: The latest feedback; None without *on_feedback*, since only then the client subscribes to feedback.
        done: Whether the goal is final: terminal, rejected or failed.
    """

    def __init__(
        self,
        link: Link,
        lockstep: Lockstep | None,
        target: ActionTarget,
        command: SendGoal,
        *,
        on_feedback: Callable[[F], object] | None,
        on_change: Callable[[GoalHandle[R, F]], None] | None,
        on_done: Callable[[GoalHandle[R, F]], None],
    ) -> None:
        self._link = link
        self._lockstep = lockstep
        self._commands: Connection | Lockstep = lockstep or link.connection
        self._target = target
        self._command = command
        self.goal_id = command.goal_id or ""
        self._on_feedback = on_feedback
        self._on_change = on_change
        self._on_done = on_done
        # Taken several times for each change; a condition does it in Python.
        self._lock = threading.RLock()
        self._changed: threading.Condition | None = None
        self.status = GoalStatus.UNKNOWN
        self.accepted: bool | None = None
        self.error: Exception | None = None
        self.result_message: R | None = None
        self.cause = ""
        self.feedback: F | None = None
        self.done = False
        self.found: GoalStatus | None = None
        # The callbacks that are due, with their arguments.
        self._mail: deque[tuple[Callable[[Any], object], object]] = deque()
        self._delivering = False
        self._adopt = False
        self._ended_before: GoalStatus | None = None
        self._read_result = True
        self._sends = 0
        self._deadline = math.inf
        self._pause = _FIRST_PAUSE
        self._result_asked = False
        self._cancel_wanted = False
        self._cancel_sent = False

    def __repr__(self) -> str:
        """Return the goal's action, id and status."""
        failed = ", failed" if self.error else ""
        return f"<goal {self.goal_id} of {self._target.name}: {self.status.name}{failed}>"

    @property
    def adopted(self) -> bool:
        """Return whether the handle follows a goal that the simulator knew already; see `ActionClient.send_goal`."""
        return self.found is not None

    def wait_accepted(self, timeout: float | None = None) -> None:
        """Wait until the goal is accepted.

        Raises:
            GoalRejectedError: It was rejected.
            SimulatorNotFound, SimulatorGone, RequestError, ClientClosed: It failed.
            GoalTimeout: Acceptance is unknown after *timeout* seconds, or the simulator's answer timed out.
        """
        if not self._wait(lambda: self.accepted is not None or self.done, timeout, at_once=True):
            raise GoalTimeout(
                f"{self._target.name}: no answer to goal {self.goal_id} after {timeout:g} s; it may go on"
            )
        with self._lock:
            if not self.accepted and self.error is not None:
                raise self.error

    def result(self, timeout: float | None = None, *, sim_timeout: float | None = None) -> R:
        """Wait for the end of the goal and return the result, whatever its *status*.

        Args:
            timeout: Wall seconds; None for no limit.
            sim_timeout: Simulated seconds from now on; None for no limit.

        Raises:
            GoalRejectedError: It was rejected.
            SimulatorNotFound, SimulatorGone, RequestError, ClientClosed: It failed.
            GoalTimeout: There is none after so many seconds (the goal goes on unless the caller cancels it), or the
                simulator's acceptance timed out.
        """
        if not self._wait(lambda: self.done, timeout, sim_timeout=sim_timeout):
            given = ((timeout, "s"), (sim_timeout, "simulated s"))
            after = " or ".join(f"{seconds:g} {unit}" for seconds, unit in given if seconds is not None)
            raise GoalTimeout(f"{self._target.name}: no result of goal {self.goal_id} after {after}; it goes on")
        with self._lock:
            if self.error is not None:
                raise self.error
            if self.result_message is None:
                raise AssertionError
            return self.result_message

    def cancel(self) -> None:
        """Request the goal's cancellation and return at once.

        A request made before acceptance is sent upon acceptance. Further requests do nothing.
        """
        self._cancel_wanted = True
        self._cancel_if_due()

    def start(self, *, adopt: bool = False, read_result: bool = True, execute: bool = False) -> None:
        """Send the goal and request its result; called once.

        Args:
            adopt: Whether to follow a goal that was sent before under this id.
            read_result: Whether to read the result if the goal succeeds.
            execute: Whether to do both in one query.
        """
        self._adopt = adopt
        self._read_result = read_result
        # In lockstep no reply comes before time advances.
        if not self._commands.ordered:
            self._deadline = self._patience_from_now()
        if not execute:
            self._send_goal()
            # Whether the goal is an older one has to be known before its result arrives.
            if not adopt:
                self._ask_result()
            return
        self._sends = 1
        self._result_asked = True
        self._link.worker.after(_ONE_TRY, self._send_goal, rounded=True)
        self._link.connection.execute(
            self._target,
            self._command,
            timeout=_FOR_EVER,
            on_answer=self._on_execution,
            on_end=self._on_execution_end,
            read=read_result,
        )

    def take_feedback(self, feedback: F) -> None:
        """Process feedback for this goal."""
        with self._lock:
            if self.done or self._on_feedback is None:
                return
            self.feedback = feedback
            self._mail.append((self._on_feedback, feedback))
            # Feedback implies EXECUTING. The client subscribes to no status topic, so feedback may be the first sign.
            if self.accepted and self._raise_status(GoalStatus.EXECUTING):
                self._note_change()
        self._deliver()

    def fail(self, error: Exception) -> None:
        """Fail the goal with an error."""
        self._finish(error=error)

    def _on_execution(self, answer: Answer) -> None:
        if isinstance(answer, GoalResponse) or not self.accepted:
            self._on_goal_answer(answer)
        else:
            self._on_result_answer(True, answer)

    def _on_execution_end(self) -> None:
        """Request what is missing: the reply was lost, or the server of this robot has no such key."""
        if not self.done:
            self._link.worker.after(0.0, self._go_on_without_execution)

    def _go_on_without_execution(self) -> None:
        if self.accepted:
            self._on_result_answer(True, None)
        else:
            with self._lock:
                self._result_asked = False
            self._send_goal()

    def _send_goal(self) -> None:
        if self.done or self.accepted:
            return
        patience = self._deadline - time.monotonic()
        if patience > 0:
            self._sends += 1
            timeout = min(patience, _ONE_TRY)
            self._commands.send(self._target, self._command, self._on_goal_answer, timeout=timeout)
            return
        # The goal may have been accepted nevertheless, and should not run without a client.
        self._commands.send(self._target, self._cancel, lambda _answer: None, timeout=_ONE_TRY)
        text = f"no answer to goal {self.goal_id} in {self._link.acknowledge_timeout:g} s; the goal is given up"
        self.fail(GoalTimeout(f"{self._target.name}: {text}"))

    def _on_goal_answer(self, answer: Answer) -> None:
        if answer is None:
            self._deadline = min(self._deadline, self._patience_from_now())
            self._again(self._send_goal)
        elif not isinstance(answer, GoalResponse):
            self.fail(answer)
        elif answer.accepted:
            self._accept(GoalStatus.ACCEPTED)
        elif answer.reason == _DUPLICATE and (self._adopt or self._sends > 1):
            # An earlier attempt arrived. At the first attempt the id is another client's, or of an earlier process.
            status = GoalStatus.UNKNOWN if answer.status is None else answer.status
            self.found = status if self._adopt else None
            self._ended_before = status if status.terminal else None
            self._accept(status)
        else:
            error = GoalRejectedError(answer.reason or "rejected", answer.error_code, answer.error_msg)
            self._finish(accepted=False, error=error)

    def _accept(self, status: GoalStatus) -> None:
        with self._lock:
            if self.done or self.accepted:
                return
            self.accepted = True
            # A duplicate may have got further; if it has ended, get_result reports the status with the result.
            self._raise_status(GoalStatus.ACCEPTED if status.terminal else status)
            self._note_change()
        if self._mail:
            self._deliver()
        self._pause = _FIRST_PAUSE
        if not self._result_asked:
            self._ask_result()
        if self._cancel_wanted:
            self._cancel_if_due()

    def _patience_from_now(self) -> float:
        return time.monotonic() + self._link.acknowledge_timeout

    def _ask_result(self) -> None:
        with self._lock:
            if self.done or self._result_asked:
                return
            self._result_asked = True
            accepted = bool(self.accepted)
        command = GetResult(self._target.robot, self._target.action.name, self.goal_id)
        then = partial(self._on_result_answer, accepted)
        read, ended = self._read_result, self._ended_before is not None
        self._commands.send(self._target, command, then, timeout=_FOR_EVER, read=read or ended, ended=ended)

    def _on_result_answer(self, asked_when_accepted: bool, answer: Answer) -> None:  # noqa: FBT001 - for partial
        with self._lock:
            self._result_asked = False
            accepted = self.accepted
        if self.done:
            return
        error: Exception | None = self._take_result(answer) if isinstance(answer, ResultResponse) else answer
        # Requested too early, or lost along with the goal: requested again when the goal is accepted.
        if self.done or not accepted:
            return
        if error is None:
            self._again(self._ask_result)
        elif not asked_when_accepted:
            self._ask_result()
        else:
            self.fail(error)

    def _take_result(self, answer: ResultResponse) -> Exception | None:
        """End with a result; return why it is none."""
        status, result = answer.status, None
        if status.terminal:
            if self._read_result or status is not GoalStatus.SUCCEEDED:
                try:
                    result = message_of(self._target.action.result, answer.result)
                except UnreadableError as error:
                    return error
            self._finish(status, accepted=True, result=result, cause=answer.cause)
        elif (before := self._ended_before) is not None:
            text = f"goal {self.goal_id} is {before.name}, but its result is not kept any longer"
            self._finish(before, error=ResultExpired(text))
        else:
            return SimulatorGone(f"{self._target.name}: the simulator does not know goal {self.goal_id} any more")
        return None

    @property
    def _cancel(self) -> CancelGoal:
        return CancelGoal(self._target.robot, self._target.action.name, self.goal_id)

    def _cancel_if_due(self) -> None:
        with self._lock:
            possible = self.accepted or self._commands.ordered
            if not (self._cancel_wanted and possible) or self._cancel_sent or self.done:
                return
            self._cancel_sent = True
        self._send_cancel()

    def _send_cancel(self) -> None:
        if not self.done:
            self._commands.send(self._target, self._cancel, self._on_cancel_answer, timeout=_ONE_TRY)

    def _on_cancel_answer(self, answer: Answer) -> None:
        if self.done:
            return
        if answer is None:
            self._again(self._send_cancel)
        elif isinstance(answer, CancelResponse) and answer.return_code != _CANCEL_REJECTED:
            # Without a goal that is being canceled, it has ended or is unknown, and its result will show which.
            if answer.goals_canceling:
                with self._lock:
                    if not self.done and self._raise_status(GoalStatus.CANCELING):
                        self._note_change()
                self._deliver()
        else:
            if not isinstance(answer, CancelResponse):
                _log.warning("%s: goal %s can't be canceled: %s", self._target.name, self.goal_id, answer)
            # The caller may request it again.
            with self._lock:
                self._cancel_wanted = self._cancel_sent = False

    def _again(self, step: Callable[[], None]) -> None:
        """Retry a step after a delay, while an answer is still possible."""
        if absence := self._link.absence():
            self.fail(absence)
            return
        self._link.worker.after(self._pause, step)
        self._pause = min(self._pause * _PAUSE_FACTOR, _MAX_PAUSE)

    def _wait(
        self,
        condition: Callable[[], bool],
        timeout: float | None,
        *,
        sim_timeout: float | None = None,
        at_once: bool = False,
    ) -> bool:
        """Wait for a condition, for so many wall and so many simulated seconds at most; return whether it holds.

        *at_once* if that takes no simulated time.
        """
        limit, left = None if timeout is None else time.monotonic() + timeout, sim_timeout
        if (lockstep := self._lockstep) is not None:
            if left is not None:
                left = lockstep.drive_within(condition, timeout, left)
            elif lockstep.drive(condition, timeout, until=lockstep.now if at_once else math.inf):
                return True
        if condition() or (left is not None and left <= 0.0):
            return condition()
        over = False

        def ring() -> None:
            nonlocal over
            with self._lock:
                over = True
                if self._changed is not None:
                    self._changed.notify_all()

        alarm = None if left is None else self._link.alarm(left, ring)
        try:
            with self._lock:
                # Made for the first thread that waits: mostly none does.
                self._changed = self._changed or threading.Condition(self._lock)
                rest = None if limit is None else limit - time.monotonic()
                self._changed.wait_for(condition if alarm is None else lambda: over or condition(), rest)
        finally:
            if alarm is not None:
                alarm.close()
        return condition()

    def _finish(
        self,
        status: GoalStatus | None = None,
        *,
        accepted: bool | None = None,
        result: R | None = None,
        cause: str = "",
        error: Exception | None = None,
    ) -> None:
        """End the goal, once."""
        with self._lock:
            if self.done:
                return
            self.accepted = self.accepted if accepted is None else accepted
            self.status = self.status if status is None else status
            self.result_message, self.cause, self.error = result, cause, error
            self.done = True
            self._note_change()
        if self._mail:
            self._deliver()
        self._on_done(self)

    def _raise_status(self, status: GoalStatus) -> bool:
        """Go on to an active status; reordered messages never lead back."""
        if status.terminal or status <= self.status:
            return False
        self.status = status
        return True

    def _note_change(self) -> None:
        if self._changed is not None:
            self._changed.notify_all()
        if self._on_change is not None:
            self._mail.append((self._on_change, self))

    def _deliver(self) -> None:
        """Call the user's callbacks in order, with no lock held; the thread that runs them takes new ones, too."""
        with self._lock:
            if self._delivering or not self._mail:
                return
            self._delivering = True
            mail: tuple[Callable[[Any], object], object] | None = self._mail.popleft()
        try:
            while mail is not None:
                callback, news = mail
                try:
                    callback(news)
                except Exception:  # noqa: BLE001 - an error in one callback must not stop the others
                    _log.exception("%s: a callback of goal %s failed", self._target.name, self.goal_id)
                with self._lock:
                    mail = self._mail.popleft() if self._mail else None
                    self._delivering = mail is not None
        except BaseException:
            # An interrupt: the thread that has the next change calls the rest.
            self._delivering = False
            raise

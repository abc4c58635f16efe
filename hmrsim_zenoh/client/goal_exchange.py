"""The requests that keep a goal handle up to date over a transport that may lose any of them.

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
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Generic

from hmrsim.protocol.commands import CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import CancelResponse, GoalResponse, GoalStatus, ResultResponse
from hmrsim_zenoh.client.connection import message_of
from hmrsim_zenoh.client.goal_handle import F, GoalHandle, R
from hmrsim_zenoh.errors import GoalRejectedError, GoalTimeout, ResultExpired, SimulatorGone
from hmrsim_zenoh.wire.envelopes import UnreadableError

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Commands
    from hmrsim_zenoh.client.link import Link
    from hmrsim_zenoh.client.lockstep import Lockstep

_log = logging.getLogger(__name__)

_DUPLICATE = "duplicate_goal_id"
_CANCEL_REJECTED = 1

# Zenoh's default query timeout is 10 s; a mission takes longer.
_FOR_EVER = 1e6
# The timeout of one attempt at a request that is answered at once. The request is idempotent.
_ONE_TRY = 3.0
_FIRST_PAUSE = 0.05
_MAX_PAUSE = 0.4
_PAUSE_FACTOR = 1.5


class GoalExchange(GoalHandle[R, F], Generic[R, F]):
    """A goal handle that sends, queries and cancels its goal and retries by itself."""

    def __init__(
        self,
        link: Link,
        lockstep: Lockstep | None,
        target: ActionTarget,
        command: SendGoal,
        *,
        on_feedback: Callable[[F], object] | None,
        on_change: Callable[[GoalHandle[R, F]], None] | None,
        on_done: Callable[[GoalExchange[R, F]], None],
    ) -> None:
        super().__init__(target.name, command.goal_id or "", on_feedback=on_feedback, on_change=on_change)
        self._link = link
        self._lockstep = lockstep
        self._commands: Commands = lockstep or link.connection
        self._target = target
        self._command = command
        self._on_done = on_done
        self._adopt = False
        self._ended_before: GoalStatus | None = None
        self._read_result = True
        self._sends = 0
        self._replied = False
        self._deadline = 0.0
        self._pause = _FIRST_PAUSE
        self._result_asked = False
        self._cancel_wanted = False
        self._cancel_sent = False

    def start(self, *, adopt: bool = False, read_result: bool = True) -> None:
        """Send the goal and request its result right after it; *adopt* a goal that was sent before under this id."""
        self._adopt = adopt
        self._read_result = read_result
        # In lockstep no reply comes before time advances.
        self._deadline = math.inf if self._commands.ordered else self._patience_from_now()
        self._send_goal()
        # Whether the goal is an older one has to be known before its result arrives.
        if not self._adopt:
            self._ask_result()

    def execute(self, *, read_result: bool = True) -> None:
        """Send the goal and request its result in one query."""
        self._read_result = read_result
        self._deadline = self._patience_from_now()
        self._sends = 1
        self._result_asked = True
        self._link.rounds.add(self._send_unanswered)
        self._link.connection.execute(
            self._target,
            self._command,
            timeout=_FOR_EVER,
            on_answer=self._on_execution,
            on_end=self._on_execution_end,
            read=read_result,
        )

    def _on_execution(self, answer: Answer) -> None:
        if not self._replied:
            self._replied = True
            self._on_goal_answer(answer)
        else:
            self._on_result_answer(True, answer)

    def _on_execution_end(self) -> None:
        """Request what is missing: the reply was lost, or the server of this robot has no such key."""
        if not self._done:
            self._link.worker.after(0.0, self._go_on_without_execution)

    def _go_on_without_execution(self) -> None:
        if self._accepted:
            self._on_result_answer(True, None)
        else:
            with self._lock:
                self._result_asked = False
            self._send_goal()

    def _send_unanswered(self) -> None:
        if not self._replied:
            self._send_goal()

    def cancel(self) -> None:
        """Request the goal's cancellation and return at once."""
        self._cancel_wanted = True
        self._cancel_if_due()

    def fail(self, error: Exception) -> None:
        """Fail the goal with an error."""
        if self._fail(error):
            self._on_done(self)

    def _send_goal(self) -> None:
        if self._done or self._accepted:
            return
        patience = self._deadline - time.monotonic()
        if patience <= 0:
            self._give_up()
            return
        self._sends += 1
        timeout = min(patience, _ONE_TRY)
        self._commands.send(self._target, self._command, self._on_goal_answer, timeout=timeout)

    def _on_goal_answer(self, answer: Answer) -> None:
        if answer is None:
            self._deadline = min(self._deadline, self._patience_from_now())
            self._again(self._send_goal)
            return
        if not isinstance(answer, GoalResponse):
            self.fail(answer)
        elif answer.accepted:
            self._on_accepted(GoalStatus.ACCEPTED)
        elif answer.reason == _DUPLICATE and (self._adopt or self._sends > 1):
            # An earlier attempt arrived. At the first attempt the id is another client's, or of an earlier process.
            status = GoalStatus.UNKNOWN if answer.status is None else answer.status
            self._found = status if self._adopt else None
            self._ended_before = status if status.terminal else None
            self._on_accepted(status)
        else:
            reason = answer.reason or "rejected"
            if self._fail(GoalRejectedError(reason, answer.error_code, answer.error_msg), rejected=True):
                self._on_done(self)

    def _on_accepted(self, status: GoalStatus) -> None:
        if self._accept(status):
            self._pause = _FIRST_PAUSE
            if not self._result_asked:
                self._ask_result()
            if self._cancel_wanted:
                self._cancel_if_due()

    def _patience_from_now(self) -> float:
        return time.monotonic() + self._link.acknowledge_timeout

    def _give_up(self) -> None:
        seconds = self._link.acknowledge_timeout
        # The goal may have been accepted nevertheless, and should not run without a client.
        self._commands.send(self._target, self._cancel, lambda _answer: None, timeout=_ONE_TRY)
        self.fail(
            GoalTimeout(f"{self._name}: no answer to goal {self._goal_id} in {seconds:g} s; the goal is given up")
        )

    def _ask_result(self) -> None:
        with self._lock:
            if self._done or self._result_asked:
                return
            self._result_asked = True
            accepted = bool(self._accepted)
        command = GetResult(self._target.robot, self._target.action.name, self._goal_id)
        then = partial(self._on_result_answer, accepted)
        read, ended = self._read_result, self._ended_before is not None
        self._commands.send(self._target, command, then, timeout=_FOR_EVER, read=read or ended, ended=ended)

    def _on_result_answer(self, asked_when_accepted: bool, answer: Answer) -> None:  # noqa: FBT001 - for partial
        with self._lock:
            self._result_asked = False
            accepted = self._accepted
        if self._done:
            return
        error: Exception | None = None
        if isinstance(answer, ResultResponse):
            if answer.status.terminal:
                error = self._take_end(answer)
                if error is None:
                    return
            elif self._ended_before is not None:
                self._expire(self._ended_before)
                return
            else:
                error = SimulatorGone(f"{self._name}: the simulator does not know goal {self._goal_id} any more")
        elif answer is not None:
            error = answer
        if not accepted:
            # Requested too early, or lost along with the goal: requested again when the goal is accepted.
            return
        if error is None:
            self._again(self._ask_result)
        elif not asked_when_accepted:
            self._ask_result()
        else:
            self.fail(error)

    def _take_end(self, answer: ResultResponse) -> Exception | None:
        """End with a result; return the error if it can't be read."""
        result: R | None = None
        if self._read_result or answer.status is not GoalStatus.SUCCEEDED:
            try:
                result = message_of(self._target.action.result, answer.result)
            except UnreadableError as error:
                return error
        if self._end(answer.status, result, answer.cause):
            self._on_done(self)
        return None

    def _expire(self, status: GoalStatus) -> None:
        error = ResultExpired(f"goal {self._goal_id} is {status.name}, but its result is not kept any longer")
        if self._fail(error, status=status):
            self._on_done(self)

    @property
    def _cancel(self) -> CancelGoal:
        return CancelGoal(self._target.robot, self._target.action.name, self._goal_id)

    def _cancel_if_due(self) -> None:
        with self._lock:
            possible = self._accepted or self._commands.ordered
            if not (self._cancel_wanted and possible) or self._cancel_sent or self._done:
                return
            self._cancel_sent = True
        self._send_cancel()

    def _cancel_refused(self) -> None:
        """Reset the cancellation, so that the caller may request it again."""
        with self._lock:
            self._cancel_wanted = self._cancel_sent = False

    def _send_cancel(self) -> None:
        if not self._done:
            self._commands.send(self._target, self._cancel, self._on_cancel_answer, timeout=_ONE_TRY)

    def _on_cancel_answer(self, answer: Answer) -> None:
        if self._done:
            return
        if answer is None:
            self._again(self._send_cancel)
            return
        if not isinstance(answer, CancelResponse):
            _log.warning("%s: goal %s can't be canceled: %s", self._name, self._goal_id, answer)
            self._cancel_refused()
        elif answer.return_code == _CANCEL_REJECTED:
            self._cancel_refused()
        elif answer.goals_canceling:
            self._progress(GoalStatus.CANCELING)
        # Otherwise the goal has ended, is canceling or is unknown, and its result will show which.

    def _wait(self, condition: Callable[[], bool], timeout: float | None, *, at_once: bool = False) -> bool:
        if self._lockstep is None:
            return condition() or super()._wait(condition, timeout)
        limit = None if timeout is None else time.monotonic() + timeout
        if self._lockstep.drive(condition, timeout, until=self._lockstep.now if at_once else math.inf):
            return True
        return super()._wait(condition, None if limit is None else limit - time.monotonic())

    def _wait_within(self, condition: Callable[[], bool], timeout: float | None, sim_timeout: float) -> bool:
        limit = None if timeout is None else time.monotonic() + timeout
        left = self._lockstep.drive_within(condition, timeout, sim_timeout) if self._lockstep else sim_timeout
        if condition() or left <= 0.0:
            return condition()
        over = threading.Event()

        def ring() -> None:
            over.set()
            self._wake()

        alarm = self._link.alarm(left, ring)
        try:
            left_of_wall = None if limit is None else limit - time.monotonic()
            super()._wait(lambda: condition() or over.is_set(), left_of_wall)
        finally:
            alarm.close()
        return condition()

    def _again(self, step: Callable[[], None]) -> None:
        """Retry a step after a delay, while an answer is still possible."""
        if absence := self._link.absence():
            self.fail(absence)
            return
        self._link.worker.after(self._pause, step)
        self._pause = min(self._pause * _PAUSE_FACTOR, _MAX_PAUSE)

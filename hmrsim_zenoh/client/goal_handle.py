"""The client's handle of a goal."""

from __future__ import annotations

import logging
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from hmrsim.interfaces.message import Message
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import GoalTimeout

R = TypeVar("R", bound=Message)
F = TypeVar("F", bound=Message)

_log = logging.getLogger(__name__)


class GoalHandle(ABC, Generic[R, F]):
    """A goal that was sent, and its status. Any thread may read it and wait for it.

    A goal ends in one of three ways: with a terminal *status* and its *result_message*; rejected, *accepted* is
    False and *error* says why; or failed, *error* says why and the robot's state is unknown.

    Callbacks run one at a time, in order, mostly in Zenoh's thread, in lockstep in the waiting thread. They must be
    quick and must not block.
    """

    def __init__(
        self,
        name: str,
        goal_id: str,
        *,
        on_feedback: Callable[[F], object] | None,
        on_change: Callable[[GoalHandle[R, F]], None] | None,
    ) -> None:
        self._name = name
        self._goal_id = goal_id
        self._on_feedback = on_feedback
        self._on_change = on_change
        # Taken several times for each change; a condition does it in Python.
        self._lock = threading.RLock()
        self._changed: threading.Condition | None = None
        self._status = GoalStatus.UNKNOWN
        self._accepted: bool | None = None
        self._error: Exception | None = None
        self._result: R | None = None
        self._cause = ""
        self._feedback: F | None = None
        self._done = False
        self._found: GoalStatus | None = None
        # The callbacks that are due, with their arguments.
        self._mail: deque[tuple[Callable[[Any], object], object]] = deque()
        self._delivering = False

    def __repr__(self) -> str:
        """Return the goal's action, id and status."""
        failed = ", failed" if self._error else ""
        return f"<goal {self._goal_id} of {self._name}: {self._status.name}{failed}>"

    @property
    def goal_id(self) -> str:
        """The goal's id, 32 hex digits."""
        return self._goal_id

    @property
    def status(self) -> GoalStatus:
        """The goal's status as last received; UNKNOWN until it is accepted."""
        return self._status

    @property
    def accepted(self) -> bool | None:
        """Return whether the goal was accepted; None until that is known."""
        return self._accepted

    @property
    def adopted(self) -> bool:
        """Return whether the handle follows a goal that the simulator knew already; see `ActionClient.send_goal`."""
        return self._found is not None

    @property
    def found(self) -> GoalStatus | None:
        """The status of the goal when it was adopted; None if this client sent it."""
        return self._found

    @property
    def error(self) -> Exception | None:
        """Why the goal was rejected or failed, or has no result; else None."""
        return self._error

    @property
    def result_message(self) -> R | None:
        """The result; None until the status is terminal, and if it was not to be read."""
        return self._result

    @property
    def cause(self) -> str:
        """Why it was aborted or canceled, as an identifier such as ``preempted``; empty if it was not, or unknown."""
        return self._cause

    @property
    def feedback(self) -> F | None:
        """The latest feedback; None without *on_feedback*, since only then the client subscribes to feedback."""
        return self._feedback

    @property
    def done(self) -> bool:
        """Return whether the goal is final: terminal, rejected or failed."""
        return self._done

    def wait_accepted(self, timeout: float | None = None) -> None:
        """Wait until the goal is accepted.

        Raises:
            GoalRejectedError: It was rejected.
            SimulatorNotFound, SimulatorGone, RequestError, ClientClosed: It failed.
            GoalTimeout: Acceptance is unknown after *timeout* seconds, or the simulator's answer timed out.
        """
        if not self._wait(lambda: self._accepted is not None or self._done, timeout, at_once=True):
            raise GoalTimeout(f"{self._name}: no answer to goal {self._goal_id} after {timeout:g} s; it may go on")
        with self._lock:
            if not self._accepted and self._error is not None:
                raise self._error

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
        if sim_timeout is None:
            ended = self._wait(lambda: self._done, timeout)
        else:
            ended = self._wait_within(lambda: self._done, timeout, sim_timeout)
        if not ended:
            given = ((timeout, "s"), (sim_timeout, "simulated s"))
            after = " or ".join(f"{seconds:g} {unit}" for seconds, unit in given if seconds is not None)
            raise GoalTimeout(f"{self._name}: no result of goal {self._goal_id} after {after}; it goes on")
        with self._lock:
            if self._error is not None:
                raise self._error
            if self._result is None:
                raise AssertionError
            return self._result

    @abstractmethod
    def cancel(self) -> None:
        """Request the goal's cancellation and return at once.

        A request made before acceptance is sent upon acceptance. Further requests do nothing.
        """

    def _wait(self, condition: Callable[[], bool], timeout: float | None, *, at_once: bool = False) -> bool:  # noqa: ARG002 - for subclasses that advance time
        """Wait for a condition and return whether it holds; *at_once* if that takes no simulated time."""
        with self._lock:
            # Made for the first thread that waits: mostly none does.
            self._changed = self._changed or threading.Condition(self._lock)
            return self._changed.wait_for(condition, timeout)

    def _wait_within(self, condition: Callable[[], bool], timeout: float | None, sim_timeout: float) -> bool:  # noqa: ARG002 - as above
        """Wait for a condition, for so many wall and so many simulated seconds at most; return whether it holds."""
        return self._wait(condition, timeout)

    def _wake(self) -> None:
        """Wake the waiting threads to check their conditions."""
        with self._lock:
            if self._changed is not None:
                self._changed.notify_all()

    def _accept(self, status: GoalStatus) -> bool:
        with self._lock:
            if self._done or self._accepted:
                return False
            self._accepted = True
            # A duplicate may have got further; if it has ended, get_result reports the status with the result.
            self._raise_status(GoalStatus.ACCEPTED if status.terminal else status)
            self._note_change()
        if self._mail:
            self._deliver()
        return True

    def _progress(self, status: GoalStatus) -> bool:
        with self._lock:
            if self._done or not self._raise_status(status):
                return False
            self._note_change()
        self._deliver()
        return True

    def take_feedback(self, feedback: F) -> None:
        """Process feedback for this goal."""
        with self._lock:
            if self._done or self._on_feedback is None:
                return
            self._feedback = feedback
            self._mail.append((self._on_feedback, feedback))
            # Feedback implies EXECUTING. The client subscribes to no status topic, so feedback may be the first sign.
            if self._accepted and self._raise_status(GoalStatus.EXECUTING):
                self._note_change()
        self._deliver()

    def _end(self, status: GoalStatus, result: R | None, cause: str = "") -> bool:
        with self._lock:
            if self._done:
                return False
            self._accepted = True
            self._cause = cause
            self._status = status
            self._result = result
            self._done = True
            self._note_change()
        if self._mail:
            self._deliver()
        return True

    def _fail(self, error: Exception, *, rejected: bool = False, status: GoalStatus | None = None) -> bool:
        with self._lock:
            if self._done:
                return False
            self._accepted = False if rejected else self._accepted
            self._status = self._status if status is None else status
            self._error = error
            self._done = True
            self._note_change()
        self._deliver()
        return True

    def _raise_status(self, status: GoalStatus) -> bool:
        """Go on to an active status; reordered messages never lead back."""
        if status.terminal or status <= self._status:
            return False
        self._status = status
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
                    _log.exception("%s: a callback of goal %s failed", self._name, self._goal_id)
                with self._lock:
                    mail = self._mail.popleft() if self._mail else None
                    self._delivering = mail is not None
        except BaseException:
            # An interrupt: the thread that has the next change calls the rest.
            self._delivering = False
            raise

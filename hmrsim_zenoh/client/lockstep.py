"""A client's participation in lockstep: requests go with the next advance, and events come with its grant.

A goal handle sees an ordinary transport, which answers ``send_goal``, ``cancel_goal`` and ``get_result``. Simulated
time stands still while no thread waits: a thread that waits for a condition advances time until it holds.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.errors import HmrsimError
from hmrsim.protocol.answers import ResultResponse
from hmrsim.protocol.commands import CancelGoal
from hmrsim.protocol.conditions import Unwatch
from hmrsim.protocol.goal import made_goal_id
from hmrsim.protocol.outputs import FeedbackSent
from hmrsim_zenoh.client.conditions import Watched
from hmrsim_zenoh.client.participant import Participant, Wish
from hmrsim_zenoh.client.threads import SingleFlight
from hmrsim_zenoh.errors import Dropped, Idle, RequestError, SimulationEnded, SimulatorGone, SimulatorNotFound

if TYPE_CHECKING:
    from hmrsim.protocol.commands import GetResult, SendGoal
    from hmrsim.protocol.outputs import GoalChanged, Granted
    from hmrsim_zenoh.client.conditions import Condition
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Listener
    from hmrsim_zenoh.client.link import Link
    from hmrsim_zenoh.client.participant import Kind

_LAST_WORDS: Final = 1.0
_LATEST: Final = 2.0**31
"""The largest time in seconds that ROS can represent."""
_RESULT: Final[tuple[Kind, ...]] = ("result",)
_RESULT_OR_FEEDBACK: Final[tuple[Kind, ...]] = ("result", "feedback")
_SURE: Final = 2
"""Idle grants in a row after which waiting fails: all participants were told and none sent a command."""


class _Given(NamedTuple):
    """A command for the next advance, the callback for its answer, and its action, if it has one."""

    command: Any
    then: Callable[[Answer], None]
    target: ActionTarget | None = None


class Lockstep:
    """A client's participation in a simulator's lockstep. Any thread may use it; one at a time advances time.

    Raises:
        RequestError: The simulator refuses this participant, for instance as the name is taken.
        SimulatorNotFound, SimulatorGone, ClientClosed: There is no simulator to join.
    """

    ordered = True
    """Whether requests arrive in the order in which they are sent."""

    def __init__(self, link: Link, name: str) -> None:
        self._link = link
        self._name = name
        self._participant = Participant(link, name)
        self._connection = link.connection
        self._turns = SingleFlight()
        self._lock = threading.Lock()
        self._untils: list[float | None] = []
        self._queue: list[_Given] = []
        self._sent: list[_Given] = []
        # The callbacks for results, by the goal's id.
        self._results: dict[str, list[Callable[[Answer], None]]] = {}
        self._watched: dict[str, Callable[[RequestError | None], None]] = {}
        self._watches = 0
        self._undelivered: deque[Callable[[], None]] = deque()
        self._listeners: dict[tuple[str, str], tuple[ActionTarget, Listener]] = {}
        self._told: FeedbackSent | None = None
        self._idle = 0
        self._over = False
        self._error: Exception | None = None
        self._goals = self._participant.join()

    @property
    def now(self) -> float:
        """The current simulated time, in seconds."""
        return self._participant.now

    @property
    def over(self) -> bool:
        """Whether lockstep is over: time moves by itself now, or the run has ended."""
        return self._over

    @property
    def takes_part(self) -> bool:
        """Whether simulated time waits for this client."""
        return not self._over and self._error is None

    @property
    def ended(self) -> SimulationEnded | None:
        """The end of the run; None while it goes on."""
        return self._error if isinstance(self._error, SimulationEnded) else None

    @property
    def lost(self) -> bool:
        """Whether the client was dropped, or the simulator is gone; the client may then join again."""
        return self._error is not None

    def look_at_time(self) -> None:
        """Ask for the time, which may have gone back; nothing happens while an advance is pending, which will tell."""
        if self._turns.held:
            self._look_at_time()
        else:
            self._turns.run(self._look_at_time, lambda: self._over or self.lost, _LAST_WORDS)

    def _look_at_time(self) -> bool:
        if not self._participant.asking:
            self._participant.look_at_time()
        return True

    def next_goal_id(self) -> str:
        """Return the id of the next goal: the simulator would generate the same."""
        with self._lock:
            self._goals += 1
            return made_goal_id(self._name, self._goals)

    def send_goal(
        self, target: ActionTarget, command: SendGoal, then: Callable[[Answer], None], *, timeout: float
    ) -> None:
        """Send a goal with the next advance; *timeout* does not count, as time stands still."""
        if not self._give(target, command, then):
            self._connection.send_goal(target, command, then, timeout=timeout)

    def cancel(
        self, target: ActionTarget, command: CancelGoal, then: Callable[[Answer], None], *, timeout: float
    ) -> None:
        """Cancel goals with the next advance; *timeout* does not count."""
        if not self._give(target, command, then):
            self._connection.cancel(target, command, then, timeout=timeout)

    def get_result(
        self,
        target: ActionTarget,
        command: GetResult,
        then: Callable[[Answer], None],
        *,
        timeout: float,
        read: bool = True,
    ) -> None:
        """Register for the event with a goal's result."""
        with self._lock:
            if not self._over:
                self._results.setdefault(command.goal_id, []).append(then)
                return
        self._connection.get_result(target, command, then, timeout=timeout, read=read)

    def look_up(
        self, target: ActionTarget, command: GetResult, then: Callable[[Answer], None], *, timeout: float
    ) -> None:
        """Request the result of a goal that ended before, without an event to come; the next advance ends at once."""
        if not self._give(target, command, then):
            self._connection.look_up(target, command, then, timeout=timeout)

    def listen(self, target: ActionTarget, listener: Listener) -> None:
        """Subscribe a listener to the feedback of an action; time stops at feedback while the listener wants it."""
        with self._lock:
            if not self._over:
                self._listeners[target.robot, target.action.name] = target, listener
                return
        self._connection.listen(target, listener)

    def _give(
        self, target: ActionTarget, command: SendGoal | CancelGoal | GetResult, then: Callable[[Answer], None]
    ) -> bool:
        """Queue a command for the next advance; return whether there will be one."""
        with self._lock:
            if self._over:
                return False
            if denial := self._connection.denial(target, command):
                self._undelivered.append(partial(then, denial))
            else:
                self._queue.append(_Given(command, then, target))
        return True

    def drive(self, condition: Callable[[], bool], timeout: float | None, *, at_once: bool = False) -> bool:
        """Advance time until a condition holds; return whether it does.

        It does not if that takes more than *timeout* wall seconds, or lockstep is over.

        Args:
            condition: The condition to wait for.
            timeout: Wall seconds; None for no limit.
            at_once: Whether to apply the pending commands without advancing time.

        Raises:
            Idle: The condition can't become true.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: Likewise.
        """
        return self._drive(condition, timeout, self.now if at_once else None)

    def drive_within(self, condition: Callable[[], bool], timeout: float | None, sim_timeout: float) -> float:
        """Advance time until a condition holds, by so many simulated seconds at most; return how many are left.

        Raises:
            Idle: The condition can't become true.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: Likewise.
        """
        end = self.now + sim_timeout
        self._drive(lambda: condition() or self.now >= end, timeout, min(end, _LATEST))
        return end - self.now

    def sleep(self, seconds: float) -> bool:
        """Advance by simulated seconds; return whether they have passed, since lockstep may end before.

        Raises:
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
            ValueError: The time is out of range.
        """
        begin = self.now
        end = begin + seconds
        if not 0 <= end < _LATEST:
            raise ValueError(f"{seconds} s is no time to sleep for; it is {begin} s now")
        # Time went back: the simulation was reset, and the old deadline is void.
        return self._drive(lambda: not begin <= self.now < end, None, end)

    def advance(
        self,
        *,
        until: float | None = None,
        wake: Sequence[Kind] = ("result",),
        report: Sequence[Kind] = (),
        timeout: float = math.inf,
    ) -> bool:
        """Send the pending commands and advance once; callbacks run before this returns.

        Time stands where the commands are more than `MAX_BYTES`; the next call sends the rest.

        Args:
            until: Simulated seconds; None for as far as anything is scheduled.
            wake: The events that stop time: results, feedback and status changes of any goal.
            report: Further events to report.
            timeout: Wall seconds.

        Returns:
            Whether time was granted; if not, the next call waits for the same grant, whatever its arguments.

        Raises:
            Idle: Nothing is scheduled, for the second time in a row.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
        """
        limit = time.monotonic() + timeout
        return self._turns.run(lambda: self._step(until, wake, report, limit), self._ended, timeout)

    def watch(self, condition: Condition, then: Callable[[RequestError | None], None]) -> Callable[[], None]:
        """Stop time as soon as a condition is met, in any advance; return a function that withdraws the condition.

        Args:
            condition: It is sent with the next advance, and may hold already.
            then: Called once, when it is met; with an error if it can't be watched, or when lockstep ends first.
        """
        with self._lock:
            self._watches += 1
            name = str(self._watches)
            self._watched[name] = then
            self._queue.append(_Given(Watched(name, condition), partial(self._note_watched, name)))

        def unwatch() -> None:
            with self._lock:
                if self._watched.pop(name, None) is not None:
                    self._queue.append(_Given(Unwatch(name), lambda _answer: None))

        return unwatch

    def wait_for(
        self, *conditions: Condition, until: float | None = None, timeout: float | None = None
    ) -> list[Condition]:
        """Advance time until one of the conditions is met; return those that are met by then.

        Args:
            conditions: What to wait for.
            until: Simulated seconds at which to stop anyway.
            timeout: Wall seconds.

        Raises:
            RequestError: A condition can't be watched.
            Idle: Nothing is scheduled that could bring it about.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
        """
        ended: list[tuple[Condition, RequestError | None]] = []
        takes_back = [self.watch(each, partial(_note_end, ended, each)) for each in conditions]
        end = math.inf if until is None else until
        try:
            self._drive(lambda: bool(ended) or self.now >= end, timeout, until)
        finally:
            for take_back in takes_back:
                take_back()
        for _, error in ended:
            if error is not None:
                raise error
        return [condition for condition, _ in ended]

    def close(self) -> None:
        """Leave; cancels that are not applied yet are sent on their own keys."""
        with self._lock:
            if self._over:
                return
            self._over = True
        self._turns.look()
        self._participant.leave()
        # A thread that waits for a grant has one now.
        with suppress(HmrsimError):
            self._turns.run(self._take_last, lambda: False, _LAST_WORDS)
        self._flush([*self._sent, *self._queue])

    def _take_last(self) -> bool:
        return self._participant.asking and self._step(None, (), (), time.monotonic() + _LAST_WORDS)

    def _flush(self, unsent: Sequence[_Given]) -> None:
        answered: SimpleQueue[Answer] = SimpleQueue()
        canceled = 0
        for command, then, target in unsent:
            if target is None:
                continue
            if isinstance(command, CancelGoal):
                canceled += 1
                self._connection.cancel(target, command, answered.put, timeout=_LAST_WORDS)
            else:
                then(RequestError("the client was closed before the goal could be sent"))
        with suppress(Empty):
            for _ in range(canceled):
                answered.get(timeout=_LAST_WORDS)

    def _drive(self, condition: Callable[[], bool], timeout: float | None, until: float | None) -> bool:
        limit = math.inf if timeout is None else time.monotonic() + timeout
        self._untils.append(until)
        try:
            while not (condition() or self._ended()) and time.monotonic() < limit:
                self._turns.run(
                    lambda: self._step(self._least_until(), self._kinds(), (), limit),
                    lambda: condition() or self._ended(),
                    limit - time.monotonic(),
                )
        finally:
            self._untils.remove(until)
        return condition()

    def _ended(self) -> bool:
        """Return whether lockstep is over.

        Raises:
            Dropped, SimulatorNotFound, SimulatorGone: Lockstep ended with this error.
        """
        if self._error is not None:
            raise self._error
        return self._over

    def _least_until(self) -> float | None:
        return min((until for until in list(self._untils) if until is not None), default=None)

    def _kinds(self) -> tuple[Kind, ...]:
        for _, listener in list(self._listeners.values()):
            if listener.wanted:
                return _RESULT_OR_FEEDBACK
        return _RESULT

    def _step(self, until: float | None, wake: Sequence[Kind], report: Sequence[Kind], limit: float) -> bool:
        """Request an advance, unless one is pending, and process the grant; return whether there was one."""
        if self._undelivered:
            # The thread that ran the callbacks was interrupted in one.
            self._hand_out()
            return True
        if not self._participant.asking:
            with self._lock:
                # What is left there was taken from the queue, and an interrupt came before it was asked for.
                waiting = [*self._sent, *self._queue]
                most = self._connection.fitting([each.command for each in waiting])
                self._sent, self._queue = waiting[:most], waiting[most:]
            until = until if most == len(waiting) else self.now
            commands = tuple([each.command for each in self._sent])
            self._participant.ask(Wish(until, frozenset(wake), frozenset(report), commands))
        try:
            grant = self._participant.take(limit - time.monotonic())
        except (Dropped, SimulatorNotFound, SimulatorGone) as error:
            self._error = error
            self._link.fail(error)
            raise
        except RequestError as error:
            if not self._sent:
                raise
            self._undelivered.extend(partial(each.then, error) for each in self._sent)
            self._sent = []
            self._hand_out()
            return True
        if grant is not None:
            self._deliver(grant)
        return grant is not None

    def _deliver(self, grant: Granted) -> None:
        """Run the callbacks of a grant. Only its acceptance, the first of them, makes that the next one is taken."""
        applied = self._sent[: len(grant.accepted)]
        idle = self._idle + 1 if grant.reason == "idle" and not applied else 0
        calls: list[Callable[[], None]] = [partial(self._accept, grant, idle=idle)]
        for each, answer in zip(applied, grant.accepted, strict=True):
            calls.append(partial(each.then, answer))
        for kind, _, event in grant.events:
            calls.append(partial(self._tell, kind, event))
        if grant.met:
            calls += [partial(self._end_watch, name, None) for name in grant.met]
        self._undelivered.extend(calls)
        self._hand_out()
        if grant.over and self._error is None:
            self._error = SimulationEnded(f"the run is over: {grant.over}")
            self._link.fail(self._error)
            self._end_watches(str(self._error))
        elif grant.reason == "end" and not self._over:
            self._end()
        if self._idle >= _SURE:
            raise Idle("nothing is scheduled in the simulation and no participant acts: time can't go on")

    def _hand_out(self) -> None:
        """Run callbacks. After an interrupt the next step runs the rest, from the interrupted one on."""
        while self._undelivered:
            try:
                self._undelivered[0]()
            except KeyboardInterrupt:
                raise
            except BaseException:
                self._undelivered.popleft()
                raise
            self._undelivered.popleft()

    def _accept(self, grant: Granted, *, idle: int) -> None:
        self._idle = idle
        with self._lock:
            # The simulation was reset before the rest of the commands was applied.
            self._sent, self._queue = [], [*self._sent[len(grant.accepted) :], *self._queue]
        self._participant.accept(grant)

    def _tell(self, kind: str, event: GoalChanged | FeedbackSent) -> None:
        if isinstance(event, FeedbackSent):
            if event is not self._told:
                self._told = event
                if listening := self._listeners.get((event.robot, event.action)):
                    listening[1].take(event.goal_id, event.feedback)
        elif kind == "result" and event.result is not None:
            ended = ResultResponse(event.status, event.result, event.cause)
            for then in tuple(self._results.get(event.goal_id, ())):
                then(ended)
            self._results.pop(event.goal_id, None)

    def _note_watched(self, name: str, answer: Answer) -> None:
        if isinstance(answer, RequestError):
            self._end_watch(name, answer)

    def _end_watch(self, name: str, error: RequestError | None) -> None:
        if then := self._watched.pop(name, None):
            then(error)

    def _end(self) -> None:
        """Go on without lockstep: unanswered requests count as lost, so that goal handles send them again."""
        with self._lock:
            self._over = True
            unanswered = [*chain.from_iterable(self._results.values()), *(each.then for each in self._queue)]
            self._results, self._queue = {}, []
        self._participant.close()
        for target, listener in self._listeners.values():
            self._connection.listen(target, listener)
        for then in unanswered:
            then(None)
        self._end_watches("lockstep is over; subscribe to the topic")

    def _end_watches(self, why: str) -> None:
        for name in list(self._watched):
            self._end_watch(name, RequestError(why))


def _note_end(
    ended: list[tuple[Condition, RequestError | None]], condition: Condition, error: RequestError | None
) -> None:
    ended.append((condition, error))

"""A client's participation in lockstep: commands go with the next advance, and events come with its grant.

A goal handle sends its commands as over any other connection. A thread that waits for a condition advances time until
it holds; while no thread waits, simulated time stands still. Time moves only when every participant has requested an
advance. If a reply is lost, the same request is sent again and gets the same answer.
"""

from __future__ import annotations

import math
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain
from operator import itemgetter
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final, Literal

from hmrsim.errors import HmrsimError
from hmrsim.protocol.commands import Advance, CancelGoal, GetResult
from hmrsim.protocol.goal import ResultResponse, made_goal_id
from hmrsim.protocol.outputs import FeedbackSent, Granted
from hmrsim.protocol.time import LOCKSTEP, Join, Joined, Leave, ReadTime, TimeState
from hmrsim.protocol.topics import Unwatch
from hmrsim_zenoh.client.connection import Watched
from hmrsim_zenoh.errors import (
    Dropped,
    Idle,
    NameTaken,
    RequestError,
    SimulationEnded,
    SimulatorGone,
    SimulatorNotFound,
)

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import GoalChanged
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Call, Condition, GoalCommand
    from hmrsim_zenoh.client.link import Link

Kind = Literal["result", "feedback", "status"]
"""Kinds of events that can wake a participant or be reported to it."""
Kinds = frozenset[Kind]

_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")

# Zenoh's default query timeout is 10 s; other participants may take longer, and a pause may last.
_FOR_EVER: Final = 1e6
_ONE_TRY: Final = 3.0
_PAUSE: Final = 0.1
_LAST_WORDS: Final = 1.0
_LATEST: Final = 2.0**31
"""The largest time in seconds that ROS can represent."""
_NO_KINDS: Final[Kinds] = frozenset()
_RESULT: Final[Kinds] = frozenset({"result"})
_RESULT_OR_FEEDBACK: Final[Kinds] = frozenset({"result", "feedback"})
_SURE: Final = 2
"""Idle grants in a row after which waiting fails: every participant knew that time stood still, and sent no command."""

_Queued = tuple[Any, Callable[["Answer"], None], "ActionTarget | None"]
"""A command for the next advance, the callback for its answer, and its action, if it has one."""
_COMMAND: Final = itemgetter(0)


class Lockstep:
    """A client's participation in a simulator's lockstep. Any thread may use it; one at a time advances time.

    Attributes:
        now: Simulated seconds of the last grant.
        over: Whether lockstep is over: time moves by itself now, or the run has ended.
        takes_part: Whether simulated time waits for this client.

    Raises:
        NameTaken: Another participant has this name.
        RequestError: The simulator refuses this participant, for the reason in the text.
        SimulatorNotFound, SimulatorGone, ClientClosed: There is no simulator to join.
    """

    ordered = True
    """Whether requests arrive in the order in which they are sent."""

    def __init__(self, link: Link, name: str) -> None:
        self._link = link
        self._name = name
        self._connection = link.connection
        self._secured = link.connection.enclave is not None
        self._turns = _Turns()
        self._lock = threading.Lock()
        self._untils: list[float] = []
        self._queue: list[_Queued] = []
        self._sent: list[_Queued] = []
        # The callbacks for results, by the goal's id.
        self._results: dict[str, list[Callable[[Answer], None]]] = {}
        self._watched: dict[str, Callable[[RequestError | None], None]] = {}
        self._watches = 0
        self._undelivered: deque[Callable[[], None]] = deque()
        self._listeners: dict[tuple[str, str], ActionTarget] = {}
        self._latest: FeedbackSent | None = None
        self._idle = 0
        self.over = False
        self.takes_part = True
        self._error: Exception | None = None
        self.now = 0.0
        self._epoch = 0
        self._withdraw: Callable[[], None] | None = None
        # The pending advance, and its call once it was sent.
        self._request: Advance | None = None
        self._call: Call | None = None
        self._resynchronized = False
        self._failure: Exception | None = None
        joined = self._join()
        self._epoch, self.now, self._goals = joined.epoch, joined.now, joined.goals

    @property
    def ended(self) -> SimulationEnded | None:
        """The end of the run; None while it goes on."""
        return self._error if isinstance(self._error, SimulationEnded) else None

    @property
    def lost(self) -> bool:
        """Return whether the client was dropped, or the simulator is gone; the client may then join again."""
        return self._error is not None

    def look_at_time(self) -> None:
        """Ask for the time, which may have gone back, unless the answer to a pending advance will report it."""

        def look() -> bool:
            state = self._state() if self._request is None else None
            if state is not None and state.clock == LOCKSTEP and state.now < self.now:
                self._epoch, self.now = state.epoch, state.now
            return True

        if self._turns.held:
            look()
        else:
            self._turns.run(look, lambda: not self.takes_part, _LAST_WORDS)

    def next_goal_id(self) -> str:
        """Return the id of the next goal, which is the one that the simulator would generate."""
        with self._lock:
            self._goals += 1
            return made_goal_id(self._name, self._goals)

    def send(
        self,
        target: ActionTarget,
        command: GoalCommand,
        then: Callable[[Answer], None],
        *,
        timeout: float,
        read: bool = True,
        ended: bool = False,
    ) -> None:
        """Send a command with the next advance, or wait for the event that reports a result.

        The timeout does not count, as time stands still.
        """
        with self._lock:
            if not self.over:
                if isinstance(command, GetResult) and not ended:
                    self._results.setdefault(command.goal_id, []).append(then)
                elif self._secured and (denial := self._connection.denial(target, command)):
                    self._undelivered.append(partial(then, denial))
                else:
                    self._queue.append((command, then, target))
                return
        self._connection.send(target, command, then, timeout=timeout, read=read, ended=ended)

    def listen(self, target: ActionTarget) -> None:
        """Subscribe to the feedback of an action; time stops at feedback while its target wants it."""
        with self._lock:
            if not self.over:
                self._listeners[target.robot, target.action.name] = target
                return
        self._connection.listen(target)

    def drive(self, condition: Callable[[], bool], timeout: float | None, *, until: float = math.inf) -> bool:
        """Advance time until a condition holds; return whether it does.

        It does not if that takes more than *timeout* wall seconds, or lockstep is over.

        Args:
            condition: The condition to wait for.
            timeout: Wall seconds; None for no limit.
            until: Simulated seconds of each advance at most; if they have passed, pending commands are still applied.

        Raises:
            Idle: The condition can't become true.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
        """
        timeout, met = math.inf if timeout is None else timeout, False

        def ends() -> bool:
            # The same as `_ended`, without its call, as this happens twice for each goal.
            nonlocal met
            if met := condition():
                return True
            if self._error is not None:
                raise self._error
            return self.over

        self._untils.append(until)
        try:
            self._turns.run(partial(self._step, time.monotonic() + timeout), ends, timeout, again=True)
        finally:
            self._untils.remove(until)
        return met or condition()

    def drive_within(self, condition: Callable[[], bool], timeout: float | None, sim_timeout: float) -> float:
        """Advance time until a condition holds, by at most *sim_timeout* simulated seconds; return how many are left.

        Raises:
            Idle: The condition can't become true.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
        """
        end = self.now + sim_timeout
        self.drive(lambda: condition() or self.now >= end, timeout, until=min(end, _LATEST))
        return end - self.now

    def sleep(self, seconds: float) -> bool:
        """Advance time by some simulated seconds; return whether they have passed, since lockstep may end before.

        Raises:
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
            ValueError: The time is out of range.
        """
        begin = self.now
        end = begin + seconds
        if not 0 <= end < _LATEST:
            raise ValueError(f"can't sleep for {seconds} s; it is {begin} s now")
        # Time went back: the simulation was reset, and the old deadline is void.
        return self.drive(lambda: not begin <= self.now < end, None, until=end)

    def advance(
        self,
        *,
        until: float | None = None,
        wake: Sequence[Kind] = ("result",),
        report: Sequence[Kind] = (),
        timeout: float = math.inf,
    ) -> bool:
        """Send the pending commands and advance once; callbacks run before this returns.

        If the commands are more than `MAX_BYTES`, time does not move, and the next call sends the rest.

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
        wish = (math.inf if until is None else until, frozenset(wake), frozenset(report))
        step = partial(self._step, time.monotonic() + timeout, wish)
        return self._turns.run(step, self._ended, timeout)

    def watch(self, condition: Condition, then: Callable[[RequestError | None], None]) -> Callable[[], None]:
        """Stop time as soon as a condition is met, in any advance; return a function that withdraws the condition.

        Args:
            condition: The condition, which is sent with the next advance, and may hold already.
            then: Called once, when it is met; with an error if it can't be watched, or when lockstep ends first.
        """
        with self._lock:
            self._watches += 1
            name = str(self._watches)
            self._watched[name] = then
            self._queue.append((Watched(name, condition), partial(self._note_watched, name), None))

        def unwatch() -> None:
            with self._lock:
                if self._watched.pop(name, None) is not None:
                    self._queue.append((Unwatch(name), lambda _answer: None, None))

        return unwatch

    def wait_for(
        self, *conditions: Condition, until: float | None = None, timeout: float | None = None
    ) -> list[Condition]:
        """Advance time until one of the conditions is met; return those that are met by then.

        Args:
            conditions: The conditions to wait for.
            until: Simulated seconds at which to stop anyway.
            timeout: Wall seconds.

        Raises:
            RequestError: A condition can't be watched.
            Idle: Nothing is scheduled that could bring it about.
            Dropped, SimulatorNotFound, SimulatorGone, ClientClosed: This client can no longer advance time.
        """
        ended: list[tuple[Condition, RequestError | None]] = []
        takes_back = [self.watch(each, partial(lambda *end: ended.append(end), each)) for each in conditions]
        end = math.inf if until is None else until
        try:
            self.drive(lambda: bool(ended) or self.now >= end, timeout, until=end)
        finally:
            for take_back in takes_back:
                take_back()
        for _, error in ended:
            if error is not None:
                raise error
        return [condition for condition, _ in ended]

    def close(self) -> None:
        """Leave lockstep; requests to cancel that were not applied yet are sent on their own keys."""
        with self._lock:
            if self.over:
                return
            self.over, self.takes_part = True, False
        self._turns.look()
        if self._withdraw is not None:
            self._connection.call(Leave(self._name), timeout=_LAST_WORDS).wait(_LAST_WORDS)
        self._leave()
        # A thread that waits for a grant has one now.
        with suppress(HmrsimError):
            self._turns.run(self._take_last, lambda: False, _LAST_WORDS)
        if unsent := [*self._sent, *self._queue]:
            self._flush(unsent)

    def _take_last(self) -> bool:
        pending = self._request is not None
        return pending and self._step(time.monotonic() + _LAST_WORDS, (math.inf, _NO_KINDS, _NO_KINDS))

    def _flush(self, unsent: Sequence[_Queued]) -> None:
        answered: SimpleQueue[Answer] = SimpleQueue()
        canceled = 0
        for command, then, target in unsent:
            if target is None:
                continue
            if isinstance(command, CancelGoal):
                canceled += 1
                self._connection.send(target, command, answered.put, timeout=_LAST_WORDS)
            else:
                then(RequestError("the client was closed before the goal could be sent"))
        with suppress(Empty):
            for _ in range(canceled):
                answered.get(timeout=_LAST_WORDS)

    def _ended(self) -> bool:
        """Return whether lockstep is over.

        Raises:
            Dropped, SimulatorNotFound, SimulatorGone: Lockstep ended with this error.
        """
        if self._error is not None:
            raise self._error
        return self.over

    def _kinds(self) -> Kinds:
        wanted = any(target.wanted for target in list(self._listeners.values()))
        return _RESULT_OR_FEEDBACK if wanted else _RESULT

    def _step(self, limit: float, wish: tuple[float, Kinds, Kinds] | None = None) -> bool:
        """Request an advance, unless one is pending, and process the grant; return whether there was one.

        Args:
            limit: Until when to wait for the grant, by the wall clock.
            wish: How far to advance, the events that stop time, and further events to report; None for as much as all
                waiting threads allow.
        """
        if self._undelivered:
            # The thread that ran the callbacks was interrupted in one.
            self._hand_out()
            return True
        if self._request is None:
            until, wake, report = wish or (min(self._untils), self._kinds() if self._listeners else _RESULT, _NO_KINDS)
            with self._lock:
                # After an interrupt, commands that were taken from the queue before may not have been sent.
                waiting = [*self._sent, *self._queue]
                commands = [*map(_COMMAND, waiting)]
                most = self._connection.fitting(commands) if len(commands) > 1 else 1
                self._sent, self._queue = waiting[:most], waiting[most:]
            if most < len(commands):
                until = self.now
            self._resynchronized, self._call = False, None
            self._request = Advance(self._name, self._epoch, until, wake, report, tuple(commands[:most]))
        try:
            grant = self._take(limit)
        except (Dropped, SimulatorNotFound, SimulatorGone) as error:
            self._fail(error)
            raise
        except RequestError as error:
            if not self._sent:
                raise
            self._undelivered.extend(partial(then, error) for _, then, _ in self._sent)
            self._sent = []
            self._hand_out()
            return True
        if grant is not None:
            self._deliver(grant)
        return grant is not None

    def _deliver(self, grant: Granted) -> None:
        """Run the callbacks of a grant; the first one accepts it, so that the next advance may be requested."""
        applied = self._sent[: len(grant.accepted)]
        idle = self._idle + 1 if grant.reason == "idle" and not applied else 0
        calls: list[Callable[[], None]] = [partial(self._accept, grant, idle=idle)]
        for (_, then, _), answer in zip(applied, grant.accepted, strict=True):
            calls.append(partial(then, answer))
        for kind, _, event in grant.events:
            calls.append(partial(self._report, kind, event))
        if grant.met:
            calls += [partial(self._end_watch, name, None) for name in grant.met]
        self._undelivered.extend(calls)
        self._hand_out()
        if grant.over and self._error is None:
            why = f"the run is over: {grant.over}"
            self._fail(SimulationEnded(why))
            self._end_watches(why)
        elif grant.reason == "end" and not self.over:
            self._end()
        if self._idle >= _SURE:
            raise Idle("nothing is scheduled in the simulation and no participant acts: time can't go on")

    def _fail(self, error: Exception) -> None:
        self._error, self.takes_part = error, False
        self._link.fail(error)

    def _hand_out(self) -> None:
        """Run the pending callbacks; after an interrupt the next step runs the rest, from the interrupted one on."""
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
        # The next advance may be requested.
        self._epoch, self.now, self._request = grant.epoch, grant.now, None

    def _report(self, kind: str, event: GoalChanged | FeedbackSent) -> None:
        if isinstance(event, FeedbackSent):
            if event is not self._latest:
                self._latest = event
                if listening := self._listeners.get((event.robot, event.action)):
                    listening.take(event.goal_id, event.feedback)
        elif kind == "result" and event.result is not None and (waiting := self._results.get(event.goal_id)):
            ended = ResultResponse(event.status, event.result, event.cause)
            for then in tuple(waiting):
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
            self.over, self.takes_part = True, False
            unanswered = [*chain.from_iterable(self._results.values()), *(then for _, then, _ in self._queue)]
            self._results, self._queue = {}, []
        self._leave()
        for target in self._listeners.values():
            self._connection.listen(target)
        for then in unanswered:
            then(None)
        self._end_watches("lockstep is over; subscribe to the topic")

    def _end_watches(self, why: str) -> None:
        for name in list(self._watched):
            self._end_watch(name, RequestError(why))

    def fail(self, error: Exception) -> None:
        """Fail the pending request; from any thread."""
        self._failure = error
        if (call := self._call) is not None:
            call.give_up()

    def _join(self) -> Joined:
        answer: Answer = None
        self._link.enter(self.fail)
        try:
            self._withdraw = self._connection.announce(self._name)
            command = Join(self._name, token=self._connection.token())
            while answer is None:
                self._call = call = self._connection.call(command, timeout=_ONE_TRY)
                self._answered(call, math.inf)
                answer = call.answer
        finally:
            if not isinstance(answer, Joined):
                self._leave()
        if isinstance(answer, Joined):
            return answer
        raise NameTaken(str(answer), answer.details) if _field(answer) == "name" else answer

    def _leave(self) -> None:
        """Leave lockstep without a request to the simulator."""
        self._link.leave(self.fail)
        withdraw, self._withdraw = self._withdraw, None
        if withdraw is not None and not self._link.closed:
            withdraw()

    def _take(self, limit: float) -> Granted | None:
        """Return the grant; None if it has not come by *limit* of the wall clock, and the caller may wait again.

        An interrupt loses nothing: this returns the same grant until it was accepted.

        Raises:
            Dropped: The simulator goes on without this participant.
            RequestError: The simulator can't read the request and applied none of it.
            SimulatorNotFound, SimulatorGone, ClientClosed: There will be no answer.
        """
        while (request := self._request) is not None:
            call = self._call
            if call is None:
                call = self._call = self._connection.call(request, timeout=_FOR_EVER)
            if (call.answer is None or self._failure is not None) and not self._answered(
                call, limit - time.monotonic()
            ):
                break
            answer = call.answer
            if isinstance(answer, Granted):
                return answer
            if isinstance(answer, RequestError):
                if (grant := self._grant_after(answer, request)) is not None:
                    return grant
                self._resynchronized = True
            self._call = None
        return None

    def _answered(self, call: Call, timeout: float) -> bool:
        """Return whether the answer came in time; if it is None, it was lost, and the request may be repeated."""
        if self._failure is not None:
            raise self._failure
        if not call.wait(timeout):
            return False
        if self._failure is not None:
            raise self._failure
        if call.answer is None:
            if absence := self._link.absence():
                raise absence
            # A simulator in this process answers at once or not at all.
            if not (self._connection.in_process and self._link.present):
                time.sleep(_PAUSE)
        return True

    def _grant_after(self, error: RequestError, request: Advance) -> Granted | None:
        """Return the last grant if time moves by itself now; None to repeat the request after a reset.

        Raises:
            Dropped: The simulator goes on without this participant.
            RequestError: The error has another cause.
        """
        field, state = _field(error), self._state()
        if state is not None and state.clock != LOCKSTEP:
            return Granted(state.epoch, state.now, "end")
        if state is not None and field == "epoch" and not self._resynchronized:
            # The simulation was reset before this request.
            if state.now < self.now:
                # The request was meant for the old time; an advance without commands shows the new one first.
                request = request._replace(until=state.now, commands=())
            self._request = request._replace(epoch=state.epoch)
            self._epoch, self.now = state.epoch, state.now
            return None
        self._request = None
        raise Dropped(str(error)) if state is not None and field == "participant" else error

    def _state(self) -> TimeState | None:
        call = self._connection.call(ReadTime(), timeout=_ONE_TRY)
        call.wait(_ONE_TRY)
        return call.answer if isinstance(call.answer, TimeState) else None


class _Turns:
    """Lets one thread at a time do work that several threads wait for."""

    def __init__(self) -> None:
        # Acquired directly where no thread has to be woken: a condition does it in Python.
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._waiting = 0
        self._who: int | None = None

    @property
    def held(self) -> bool:
        """Return whether it is the calling thread's turn."""
        return self._who == threading.get_ident()

    def run(
        self, work: Callable[[], bool], needless: Callable[[], bool], timeout: float, *, again: bool = False
    ) -> bool:
        """Wait for the calling thread's turn, and call *work*; an interrupt at any time ends the turn.

        Args:
            work: Called unless it became needless, or the time was over, before this thread's turn came.
            needless: Returns whether there is nothing left to wait for; called after each turn of another thread.
            timeout: Wall seconds.
            again: Whether to work again, in further turns, until *needless* or *work* returns False.

        Returns:
            What *work* returned last; False if it became needless, or the time was over.

        Raises:
            RuntimeError: The calling thread has the turn already: a callback waits for an event that comes after it.
        """
        me = threading.get_ident()
        if self._who == me:
            if needless():
                return False
            raise RuntimeError("a callback can't wait for what happens after it")
        limit = time.monotonic() + timeout
        try:
            while True:
                with self._lock:
                    if needless() or (again and time.monotonic() >= limit):
                        return False
                    if self._who not in (None, me) and not self._free(needless, limit - time.monotonic()):
                        return False
                    self._who = me
                worked = work()
                if not (worked and again):
                    return worked
                if self._waiting:
                    with self._lock:
                        self._who = None
                        self._changed.notify_all()
        finally:
            # Without a further call, in which an interrupt could come.
            if self._who == me:
                with self._lock:
                    self._who = None
                    if self._waiting:
                        self._changed.notify_all()

    def _free(self, needless: Callable[[], bool], timeout: float) -> bool:
        """Wait until it is this thread's turn; return False if that is needless by then, or the time is over."""
        self._waiting += 1
        try:
            patience = min(timeout, threading.TIMEOUT_MAX)
            return self._changed.wait_for(lambda: self._who is None or needless(), patience) and not needless()
        finally:
            self._waiting -= 1

    def look(self) -> None:
        """Wake all waiting threads to check whether their turn is still needed."""
        with self._lock:
            if self._waiting:
                self._changed.notify_all()


def check_name(name: str) -> None:
    """Check a participant's name.

    Raises:
        ValueError: The name is invalid.
    """
    if not _NAME.fullmatch(name):
        raise ValueError(
            f"{name!r} is not a valid participant name; expected letters, digits and underscores, no digit first"
        )


def _field(error: RequestError) -> object:
    """Return the invalid field of a request; None if the error does not name one."""
    return error.details[0].get("field") if error.details else None

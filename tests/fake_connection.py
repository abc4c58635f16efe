"""A connection without a simulator: the test plays the robots, and other requests are answered by a script."""

from __future__ import annotations

import json
from collections import defaultdict

from pydantic_core import to_json

from hmrsim.actions import registry
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.simulation_interfaces import GetNamedPoses
from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import ZERO_ID, CancelResponse, GoalEntry, GoalResponse, GoalStatus, ResultResponse
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged, Granted
from hmrsim.protocol.time import HasLeft, Join, Joined, Leave
from hmrsim_zenoh.client.connection import Ask, Connection, Read, ReadInfo
from hmrsim_zenoh.errors import RequestError

LOST = None
"""The answer to a request whose reply is lost."""
HELD = object()
"""The answer to a request that is not answered yet."""


class FakeGoal:
    """A goal that a client has sent, which does what the test says.

    Attributes:
        command: The client's command.
        sent: How often it was sent.
        canceled: Whether its cancellation was requested.
        when_canceled: Called then.
    """

    def __init__(self, connection, command):
        self.robot, self.action, self.goal_id = command.robot, registry()[command.action], command.goal_id
        sent, self.command = command.goal, command
        self.goal = sent if isinstance(sent, Message) else self.action.goal.model_validate_json(to_json(sent))
        self.sent, self.canceled = 0, False
        self.when_canceled = lambda: None
        self.asked = defaultdict(list)  # the functions that take the answers, by the kind of command
        self._connection = connection
        self._answers = {}

    @property
    def done(self):
        """Return whether it has ended."""
        return GetResult in self._answers or self.accepted is False

    @property
    def accepted(self):
        """Return whether it was accepted; None before it was answered."""
        return getattr(self._answers.get(SendGoal), "accepted", None)

    def take(self, command, then):
        """Take one of the client's commands about this goal."""
        kind = type(command)
        self.asked[kind].append(then)
        self._answer(kind)
        self.sent += kind is SendGoal
        if kind is CancelGoal:
            self.canceled = True
            self.when_canceled()

    def answer(self, kind, answer):
        """Answer the commands of this kind so, those that have come and those that will."""
        self._answers[kind] = answer
        self._answer(kind)

    def lose(self, kind):
        """Lose the answers to the commands of this kind that have come."""
        asked, self.asked[kind] = self.asked[kind], []
        for then in asked:
            then(LOST)

    def accept(self):
        self.answer(SendGoal, GoalResponse(True, self.goal_id, 0))

    def reject(self, reason="not_ready", message="", status=None):
        self.answer(SendGoal, GoalResponse(False, self.goal_id, 0, reason, 1, message, status))

    def is_known(self, status):
        """Report that the robot has had the goal since an earlier run of the client."""
        self.reject("duplicate_goal_id", status=status)

    def expire(self, status):
        """Report how a goal that it has had ended, without its result."""
        self.is_known(status)
        self.answer(GetResult, ResultResponse(GoalStatus.UNKNOWN, self.action.result()))

    def cancel(self):
        """Report that it is being canceled."""
        self.answer(CancelGoal, CancelResponse(0, (GoalEntry(self.goal_id, 0, GoalStatus.CANCELING),)))

    def feed(self, **fields):
        feedback = self.action.feedback(**fields)
        self._connection.report("feedback", FeedbackSent(self.robot, self.action.name, self.goal_id, feedback))

    def end(self, status, result=None, cause=""):
        """End it; it is accepted before."""
        if self.accepted is None:
            self.accept()
        result = result or self.action.result()
        self.answer(GetResult, ResultResponse(status, result, cause))
        change = GoalChanged(0, self.robot, self.action.name, self.goal_id, status, None, result, cause)
        self._connection.report("result", change)

    def succeed(self):
        self.end(GoalStatus.SUCCEEDED)

    def abort(self, code, message):
        self.end(GoalStatus.ABORTED, self.action.failure(code, message))

    def end_canceled(self):
        self.end(GoalStatus.CANCELED, self.action.failure(0, "canceled"))

    def fail(self, error):
        """Answer everything with an error."""
        for kind in (SendGoal, GetResult, CancelGoal):
            self.answer(kind, error)

    def _answer(self, kind):
        while kind in self._answers and self.asked[kind]:
            self.asked[kind].pop(0)(self._answers[kind])


class FakeCall:
    """A request for whose answer a client waits.

    Attributes:
        ended: Whether there is an answer, or will be none.
    """

    def __init__(self, answer):
        self.ended = answer is not HELD
        self.answer = answer if self.ended else None

    def wait(self, _timeout):
        return self.ended

    def give_up(self):
        self.ended = True


class FakeConnection(Connection):
    """A connection whose other end is the test; its clients call back in the thread of the test.

    Attributes:
        goals: The goals that came, in order.
        robot: Called with each new goal.
        requests: All other requests that came, in order.
        calls: The calls whose answers the clients wait for.
        participants: The announced participants.
        followers: The functions that follow whether the simulator is alive.
        script: The answers to other requests by their types; the last one is repeated. A function is called with the
            request; `LOST` and `HELD` are answers, too.
        latest: The messages of later subscribers with history, by key.
        listeners: The receivers of feedback, by robot and action.
        later: The deferred calls of clients, with their delays.
        now: The time of the next grant.
    """

    in_process = True

    def __init__(self):
        self.goals = []
        self.robot = lambda _goal: None
        self.requests = []
        self.calls = []
        self.participants = []
        self.script = {
            ReadInfo: [{"clock": "realtime"}],
            Ask: [GetNamedPoses.Response()],
            Read: [RequestError("nobody publishes here")],
            Join: [Joined("client", 0, 0.0, 0)],
            Leave: [HasLeft("client")],
            Advance: [self.grant],
        }
        self.later = []
        self.now = 0.0
        self._epoch = 0
        self._events = []
        self._alive = True
        self.followers = []
        self.listeners = {}
        self._subscribers = {}
        self.latest = {}

    def run_later(self):
        """Run the deferred calls, as if their time had come."""
        due, self.later = self.later, []
        for _, call in due:
            call()

    def vanish(self):
        """Report that the simulator has gone."""
        self._alive = False
        for on_change in self.followers:
            on_change(False)

    def publish(self, key, payload):
        """Publish a message, which is also the first one of later subscribers with history."""
        self.latest[key] = payload
        if key in self._subscribers:
            self._subscribers[key](key, payload)

    def clock(self, now):
        """Publish the time in seconds."""
        sec, nanosec = divmod(round(now * 1e9), 1_000_000_000)
        self.publish("hmrsim/_world/clock", json.dumps({"clock": {"sec": sec, "nanosec": nanosec}}).encode())

    def report(self, kind, event):
        """Report an event: with the next grant, or feedback to its listener."""
        self._events.append((kind, 0, event))
        if kind == "feedback" and (listener := self.listeners.get((event.robot, event.action))):
            listener.take(event.goal_id, event.feedback)

    def grant(self, advance):
        """Apply the commands of an advance, and grant what has happened; time goes on to where the client wants it."""
        answers = [LOST] * len(advance.commands)
        for number, command in enumerate(advance.commands):
            self._take(command, lambda answer, at=number: answers.__setitem__(at, answer))
        events, self._events = tuple(self._events), []
        if not events and advance.until < 1e9:
            self.now = max(self.now, advance.until)
        self._epoch += 1
        return Granted(self._epoch, self.now, "event" if events else "until", tuple(answers), events)

    def send(self, _target, command, then, **_options):
        self._take(command, then)

    def execute(self, _target, command, *, on_answer, **_options):
        self._take(command, on_answer)
        self._take(GetResult(command.robot, command.action, command.goal_id), on_answer)

    def listen(self, target):
        self.listeners[target.robot, target.action.name] = target

    def unlisten(self):
        self.listeners.clear()

    def call(self, command, **_options):
        self.requests.append(command)
        script = self.script[type(command)]
        answer = script.pop(0) if len(script) > 1 else script[0]
        self.calls.append(FakeCall(answer(command) if callable(answer) else answer))
        return self.calls[-1]

    def ask(self, request, then, **_options):
        then(self.call(request).answer)

    def subscribe(self, key, take, *, history=False):
        self._subscribers[key] = take
        if history and key in self.latest:
            take(key, self.latest[key])
        return lambda: self._subscribers.pop(key, None)

    def token(self):
        return "client"

    def announce(self, name):
        self.participants.append(name)
        return lambda: self.participants.remove(name)

    def follow(self, on_change):
        self.followers.append(on_change)
        on_change(self._alive)
        return lambda: self.followers.remove(on_change)

    def look(self, on_alive, then, **_options):
        if self._alive:
            on_alive()
        then()

    def worker(self):
        return self

    def after(self, delay, call, **_options):
        """Keep the call for `run_later`."""
        self.later.append((delay, call))

    def close(self):
        self.later.clear()

    def _take(self, command, then):
        if isinstance(command, CancelGoal) and command.goal_id == ZERO_ID:
            for goal in self.goals:
                if (goal.robot, goal.action.name) == (command.robot, command.action):
                    goal.take(command, lambda _answer: None)
            then(CancelResponse(0))
            return
        # A goal that is sent again is the same command; another goal may have its id.
        known = [each for each in self.goals if each.goal_id == command.goal_id]
        new = isinstance(command, SendGoal) and not any(each.command is command for each in known)
        if new:
            known.append(FakeGoal(self, command))
            self.goals.append(known[-1])
        known[-1].take(command, then)
        if new:
            self.robot(known[-1])

"""A small world, and simulations of it that run in virtual time."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.message import Message
from hmrsim.protocol.commands import CallService, SendGoal
from hmrsim.protocol.outputs import Answered, EventStamped, FeedbackSent, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.services import registry as services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.timing.lockstep import Lockstep
from hmrsim.trace.writer import Header, Trace
from hmrsim.world.model import World

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from hmrsim.actions import AnyAction
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink

SMALL_WORLD = {
    "name": "small",
    "bounds": [0, 0, 20, 10],
    "waypoints": {"home": [1, 2], "door": [5, 2], "shelf": [9, 2], "far": [15, 8], "island": [15, 2]},
    "lanes": [["home", "door"], ["door", "shelf"], {"from": "far", "to": "island"}],
    "walls": [[[12, 0], [12, 10]], {"solid": [[6, 4], [8, 4], [8, 6], [6, 6]]}],
    "items": {
        "parcel": {"at": [9, 2.3], "weight": 0.2},
        "anvil": {"at": [9, 1.8], "weight": 80.0},
        "letter": {"at": [1, 2.1]},
    },
    "robot_types": {"nurse": {"components": {"claw": {"reach": 0.9, "max_weight": 1.0}}}},
    "robots": {
        "wall_e": {"type": "nurse", "at": "home"},
        "eve": {"type": "nurse", "at": "shelf"},
        "cart": {"type": "carrier", "at": "door"},
    },
    "remap": {"navigate_to_pose/wall_e": "wall_e/navigate_to_pose", "wall_e/grab": "wall_e/pickup"},
}


A, B, C, D = (letter * 32 for letter in "abcd")
"""Ids of goals."""


def send(action: str, goal_id: str | None = A, robot: str = "wall_e", reply_to: object = None, **goal: Any) -> SendGoal:
    """Return the command that sends a goal with these fields; the answer goes to its id unless said otherwise."""
    message = registry()[action].goal.model_validate(goal, strict=False)
    return SendGoal(robot, action, message, goal_id, reply_to or goal_id)


def at(x: float, y: float = 0.0, yaw: float = 0.0) -> dict[str, Any]:
    """Return the plain values of a stamped pose."""
    orientation = {"z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    return {"pose": {"position": {"x": float(x), "y": float(y)}, "orientation": orientation}}


def go(x: float, y: float = 0.0, goal_id: str | None = A, robot: str = "wall_e", reply_to: object = None) -> SendGoal:
    """Return the command that sends a robot to a point."""
    return send("navigate_to_pose", goal_id, robot, reply_to, pose=at(x, y))


def wait(seconds: float, goal_id: str | None = A, robot: str = "wall_e", reply_to: object = None) -> SendGoal:
    """Return the command that makes a robot stand still."""
    return send("wait", goal_id, robot, reply_to, time=Duration.from_seconds(seconds))


def as_message(event: FeedbackSent) -> Message:
    """Return the feedback as a strictly validated message of its action."""
    if isinstance(event.feedback, Message):
        return event.feedback
    return registry()[event.action].feedback.model_validate_json(json.dumps(event.feedback, allow_nan=False))


@dataclass
class Log:
    """A sink that records all events with their simulated times."""

    topics: frozenset[Topic] = frozenset(Topic)
    events: list[tuple[float, Output]] = field(default_factory=list)
    simulator: Simulator | None = None

    def emit(self, output: Output) -> None:
        """Record an event with its time."""
        self.events.append((self.simulator.now if self.simulator else 0.0, output))

    def wants(self, topic: Topic) -> bool:
        """Return whether the log listens to a topic."""
        return topic in self.topics

    def answers(self, reply_to: object) -> list[object]:
        """Return the answers to a command, in order."""
        return [event.answer for _, event in self.events if isinstance(event, Answered) and event.reply_to == reply_to]

    def answer(self, reply_to: object) -> object:
        """Return the one answer to a command."""
        (answer,) = self.answers(reply_to)
        return answer

    def goal_changes(self, goal_id: str) -> list[GoalChanged]:
        """Return the changes of a goal's status."""
        return [event for _, event in self.events if isinstance(event, GoalChanged) and event.goal_id == goal_id]

    def changes(self, goal_id: str) -> list[tuple[float, str]]:
        """Return the times and statuses that a goal went through."""
        return [
            (time, event.status.name)
            for time, event in self.events
            if isinstance(event, GoalChanged) and event.goal_id == goal_id
        ]

    def result(self, goal_id: str) -> object:
        """Return the result that a goal ended with."""
        (result,) = [
            event.result
            for _, event in self.events
            if isinstance(event, GoalChanged) and event.goal_id == goal_id and event.status.terminal
        ]
        return result

    def happened(self, kind: str) -> list[tuple[float, dict[str, object]]]:
        """Return the times and the JSON fields of the events of a kind."""
        return [
            (time, json.loads(json.dumps(event.fields)))
            for time, event in self.events
            if isinstance(event, EventStamped) and event.kind == kind
        ]

    def feedback(self, goal_id: str) -> list[tuple[float, object]]:
        """Return the times and the feedback of a goal."""
        return [
            (time, as_message(event))
            for time, event in self.events
            if isinstance(event, FeedbackSent) and event.goal_id == goal_id
        ]


@dataclass
class Run:
    """A simulation that takes commands at given times, and its trace."""

    log: Log
    simulator: Simulator
    trace: Trace
    written: list[str]

    def __call__(self, *commands: tuple[float, Command], until: float | None = None) -> Log:
        """Submit each command at its time, then run to the end or to *until*; return the log."""
        for at, command in commands:
            self.simulator.advance(at)
            self.simulator.submit(command)
        if until is None:
            self.simulator.run()
        else:
            self.simulator.advance(until)
        return self.log

    def lines(self) -> list[str]:
        """End the trace, and return its lines."""
        self.trace.close(self.simulator.now)
        return "".join(self.written).splitlines(keepends=True)

    def ask(self, service: str, request: object = None) -> object:
        """Call a service with a request in plain values; return the answer, or None if it is pending."""
        reply_to = object()
        message = services()[service].request.model_validate_json(json.dumps(request or {}))
        self.simulator.submit(CallService(service, message, reply_to))
        return next(iter(self.log.answers(reply_to)), None)


def simulate(
    world: object = None,
    *,
    topics: frozenset[Topic] = frozenset(Topic),
    sinks: Sequence[Sink] = (),
    watchers: Callable[[Simulator], Sequence[Sink]] = lambda _simulator: (),
    traced: bool = False,
    actions: Mapping[str, AnyAction] | None = None,
    **settings: Any,
) -> Run:
    """Return a simulation of a world that listens to *topics*, with a trace if it is *traced*."""
    model, log, written = World.model_validate(world or SMALL_WORLD), Log(topics), []
    asked = RunSettings(**{"strict": True, **settings})
    trace = Trace(Header.of(model, asked), written.append)
    heard = [log, *sinks, *([trace] if traced else [])]
    log.simulator = Simulator(model, asked, heard, watchers=watchers, actions=actions, services=services())
    return Run(log, log.simulator, trace, written)


def in_lockstep(
    world: object = None,
    *,
    topics: frozenset[Topic] = frozenset(Topic),
    traced: bool = False,
    **settings: Any,
) -> tuple[Run, Lockstep]:
    """Return a simulation of a world and its `Lockstep`, which gets *settings*."""
    made: list[Lockstep] = []

    def grant(simulator: Simulator) -> list[Lockstep]:
        made.append(Lockstep(simulator, **settings))
        return made

    run = simulate(world, topics=topics, traced=traced, watchers=grant)
    return run, made[0]

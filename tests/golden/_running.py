"""Runs of golden cases; the only module here that imports from inside the packages."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from py_trees.blackboard import Blackboard

from bt_controller.cli import main as bt_controller
from bt_controller.loading.trees import load
from bt_controller.running.runner import run_tree
from hmrsim.actions import registry as actions
from hmrsim.cli import main as hmrsim
from hmrsim.goals.script_orders import read_order
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.protocol.commands import CallService, CancelGoal, PlanAnswered, PlannerPresent, Read, SendGoal, Stop
from hmrsim.protocol.outputs import Answered, EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.services import registry as services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.simulation.snapshot import scene
from hmrsim.trace.replay import replay
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks import load_world
from hmrsim.world_checks.loading import world_of
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost
from hmrsim_zenoh.wire.encoding import event_payload
from hmrsim_zenoh.wire.session import SessionOptions

ROOT = Path(__file__).parents[2]


def traced_by_cli(folder, *arguments):
    """Return the trace of a command such as ``simulate WORLD`` in this process."""
    path = folder / "cli.jsonl"
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        hmrsim([*arguments, "--trace", str(path)])
    return path.read_text()


def traced_by_process(folder, *arguments):
    """Return the trace of a command in another process."""
    path = folder / "process.jsonl"
    _run(Path(sys.executable).with_name("hmrsim"), *arguments, "--trace", path)
    return path.read_text()


def report_of(folder, trace):
    """Return the output of ``hmrsim report --json`` for a trace."""
    path = folder / "reported.jsonl"
    path.write_text(trace)
    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()):
        hmrsim(["report", str(path), "--json"])
    return out.getvalue()


def last_scene(trace):
    """Return the last scene of a replayed trace."""
    seen = []
    outcome = replay(trace.splitlines(keepends=True), lambda simulator: seen.append(simulator) or ())
    assert outcome.difference is None, outcome.difference
    return scene(seen[0])


class Run:
    """A run in virtual time, without any network.

    Args:
        world: A world as in a file, or the name of a shipped one.
        changes: What is different in this run, by the key of the world.

    Attributes:
        answers: The answers to the commands, in plain values.
        events: The events for subscribers of ``_world/events``, including motions and routes, which no trace has.
    """

    def __init__(self, world, changes=None):
        plain = world
        if isinstance(world, str):
            plain = load_world(world).world.model_dump(mode="json", by_alias=True)
        world, settings = world_of({**plain, **(changes or {})}, "golden"), RunSettings()
        self._lines = []
        self._goals = {}
        self.answers = []
        self.events = []
        self._trace = Trace(Header.of(world, settings), self._lines.append)
        self._simulator = Simulator(world, settings, [self._trace, self], services=services())

    def wants(self, topic):
        """Return whether a topic has events; there are no samples here."""
        return topic in (Topic.EVENTS, Topic.MOTION)

    def emit(self, event):
        """Keep an event, or the answer to a command of a story."""
        if isinstance(event, (GoalChanged, EventStamped)):
            self.events.append(json.loads(event_payload(event)))
        elif isinstance(event, Answered) and isinstance(event.reply_to, str):
            self.answers.append({"at": self._simulator.now, "to": event.reply_to, "answer": _plain(event.answer)})

    def advance(self, until):
        """Advance to a time, unless the simulation is paused."""
        self._simulator.advance(until)

    def finish(self, until):
        """Run until the scripts have ended, or until a time."""
        self._simulator.run_scripts(until)

    def scene(self):
        return scene(self._simulator)

    def trace(self):
        """Return the trace, which ends now."""
        self._trace.close(self._simulator.now)
        return "".join(self._lines)

    def send(self, name, robot, order=None, action=None, goal=None):
        """Send a goal under a letter, as a line of a script or as an action with a goal in plain values."""
        goal_id = name * 32
        if order:
            read = read_order(order, self._simulator.world)
            action, message = read.action.name, read.goal
        else:
            known = actions().get(action)
            message = known and known.goal.model_validate_json(json.dumps(goal or {}))
        self._goals.setdefault(name, (robot, action, goal_id))
        self._simulator.submit(SendGoal(robot, action, message, goal_id, f"send {name}"))

    def cancel(self, name):
        self._simulator.submit(CancelGoal(*self._goals[name], reply_to=f"cancel {name}"))

    def call(self, service, request=None):
        """Call a service with a request in plain values."""
        message = services()[service].request.model_validate_json(json.dumps(request or {}))
        self._simulator.submit(CallService(service, message, f"call {service}"))

    def read(self, topic, robot="", action=""):
        """Return the latest message of a topic."""
        self._simulator.submit(Read(Topic(topic), robot, action, f"read {topic} {robot}"))

    def planner(self, present):
        """Declare or undeclare a planner."""
        self._simulator.submit(PlannerPresent(present))

    def plan(self, request, *points):
        """Answer a planner's request with points, or with a failure."""
        fields = points[-1] if isinstance(points[-1], dict) else {}
        points = () if fields else points
        poses = [{"pose": {"position": {"x": x, "y": y}}} for x, y in points]
        result = ComputePathToPose.Result.model_validate_json(json.dumps({"path": {"poses": poses}, **fields}))
        self._simulator.submit(PlanAnswered(request, result))

    def stop(self, reason):
        self._simulator.submit(Stop(reason))


@contextmanager
def _served(world):
    """Serve a world in lockstep; yield the endpoint and the pieces of the trace."""
    pieces = []
    options = SessionOptions(listen=("tcp/127.0.0.1:0",))
    loaded, settings = load_world(world), RunSettings(clock="lockstep", feedback_rate=2.0)
    trace = Trace(Header.of(loaded.world, settings), pieces.append)
    with Host(loaded, options, settings, sinks=[trace]) as host:
        host.start()
        yield host.endpoints[0], pieces
    trace.close(host.simulator.now)


def traced_tree(world, tree, robots):
    """Return the trace of a tree that ``bt-controller run`` runs in this process."""
    with _served(world) as (endpoint, pieces), redirect_stdout(io.StringIO()):
        code = bt_controller(["run", tree, "--robot", *robots, "--connect", endpoint])
    Blackboard.clear()
    assert code == 0, f"{tree} ended with {code}"
    return "".join(pieces)


def traced_tree_within(world, tree, robots):
    """Return the trace of a tree that runs in the simulator's process, without a network."""
    pieces = []
    loaded, settings = load_world(world), RunSettings(clock="lockstep", feedback_rate=2.0)
    trace = Trace(Header.of(loaded.world, settings), pieces.append)
    with LoopbackHost(loaded.world, settings, sinks=[trace]) as host:
        with Client(session=host.open_session(), name="bt_controller") as client:
            outcome = run_tree(client, load(tree), robots)
        host.stop()
    trace.close(host.simulator.now)
    Blackboard.clear()
    assert outcome.succeeded, outcome
    return "".join(pieces)


def traced_program(world, program):
    """Return the trace of a Python program that takes part in lockstep, in another process."""
    with _served(world) as (endpoint, pieces):
        _run(sys.executable, program, endpoint)
    return "".join(pieces)


def _run(*command):
    subprocess.run([*map(str, command)], cwd=ROOT, capture_output=True, check=True)


def _plain(answer: Any) -> Any:
    """Return an answer in plain values."""
    if isinstance(answer, Message):
        return answer.model_dump(mode="json", exclude_defaults=True)
    if hasattr(answer, "_asdict"):
        return {key: _plain(value) for key, value in answer._asdict().items()}
    if isinstance(answer, (list, tuple)):
        return [_plain(each) for each in answer]
    return getattr(answer, "value", answer)

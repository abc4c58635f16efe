"""Replay of a trace, without a network or a controller, to check that the run is reproduced.

The commands of the trace are submitted to a new simulation at the same times and in the same order; the
trace of that simulation is compared line by line. A truncated trace is compared up to its last line.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

import hmrsim
from hmrsim.actions import registry as actions
from hmrsim.diagnostics import dotted, shown
from hmrsim.engine.sim_time import end_of_instant
from hmrsim.errors import TraceError, WorldError
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.protocol import commands
from hmrsim.protocol.goal import Verdict
from hmrsim.services import registry as services
from hmrsim.settings.option import MAX_SECONDS
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.sinks import Sink

_CONTEXT: Final = 3
"""Lines that are shown before and after those that differ."""


@dataclass(frozen=True)
class Difference:
    """The first difference between trace and replay.

    Attributes:
        line: Its number in the trace, from 1.
        replay: The line of the replay; None when it has ended.
        before: The last lines that they have in common.
        after: The next lines of the trace.
    """

    line: int
    trace: str
    replay: str | None
    before: tuple[str, ...]
    after: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """The outcome of a replay.

    Attributes:
        lines: The number of identical lines.
        commands: How many of them are commands.
        sim_time: How far the replay went, in simulated seconds.
        complete: Whether the trace has its last line; a truncated trace does not.
        difference: The first difference; None when they are identical.
    """

    header: Header
    lines: int
    commands: int
    sim_time: float
    complete: bool
    difference: Difference | None


class _World(BaseModel):
    model_config = ConfigDict(strict=True)

    name: str
    hash: str
    definition: dict[str, Any]


class _HeaderLine(BaseModel):
    model_config = ConfigDict(strict=True)

    kind: str = Field(pattern="^header$")
    contract: int
    hmrsim: str
    seed: int
    seed_given: bool
    step_size: float = Field(ge=1e-9, le=MAX_SECONDS)
    run_id: str = ""
    world: _World


class _Line(BaseModel):
    """The fields that a replay needs of every line but the first."""

    model_config = ConfigDict(strict=True, extra="allow")

    kind: str
    stamp: Time
    command: str = ""
    by: str = ""


def replay(lines: Iterable[str], watchers: Callable[[Simulator], Sequence[Sink]] = lambda _simulator: ()) -> Outcome:
    """Replay a trace and compare.

    Args:
        lines: Those of the trace, with their ends. A last line without an end is incomplete, and is left out.
        watchers: Makes sinks for the simulation before it begins.

    Raises:
        TraceError: It is not a trace, or one of another version.
    """
    return _Replay((line[:-1] for line in lines if line.endswith("\n")), watchers).run()


class _Replay:
    """One run of a trace."""

    def __init__(self, lines: Iterator[str], watchers: Callable[[Simulator], Sequence[Sink]]) -> None:
        first = next(lines, "")
        self._lines = chain([first], lines)
        self._header = _header(first)
        try:
            world = world_of(dict(self._header.definition), "line 1: world")
        except WorldError as error:
            raise TraceError(str(error.problems[0])) from None
        seed = self._header.seed if self._header.seed_given else None
        settings = RunSettings(seed=seed, step_size=self._header.step_size, run_id=self._header.run_id)
        self._made: deque[str] = deque()
        self._trace = Trace(self._header, lambda text: self._made.extend(text.splitlines()))
        self._simulator = Simulator(world, settings, [self._trace], watchers=watchers, services=services())
        self._trace.flush()
        self._commands = 0

    def run(self) -> Outcome:
        """Compare all lines, or those before the first difference."""
        before: deque[str] = deque(maxlen=_CONTEXT)
        same, last, difference = 0, "", None
        for line in self._lines:
            made = self._next(line, same + 1)
            if made != line:
                after = tuple(islice(self._lines, _CONTEXT))
                difference = Difference(same + 1, line, made, tuple(before), after)
                break
            same, last = same + 1, line
            before.append(line)
        complete = difference is None and '"kind":"end"' in last
        return Outcome(self._header, same, self._commands, self._simulator.now, complete, difference)

    def _next(self, expected: str, number: int) -> str | None:
        """Return the replay's next line, where the trace has *expected*; None if there is none."""
        line = _parsed(expected, number) if number > 1 else None
        if line is not None and line.kind in ("command", "end") and not self._made:
            self._let_it_be(line)
            if not self._made:
                self._repeat(line, number)
        until = end_of_instant(line.stamp.to_nanoseconds() / NANOSECONDS) if line is not None else math.inf
        while not self._made and self._simulator.process_events(until, 1):
            self._trace.flush()
        return self._made.popleft() if self._made else None

    def _let_it_be(self, line: _Line) -> None:
        """Process all that is due when a command arrived, or until some of it is traced."""
        simulator = self._simulator
        at = line.stamp.to_nanoseconds() / NANOSECONDS
        while not self._made and simulator.process_events(end_of_instant(at), 1):
            self._trace.flush()
        if not self._made:
            simulator.advance_clock(at)

    def _repeat(self, line: _Line, number: int) -> None:
        """Submit the commands of the trace."""
        if line.kind == "end":
            self._trace.close(self._simulator.now)
            return
        self._commands += 1
        self._simulator.submit(_command(line, number), line.by)
        self._trace.flush()


def _header(line: str) -> Header:
    try:
        read = _HeaderLine.model_validate_json(line)
    except ValidationError:
        raise TraceError("line 1: no header of a trace; expected a file that was written with --trace") from None
    if read.contract != hmrsim.CONTRACT:
        raise TraceError(f"line 1: a trace of contract {read.contract}; this is contract {hmrsim.CONTRACT}")
    world = read.world
    content = (world.name, world.hash, world.definition)
    return Header(read.hmrsim, read.seed, read.seed_given, *content, read.step_size, read.run_id)


def _parsed(text: str, number: int) -> _Line:
    try:
        return _Line.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise TraceError(f"line {number}: {_said(first)}") from None


def _said(error: ErrorDetails) -> str:
    return ": ".join(filter(None, (dotted(error["loc"]), error["msg"])))


def _known_service(name: str) -> str:
    if name not in services():
        raise ValueError(f"no service {shown(name)}")
    return name


def _command(line: _Line, number: int) -> Command:
    """Return the command that a line stands for.

    Raises:
        TraceError: It stands for none, or is of a version that counted events.
    """
    if "after" in (line.model_extra or {}):
        raise TraceError(f"line {number}: a trace of an older version, which counts events; record the run again")
    if line.command not in _COMMANDS:
        raise TraceError(f"line {number}: no command {shown(line.command)}; there are {', '.join(_COMMANDS)}")
    try:
        return _COMMANDS[line.command].model_validate(line.model_extra).command()
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise TraceError(f"line {number}: {line.command}: {_said(first)}") from None


class _Recorded(BaseModel):
    """The fields of a command in a trace."""

    model_config = ConfigDict(strict=True)

    def command(self) -> Command:
        """Return the command to submit."""
        raise NotImplementedError


class _SendGoal(_Recorded):
    robot: str
    action: str
    goal: Any
    goal_id: str | None
    verdict: Annotated[Verdict, Field(strict=False)] = Verdict.REJECT

    def command(self) -> commands.SendGoal:
        action = actions().get(self.action)
        goal = None if action is None or self.goal is None else action.goal.model_validate_json(json.dumps(self.goal))
        return commands.SendGoal(self.robot, self.action, goal, self.goal_id, verdict=self.verdict)


class _GoalInfo(BaseModel):
    goal_id: str
    stamp: Any


class _CancelGoal(_Recorded):
    robot: str
    action: str
    goal_info: _GoalInfo

    def command(self) -> commands.CancelGoal:
        before = Time.model_validate_json(json.dumps(self.goal_info.stamp)).to_nanoseconds()
        return commands.CancelGoal(self.robot, self.action, self.goal_info.goal_id, before)


class _ChangeState(_Recorded):
    robot: str
    node: str
    actions: list[str]
    transition: int

    def command(self) -> commands.ChangeState:
        return commands.ChangeState(self.robot, self.node, tuple(self.actions), self.transition)


class _CallService(_Recorded):
    service: Annotated[str, AfterValidator(_known_service)]
    request: Any

    def command(self) -> commands.CallService:
        service = services()[self.service]
        return commands.CallService(service.name, service.request.model_validate_json(json.dumps(self.request)))


class _Participation(_Recorded):
    participant: str
    change: Literal["joined", "left", "dropped"]
    why: str

    def command(self) -> commands.Participation:
        return commands.Participation(self.participant, self.change, self.why)


class _PlannerPresent(_Recorded):
    present: bool

    def command(self) -> commands.PlannerPresent:
        return commands.PlannerPresent(self.present)


class _PlanAnswered(_Recorded):
    request: int
    result: Any

    def command(self) -> commands.PlanAnswered:
        return commands.PlanAnswered(
            self.request, ComputePathToPose.Result.model_validate_json(json.dumps(self.result))
        )


class _Stop(_Recorded):
    reason: str

    def command(self) -> commands.Stop:
        return commands.Stop(self.reason)


_COMMANDS: Final[dict[str, type[_Recorded]]] = {
    "send_goal": _SendGoal,
    "cancel_goal": _CancelGoal,
    "change_state": _ChangeState,
    "call_service": _CallService,
    "participation": _Participation,
    "planner_present": _PlannerPresent,
    "plan_answered": _PlanAnswered,
    "stop": _Stop,
}

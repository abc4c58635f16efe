"""The sections of a trace, each with a header and its own simulated time, and the commands in them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, NamedTuple

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import from_json

from hmrsim.actions import registry as actions
from hmrsim.diagnostics import dotted, shown
from hmrsim.errors import TraceError
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.nav2_msgs import ComputePathToPose
from hmrsim.protocol import commands
from hmrsim.protocol.goal import Verdict
from hmrsim.protocol.outputs import Restart
from hmrsim.services import registry as services

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from hmrsim.protocol.commands import Command

_MARK: Final = re.compile(r'"kind":\s*"header"')
"""Matches each header, and hardly any other line."""
_LISTED: Final = 10
"""The number of sections that an error lists."""


_CAUSES: Final[Mapping[str, str]] = {
    Restart.RESET: "the simulation was reset",
    Restart.TIME_RESET: "time was reset, robots and items stayed where they were",
    Restart.STOPPED: "the simulation was stopped",
    Restart.WORLD_LOADED: "a world was loaded",
}


class Section(NamedTuple):
    """A section of a trace.

    Attributes:
        number: Counted from 1.
        line: The number of its first line, from 1.
    """

    number: int
    line: int
    world: str


def restart_text(cause: str) -> str:
    """Return in words why a section began; an unknown cause is returned as it is, such as the first section's, ""."""
    return _CAUSES.get(cause, cause)


def may_begin_section(line: str) -> bool:
    """Return whether a line looks like a header, before it is parsed."""
    return _MARK.search(line) is not None


def begins_section(line: str) -> bool:
    """Return whether a line is a header."""
    return _header(line) is not None


def sections_of(lines: Iterable[str]) -> list[Section]:
    """Return the sections of a trace; a line that does not end with a line break is incomplete and ignored."""
    found: list[Section] = []
    for i, line in enumerate(lines, 1):
        if line.endswith("\n") and (header := _header(line)) is not None:
            world = header.get("world")
            name = world.get("name") if isinstance(world, dict) else ""
            found.append(Section(len(found) + 1, i, name if isinstance(name, str) else ""))
    return found


def check_section(lines: Iterable[str], number: int) -> None:
    """Check that a trace has a section.

    Raises:
        TraceError: There is no such section, or the lines are not a trace.
    """
    there = sections_of(lines)
    if not there:
        raise TraceError("line 1: no header of a trace; expected a file that was written with --trace")
    if number > len(there):
        named = [f"{each.number} from line {each.line} on ({shown(each.world)})" for each in there[:_LISTED]]
        more = f" and {len(there) - _LISTED} more" if len(there) > _LISTED else ""
        raise TraceError(f"no section {number}; there {'is' if len(there) == 1 else 'are'} {', '.join(named)}{more}")


def _header(line: str) -> dict[str, Any] | None:
    """Return the fields of a header; None if the line is not a header."""
    if not may_begin_section(line):
        return None
    try:
        found = from_json(line, allow_inf_nan=False)
    except ValueError:
        return None
    # The pattern may also match inside another line, such as a goal with these fields.
    return found if isinstance(found, dict) and found.get("kind") == "header" else None


class Line(BaseModel):
    """A line of a trace other than a header, with the fields that a replay needs."""

    model_config = ConfigDict(strict=True, extra="allow")

    kind: str
    stamp: Time
    command: str = ""
    by: str = ""


def line_of(text: str, number: int) -> Line:
    """Return a line of a trace as an object.

    Raises:
        TraceError: A field is missing or invalid.
    """
    try:
        return Line.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise TraceError(f"line {number}: {_error_text(first)}") from None


def _error_text(error: ErrorDetails) -> str:
    return ": ".join(filter(None, (dotted(error["loc"]), error["msg"])))


def _known_service(name: str) -> str:
    if name not in services():
        raise ValueError(f"no service {shown(name)}")
    return name


def command_of(line: Line, number: int) -> Command:
    """Return the command that a line contains.

    Raises:
        TraceError: The command is unknown or invalid, or the trace is of an older version.
    """
    if "after" in (line.model_extra or {}):
        raise TraceError(f"line {number}: a trace of an older version, which counts events; record the run again")
    if line.command not in _COMMANDS:
        raise TraceError(f"line {number}: no command {shown(line.command)}; there are {', '.join(_COMMANDS)}")
    try:
        return _COMMANDS[line.command].model_validate(line.model_extra).command()
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise TraceError(f"line {number}: {line.command}: {_error_text(first)}") from None


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

"""A run as lines of JSON: the external commands and the events, in order.

A trace can be replayed (`hmrsim.trace.replay`), and the same run has the same trace, byte for byte::

    {"contract":1,"hmrsim":"…","kind":"header","seed":7,…,"world":{"definition":{…},"hash":"…","name":"…"}}
    {"by":"nurses","command":"send_goal","goal":{…},…,"kind":"command","stamp":{"nanosec":1,"sec":0}}
    {"action":"wait","goal_id":"…","kind":"status","robot":"wall_e","stamp":{"nanosec":1,"sec":0},"status":1}
    {"kind":"end","stamp":{…}}

Where simulated time begins anew, another header begins a section, with its number, from 2, and the cause::

    {"cause":"reset","contract":1,"hmrsim":"…","kind":"header","section":2,"seed":7,…,"world":{…}}

Keys are sorted, times are whole nanoseconds of simulated time, and there is no wall time. Commands are written
unchanged, so that they can be submitted again; coordinates and other numbers of events are rounded to 1e-9, so that
the last bit of a processor's arithmetic does not matter. A command is applied after all that is due in its nanosecond,
so that its stamp and its place among the commands say all that a replay needs. Motion from lane to lane is left out: a
replay computes it again.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim import CONTRACT, __version__
from hmrsim.caches import LruCache
from hmrsim.engine.sim_time import stamp
from hmrsim.errors import WriteError, reason_of
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, values_of
from hmrsim.protocol import commands
from hmrsim.protocol.commands import UNRECORDED, without_receivers
from hmrsim.protocol.goal import Verdict
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic
from hmrsim.services import registry as services
from hmrsim.world.model import Derived
from hmrsim.world.writing import native_data
from hmrsim.world_checks.loading import world_hash

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.settings.run import RunSettings
    from hmrsim.world.model import World


_DIGITS: Final = 9
_BATCH: Final = 512
"""Lines that are buffered while no client waits for an answer."""
_KEPT_TEXTS: Final = 256
"""Results whose text is kept."""

_encode = json.JSONEncoder(sort_keys=True, separators=(",", ":"), allow_nan=False).encode
_encode_in_order = json.JSONEncoder(separators=(",", ":"), allow_nan=False).encode


@dataclass(frozen=True)
class Header:
    """The first line of a trace, or of a section of one.

    Attributes:
        seed_given: Whether it was given for the run, so that it stays when another world is loaded.
        definition: The world, as a native file has it.
        step_size: Simulated seconds of one step.
        run_id: An input to goal ids besides the seed; may be empty.
        contract: Version of the public interface.
        section: The number of the section, from 1.
        cause: Why the section began, one of `Restart`; empty for the first one.
    """

    version: str
    seed: int
    seed_given: bool
    name: str
    hash: str
    definition: Mapping[str, Any]
    step_size: float
    run_id: str = ""
    contract: int = CONTRACT
    section: int = 1
    cause: str = ""

    @classmethod
    def of(cls, world: World, settings: RunSettings) -> Header:
        """Return the header of a run of a world."""
        seed = world.seed if settings.seed is None else settings.seed
        run = settings.step_size, settings.goal_id_salt
        return cls(__version__, seed, settings.seed is not None, *_content(world), *run)

    def after(self, restarted: TimeRestarted) -> Header:
        """Return the header of the section that begins when time has begun anew."""
        following = replace(self, section=self.section + 1, cause=str(restarted.cause))
        world = restarted.loaded
        if world is None:
            return following
        name, hash_, definition = _content(world)
        seed = self.seed if self.seed_given else world.seed
        return replace(following, seed=seed, name=name, hash=hash_, definition=definition)

    def line(self) -> str:
        """Return the line, without its end; parts of the world keep their order, which is that of their ids."""
        cause = {"cause": self.cause} if self.cause else {}
        run: dict[str, Any] = {"run_id": self.run_id} if self.run_id else {}
        run |= {"section": self.section} if self.section > 1 else {}
        run |= {"seed": self.seed, "seed_given": self.seed_given, "step_size": self.step_size}
        world = {"definition": self.definition, "hash": self.hash, "name": self.name}
        return _encode_in_order(
            {**cause, "contract": self.contract, "hmrsim": self.version, "kind": "header", **run, "world": world}
        )


def _content(world: World) -> tuple[str, str, dict[str, Any]]:
    return world.name, world_hash(world), _DEFINITIONS(world)


_DEFINITIONS: Final = Derived(native_data)


class Trace(SelectiveSink):
    """A sink that writes the events of the world and the commands from outside.

    Args:
        write: Takes text: whole lines, some at a time.

    Attributes:
        header: That of the section that is being written.

    Writing raises `WriteError` when *write* raises OSError.
    """

    topics = frozenset({Topic.EVENTS})

    def __init__(self, header: Header, write: Callable[[str], object]) -> None:
        self.header = header
        self._write = write
        self._lines: list[str] = [header.line()]
        self._results: dict[str, tuple[Message, str]] = {}
        self._texts: LruCache[tuple[str, str], str] = LruCache(_KEPT_TEXTS)
        self._recorders: dict[type, Callable[[Any], dict[str, Any] | None]] = {
            commands.SendGoal: _send_goal,
            commands.CancelGoal: _cancel_goal,
            commands.ChangeState: _change_state,
            commands.CallService: self._call_service,
            commands.Participation: lambda command: {"command": "participation", **command._asdict()},
            commands.PlannerPresent: lambda command: {"command": "planner_present", "present": command.present},
            commands.PlanAnswered: _plan_answered,
            commands.Stop: lambda command: {"command": "stop", "reason": command.reason},
        }

    def flush(self) -> None:
        """Write the buffered lines."""
        if self._lines:
            lines, self._lines = self._lines, []
            lines.append("")
            try:
                self._write("\n".join(lines))
            except OSError as error:
                raise WriteError(f"the trace can't be written: {reason_of(error)}") from None

    def close(self, now: float) -> None:
        """Write the last line, which says that the trace is complete: the run ends at this time, in seconds."""
        self._add({"kind": "end", "stamp": values_of(stamp(now))})
        self.flush()

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self.emit if kind in (EventStamped, GoalChanged, TimeRestarted) else None

    def emit(self, output: Output) -> None:
        """Write an event."""
        kind = type(output)
        if kind is GoalChanged:
            self._lines.append(self._status(output))  # type: ignore[arg-type]  # by its exact type: asked for each event
            if len(self._lines) >= _BATCH:
                self.flush()
        elif kind is EventStamped and output.event.traced:  # type: ignore[union-attr]  # narrowed by kind
            self._add(_event_fields(output))  # type: ignore[arg-type]
        elif kind is TimeRestarted:
            self.header = self.header.after(output)  # type: ignore[arg-type]
            self._lines.append(self.header.line())

    def _status(self, event: GoalChanged) -> str:
        sec, nanosec = divmod(event.stamp, NANOSECONDS)
        result = "" if event.result is None else f'"result":{self._result(event)},'
        cause = f'"cause":"{event.cause}",' if event.cause else ""
        return (
            f'{{"action":"{event.action}",{cause}"goal_id":"{event.goal_id}","kind":"status",{result}"robot":"{event.robot}",'
            f'"stamp":{{"nanosec":{nanosec},"sec":{sec}}},"status":{int(event.status)}}}'
        )

    def _result(self, event: GoalChanged) -> str:
        """Return a result as text; most goals of an action that succeed share theirs, or have equal ones."""
        result, known = event.result, self._results.get(event.action)
        if known is not None and known[0] is result:
            return known[1]
        if result is None:
            raise AssertionError
        text = self._texts.get(
            (event.action, result.model_dump_json(exclude_unset=True, warnings=False)), lambda: _as_text(result)
        )
        self._results[event.action] = (result, text)
        return text

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Write a command."""
        recorder = self._recorders.get(type(command))
        fields = recorder(command) if recorder else None
        if fields is not None:
            self._add({"kind": "command", **fields, "stamp": values_of(stamp(now)), **({"by": by} if by else {})})

    def _call_service(self, command: commands.CallService) -> dict[str, Any] | None:
        service = services()[command.service]
        if not service.changes_world:
            return None
        return {"command": "call_service", "service": service.name, "request": _as_it_came(command.request)}

    def _add(self, fields: Mapping[str, Any]) -> None:
        self._lines.append(_encode(fields))
        if len(self._lines) >= _BATCH:
            self.flush()


def _as_text(result: Message) -> str:
    # A field that was not set has its default; comparing the others with theirs takes most of the time.
    return _encode(_rounded(result.model_dump(mode="json", exclude_unset=True, exclude_defaults=True)))


def _send_goal(command: commands.SendGoal) -> dict[str, Any]:
    goal = None if command.goal is None else _as_it_came(command.goal)
    asked = {"robot": command.robot, "action": command.action, "goal_id": command.goal_id, "goal": goal}
    if command.verdict is not Verdict.REJECT:
        asked["verdict"] = command.verdict
    return {"command": "send_goal", **asked}


def _cancel_goal(command: commands.CancelGoal) -> dict[str, Any]:
    goal_info = {"goal_id": command.goal_id, "stamp": values_of(command.stamp)}
    return {"command": "cancel_goal", "robot": command.robot, "action": command.action, "goal_info": goal_info}


def _change_state(command: commands.ChangeState) -> dict[str, Any]:
    fields = command._asdict()
    del fields["reply_to"]
    return {"command": "change_state", **fields, "actions": list(command.actions)}


def _plan_answered(command: commands.PlanAnswered) -> dict[str, Any]:
    return {"command": "plan_answered", "request": command.request, "result": _as_it_came(command.result)}


def _event_fields(event: EventStamped) -> dict[str, Any]:
    happening = event.event
    fields = {
        name: value if type(value) is str else _rounded(value)  # most are text, and this is done for each event
        for name, value in happening.as_dict().items()
    }
    fields["kind"], fields["stamp"] = happening.kind, values_of(event.stamp)
    return fields


def _as_it_came(message: Message) -> Any:
    """Return a message in plain values, exactly, as it is submitted again."""
    return message.model_dump(mode="json", exclude_unset=True)


def _rounded(value: Any) -> Any:
    """Return plain values with all numbers rounded, and no negative zero."""
    if isinstance(value, float):
        return round(value, _DIGITS) + 0.0 if math.isfinite(value) else str(value)
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(each) for each in value]
    return value


class _Commanded(NamedTuple):
    """A command, the participant that sent it, and when."""

    command: Command
    by: str
    now: float


class DeferredTrace(SelectiveSink):
    """A sink that collects the immutable outputs of a run, and writes them as a `Trace` on demand."""

    topics = frozenset({Topic.EVENTS})

    def __init__(self, world: World, settings: RunSettings) -> None:
        self._world, self._settings = world, settings
        self._kept: list[Output | _Commanded] = []
        self._pieces: list[str] = []
        self._trace: Trace | None = None

    @property
    def text(self) -> str:
        """The text of the trace so far."""
        self._written().flush()
        return "".join(self._pieces)

    def whole(self, now: float) -> str:
        """Return the trace of a run that has ended at this time, in simulated seconds."""
        self._written().close(now)
        return "".join(self._pieces)

    def _written(self) -> Trace:
        trace = self._trace = self._trace or Trace(Header.of(self._world, self._settings), self._pieces.append)
        for kept in self._kept:
            if isinstance(kept, _Commanded):
                trace.commanded(*kept)
            else:
                trace.emit(kept)
        self._kept.clear()
        return trace

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._kept.append if kind in (EventStamped, GoalChanged, TimeRestarted) else None

    def commanded(self, command: Command, by: str, now: float) -> None:
        """Record a command for later."""
        if not isinstance(command, UNRECORDED):
            self._kept.append(_Commanded(without_receivers(command), by, now))

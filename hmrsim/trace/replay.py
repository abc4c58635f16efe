"""The replay of a trace without a network or a controller, to check that the run can be reproduced.

The commands of the trace are submitted to a new simulation at the same times and in the same order. The trace of that
simulation is compared line by line; a truncated trace is compared up to its last line.

All sections are replayed in order, since each continues from the state that the earlier ones have left: ids and results
of goals, and also robots and items if only time was reset.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

import hmrsim
from hmrsim.engine.sim_time import end_of_instant
from hmrsim.errors import TraceError, WorldError
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.commands import Stop
from hmrsim.protocol.outputs import TimeRestarted
from hmrsim.services import registry as services
from hmrsim.settings.option import MAX_SECONDS
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.difference import Difference
from hmrsim.trace.sections import Line, begins_section, command_of, line_of
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink
    from hmrsim.protocol.topics import Topic

_CONTEXT: Final = 3
"""The number of lines that are shown before and after a difference."""


@dataclass(frozen=True)
class Replayed:
    """A section of a trace that was replayed, at least in part.

    Attributes:
        lines: The number of lines that are the same in the replay.
        commands: The number of commands among them.
        sim_time: The simulated seconds that were replayed.
    """

    header: Header
    lines: int
    commands: int
    sim_time: float


@dataclass(frozen=True)
class Outcome:
    """The outcome of a replay.

    Attributes:
        sections: The sections that were replayed, in order.
        complete: Whether the replay reached the end of the run; False for a truncated trace.
        difference: The first difference between the trace and the replay; None if there is none.
    """

    sections: tuple[Replayed, ...]
    complete: bool
    difference: Difference | None

    @property
    def header(self) -> Header:
        """The header, which is the trace's first line."""
        return self.sections[0].header

    @property
    def lines(self) -> int:
        """The number of identical lines."""
        return sum(section.lines for section in self.sections)

    @property
    def commands(self) -> int:
        """The number of identical lines that are commands."""
        return sum(section.commands for section in self.sections)

    @property
    def sim_time(self) -> float:
        """The simulated time replayed so far, in seconds summed over all sections."""
        return math.fsum(section.sim_time for section in self.sections)


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
    section: int = 1
    world: _World


def replay(
    lines: Iterable[str],
    watchers: Callable[[Simulator], Sequence[Sink]] = lambda _simulator: (),
    *,
    section: int | None = None,
) -> Outcome:
    """Replay a trace, and compare it with the trace of the replay.

    Args:
        lines: The lines of the trace, with their line ends; an incomplete last line is ignored.
        watchers: Makes further sinks for the simulation before it begins.
        section: The last section to replay, which the trace must have; None for all.

    Raises:
        TraceError: The lines are no trace, or a trace of another version.
    """
    whole = (line[:-1] for line in lines if line.endswith("\n"))
    return _Replay(whole, watchers, math.inf if section is None else section).run()


class _Lengths:
    """A sink that records the lengths of sections, in nanoseconds."""

    def __init__(self) -> None:
        self.all: list[int] = []

    def wants(self, _topic: Topic) -> bool:
        """Return False: the sink receives restarts regardless of topics."""
        return False

    def emit(self, output: Output) -> None:
        """Record the length of a section when time restarts."""
        if isinstance(output, TimeRestarted):
            self.all.append(output.ended)


class _Replay:
    """One replay of a trace."""

    def __init__(self, lines: Iterator[str], watchers: Callable[[Simulator], Sequence[Sink]], sections: float) -> None:
        self._most = sections
        first = next(lines, "")
        self._lines = chain([first], lines)
        self._header = _header(first)
        try:
            world = world_of(dict(self._header.definition), "line 1: world")
        except WorldError as error:
            raise TraceError(str(error.problems[0])) from None
        seed = self._header.seed if self._header.seed_given else None
        settings = RunSettings(seed=seed, step_size=self._header.step_size, run_id=self._header.run_id)
        # The lines of the replay that have not been compared yet.
        self._pending: deque[str] = deque()
        self._trace = Trace(self._header, lambda text: self._pending.extend(text.splitlines()))
        self._lengths = _Lengths()
        sinks: list[Sink] = [self._trace, self._lengths]
        self._simulator = Simulator(world, settings, sinks, watchers=watchers, services=services())
        self._trace.flush()
        self._commands = 0
        self._stopped = False
        self._sections: list[Replayed] = []

    def run(self) -> Outcome:
        """Compare all lines up to the first difference, and return the outcome."""
        before: deque[str] = deque(maxlen=_CONTEXT)
        same, last, difference, header, ended = 0, "", None, self._header, False
        for line in self._lines:
            begins = same > 0 and begins_section(line)
            ended = begins and len(self._sections) + 1 >= self._most
            if ended:
                break
            replayed = self._next(line, same + 1, begins=begins)
            if replayed != line:
                after = tuple(islice(self._lines, _CONTEXT))
                difference = Difference(same + 1, line, replayed, tuple(before), after)
                break
            if begins:
                self._end_section(header, same)
                header = self._trace.header
            same, last = same + 1, line
            before.append(line)
        self._end_section(header, same)
        complete = difference is None and (ended or '"kind":"end"' in last)
        return Outcome(tuple(self._sections), complete, difference)

    def _end_section(self, header: Header, same: int) -> None:
        """Record the end of a section, after *same* identical lines of the whole trace."""
        done, lengths = self._sections, self._lengths.all
        lines = same - sum(section.lines for section in done)
        commands = self._commands - sum(section.commands for section in done)
        known = len(done) < len(lengths)
        length = lengths[len(done)] / NANOSECONDS if known else self._simulator.now
        done.append(Replayed(header, lines, commands, length))

    def _next(self, expected: str, number: int, *, begins: bool) -> str | None:
        """Return the next line of the replay, at which the trace has *expected*; None if there is none.

        If a section *begins* here, its header has already been written: a command has begun the section.
        """
        if begins:
            return self._pending.popleft() if self._pending else None
        line = line_of(expected, number) if number > 1 else None
        if line is not None and line.kind in ("command", "end") and not self._pending:
            self._advance_to(line)
            if not self._pending:
                self._repeat(line, number)
        until = end_of_instant(line.stamp.to_nanoseconds() / NANOSECONDS) if line is not None else math.inf
        while not self._pending and self._simulator.process_events(until, 1):
            self._trace.flush()
        return self._pending.popleft() if self._pending else None

    def _advance_to(self, line: Line) -> None:
        """Process all events before a command, or until one of them is traced.

        No events follow a stop, not even those of the same instant, for instance of scripts.
        """
        simulator = self._simulator
        at = line.stamp.to_nanoseconds() / NANOSECONDS
        until = end_of_instant(at) if line.kind == "command" else math.nextafter(at, -math.inf)
        while not (self._pending or self._stopped) and simulator.process_events(until, 1):
            self._trace.flush()
        if not self._pending:
            simulator.advance_clock(at)

    def _repeat(self, line: Line, number: int) -> None:
        """Submit the command of a line of the trace, or end the replay's trace at the line of the end."""
        if line.kind == "end":
            self._trace.close(self._simulator.now)
            return
        self._commands += 1
        command = command_of(line, number)
        self._stopped = isinstance(command, Stop)
        self._simulator.submit(command, line.by)
        self._trace.flush()


def _header(line: str) -> Header:
    try:
        read = _HeaderLine.model_validate_json(line)
    except ValidationError:
        raise TraceError("line 1: no header of a trace; expected a file that was written with --trace") from None
    if read.contract != hmrsim.CONTRACT:
        raise TraceError(f"line 1: a trace of contract {read.contract}; this is contract {hmrsim.CONTRACT}")
    if read.section != 1:
        raise TraceError(f"line 1: the header of section {read.section}; a replay needs the sections before it, too")
    world = read.world
    content = (world.name, world.hash, world.definition)
    return Header(read.hmrsim, read.seed, read.seed_given, *content, read.step_size, read.run_id)

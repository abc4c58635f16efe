"""A controller that is a command, run to its end while it and its wire are disturbed."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.errors import SimulationStopped
from hmrsim.experiments.judging.labels import HUNG, TIMEOUT
from hmrsim.experiments.running.controlling import TimeLimit
from hmrsim.experiments.running.processes import (
    POLL,
    ControllerProcess,
    ending_of,
    wait_for_end,
)
from hmrsim.fault_search.disturbances import Disturber
from hmrsim.fault_search.running.actors import TOKEN_GONE
from hmrsim.fault_search.running.cast import GONE, Cast

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim_zenoh.hosting.host import Host

_PATIENCE: Final = 20.0
"""Wall seconds within which a controller that is started beside the first has to join, if time is to wait for it."""


@dataclass(frozen=True)
class Command:
    """A command that controls the robots of a simulation.

    Attributes:
        words: The command.
        folder: Where it is started.
        variables: What its environment has, beside ``HMRSIM_CONNECT``.
    """

    words: Sequence[str]
    folder: Path
    variables: Mapping[str, str] = field(default_factory=dict)


class CommandRun(NamedTuple):
    """How a command has ended.

    Attributes:
        ending: As of an experiment's run, or ``killed``.
        cause: What that does not say; empty for nothing.
        output: The last lines that it has printed.
    """

    ending: str
    cause: str
    output: str


def run_command_controller(host: Host, command: Command, disturber: Disturber | None = None) -> CommandRun:
    """Run a command to its end; all of its processes are killed then, and have left lockstep.

    Its endings are those of an experiment's command, and `killed`; of one that was started again the last run counts.

    Args:
        host: Serves the world in lockstep, and was started; *disturber* watches it.
        command: What is run. The second process has ``HMRSIM_NAME_SUFFIX=_2``, which `hmrsim_zenoh.Client` heeds.
        disturber: What disturbs it.

    Raises:
        OSError: It can't be started.
    """
    return _Commands(host, command, disturber or Disturber()).run()


class _Commands(Cast):
    """The processes of a run."""

    def __init__(self, host: Host, command: Command, disturber: Disturber) -> None:
        self._host = host
        self._command = command
        self._killed = False
        self._others: list[_Other] = []
        super().__init__(host, disturber)
        self._first = self._start()

    def run(self) -> CommandRun:
        try:
            ending, cause = self._follow()
        finally:
            self._end()
        return CommandRun(ending, cause, self._first.output)

    def _start(self, suffix: str = "") -> ControllerProcess:
        variables = {**self._command.variables, "HMRSIM_CONNECT": self._host.endpoints[0]}
        if suffix:
            variables["HMRSIM_NAME_SUFFIX"] = suffix
        return ControllerProcess(self._command.words, self._command.folder, variables)

    def _follow(self) -> tuple[str, str]:
        """Wait for the end of the controller, of the run, or of its time."""
        try:
            return self._followed()
        except TimeLimit as limit:
            return HUNG, str(limit)

    def _followed(self) -> tuple[str, str]:
        while True:
            code = self._first.code
            if self._killed:
                if self._restarts.is_set():
                    self._restarts.clear()
                    with self._first:
                        self._first, self._killed = self._start(), False
                elif self._gone and not (self._others or self._lockstep.expects):
                    return GONE
            elif code is not None:
                return ending_of(code)
            if self._host.wait(POLL):
                return self._after_the_run()
            if ended := self._look_at_others():
                return ended

    def _after_the_run(self) -> tuple[str, str]:
        if self._killed:
            return GONE if self._gone else (TIMEOUT, "")
        wait_for_end(self._first)
        return TIMEOUT, ""

    def _look_at_others(self) -> tuple[str, str] | None:
        """Let time not wait for processes that end without having joined; return an ending that counts."""
        for each in self._others:
            code, late = each.process.code, time.monotonic() > each.started + _PATIENCE
            if each.awaited and (code is not None or late):
                each.awaited = False
                self._submit(lambda names=each.names: self._expect_no_more(names))  # type: ignore[misc]
            if code is not None and self._gone and self._killed:
                return ending_of(code)
        return None

    def _expect_no_more(self, names: Sequence[str]) -> None:
        for name in names:
            self._lockstep.expect_no_more(name)

    @property
    def _own_names(self) -> list[str]:
        """The participants of the first process."""
        others = {name for each in self._others for name in each.names}
        return [name for name in self._lockstep.participants if name not in others]

    def _kill(self, restart_after: float | None) -> None:
        if self._killed:
            return
        # Noted before the process has ended, as another thread looks at both.
        self._killed = True
        names, lockstep = self._own_names, self._lockstep
        self._first.kill()
        for name in names:
            lockstep.drop(name, TOKEN_GONE)
            lockstep.expect_no_more(name)
        if restart_after is None:
            lockstep.expect("", math.inf)
            # Noted when time goes on without it, as another thread looks whether it does.
            self._gone = True
            return
        for name in names or [""]:
            lockstep.expect(name, self._simulator.now + restart_after, self._restarts.set)

    def _add(self) -> None:
        """Start the command once more beside the first process, and have time wait for it to join."""
        lockstep, suffix = self._lockstep, f"_{len(self._others) + 2}"
        own = self._own_names
        for name in own:
            # The run ends with the first process: until that is noticed, time stands.
            lockstep.keep(name)
        names = [f"{name}{suffix}" for name in own]
        for name in names:
            lockstep.expect(name)
        # It can be started, as the first one was.
        self._others.append(_Other(self._start(suffix), names, time.monotonic()))

    def _end(self) -> None:
        """Kill all processes, and have them leave lockstep at this time."""
        for process in (self._first, *(each.process for each in self._others)):
            with process:
                pass
        self._submit(self._dismiss)

    def _dismiss(self) -> None:
        lockstep = self._lockstep
        lockstep.expect_nobody()
        for name in lockstep.participants:
            lockstep.drop(name, TOKEN_GONE)

    def _submit(self, act: Callable[[], None]) -> None:
        """Do something in the simulation's thread, and wait for that, unless the run has ended."""
        done = threading.Event()

        def do() -> None:
            act()
            done.set()

        with suppress(SimulationStopped):
            self._host.pacing.intervene(do)
            while not (done.wait(POLL) or self._host.wait(0.0)):
                pass


@dataclass
class _Other:
    """A process beside the first.

    Attributes:
        names: The names of its participants.
        started: When it was started, by the monotonic clock.
        awaited: Whether time may wait for it to join.
    """

    process: ControllerProcess
    names: list[str]
    started: float
    awaited: bool = True

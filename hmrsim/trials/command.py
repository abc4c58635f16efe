"""A trial whose controller is a command: any program, which connects over Zenoh."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import IO, TYPE_CHECKING, Final

from hmrsim.errors import HmrsimError, SimulationStopped
from hmrsim.timing.pacing import Watchers, unwatched
from hmrsim.trials.guards import Tail
from hmrsim.trials.trial import GONE, HUNG, TIMEOUT, TOKEN_GONE, Ended, TimeLimit, Trial, ending_of_code
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.trials.disturbances import Disturber
    from hmrsim.world_checks import LoadedWorld

_POLL: Final = 0.002
"""Wall seconds between two checks whether the controller or the run has ended."""
_PATIENCE: Final = 20.0
"""Wall seconds for which simulated time waits until a second controller joins."""


class CommandTrial(Trial):
    """A trial of processes; when the first process ends, the others are killed.

    Each process has its own process group. Exit code 0 is a success, 1 a failure, and all others a crash.

    Args:
        settings: The seed and others; the clock is lockstep, and limits end a run that does not ask to advance.
        words: The command. A second process gets ``HMRSIM_NAME_SUFFIX=_2``, which `hmrsim_zenoh.Client` adds to its
            name.
        folder: The folder in which it is started.
        variables: Environment variables in addition to ``HMRSIM_CONNECT`` and ``HMRSIM_SEED``.
    """

    def __init__(
        self,
        loaded: LoadedWorld,
        settings: RunSettings,
        words: Sequence[str],
        folder: Path,
        variables: Mapping[str, str],
        *,
        sinks: Sequence[Sink] = (),
        watchers: Watchers = unwatched,
        disturber: Disturber | None = None,
    ) -> None:
        chosen = settings.model_copy(update={"clock": "lockstep", "participant_timeout": math.inf})
        options = SessionOptions(listen=("tcp/127.0.0.1:0",))
        self._host = Host(loaded, options, chosen, sinks=sinks, watchers=watchers)
        self._words, self._folder, self._variables = words, folder, variables
        self._first: ControllerProcess | None = None
        # Held while the first process starts: it may act before `self._first` is set.
        self._starting = threading.Lock()
        self._killed = self._over = False
        self._others: list[_Other] = []
        super().__init__(self._host, disturber)

    @property
    def over(self) -> bool:
        """True if the run ended, by its limit or by a sink, before its controller did."""
        return self._over

    def play(self) -> Ended:
        """Run the command to its end; see `Trial.play`.

        Raises:
            HmrsimError: It can't be started.
        """
        with self._starting:
            self._host.start()
            try:
                first = self._first = self._start()
            except OSError as error:
                raise HmrsimError(f"{self._words[0]}: {error.strerror or error}") from None
        try:
            ending, cause = self._followed(first)
        except TimeLimit as limit:
            ending, cause = HUNG, str(limit)
        finally:
            self._end_processes()
        self._over = self._host.pacing.over
        # Stopped, so that the simulator can be read.
        self._host.stop()
        return Ended(ending, cause, self._first.output)

    def close(self) -> None:
        """End all goals of the run."""
        self._host.stop()

    def _start(self, suffix: str = "") -> ControllerProcess:
        own = {"HMRSIM_CONNECT": self._host.endpoints[0], "HMRSIM_SEED": str(self.simulator.seed)}
        variables = {**self._variables, **own}
        if suffix:
            variables["HMRSIM_NAME_SUFFIX"] = suffix
        return ControllerProcess(self._words, self._folder, variables)

    def _followed(self, first: ControllerProcess) -> tuple[str, str]:
        """Wait for the end of the controller, or of the run; return the ending and its cause."""
        while True:
            code = first.code
            if self._killed:
                if self._restarts.is_set():
                    self._restarts.clear()
                    first.end()
                    with self._starting:
                        first = self._first = self._start()
                        self._killed = False
                elif self._gone and not (self._others or self._lockstep.expects):
                    return GONE
            elif code is not None:
                return ending_of_code(code)
            if self._host.wait(_POLL):
                return self._after_the_run(first)
            if ended := self._look_at_others():
                return ended

    def _after_the_run(self, first: ControllerProcess) -> tuple[str, str]:
        if self._killed:
            return GONE if self._gone else (TIMEOUT, "")
        first.wait(GRACE)
        return TIMEOUT, ""

    def _look_at_others(self) -> tuple[str, str] | None:
        """Stop waiting for processes that ended or are late to join; return the ending of one that counts."""
        for each in self._others:
            code, late = each.process.code, time.monotonic() > each.started + _PATIENCE
            if each.awaited and (code is not None or late):
                each.awaited = False
                self._submit(lambda names=each.names: self._expect_no_more(names))  # type: ignore[misc]
            if code is not None and self._gone and self._killed:
                return ending_of_code(code)
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
        with self._starting:
            first = None if self._killed else self._first
        if first is None:
            return
        # Noted before the process ends, since another thread looks at both.
        self._killed = True
        names, lockstep = self._own_names, self._lockstep
        first.kill()
        for name in names:
            lockstep.drop(name, TOKEN_GONE)
            lockstep.expect_no_more(name)
        if restart_after is None:
            lockstep.expect("", math.inf)
            # Noted once time does not wait for it, since another thread looks at both.
            self._gone = True
            return
        for name in names or [""]:
            lockstep.expect(name, self.simulator.now + restart_after, self._restarts.set)

    def _add(self) -> None:
        """Start the command a second time beside the first process; simulated time waits until it joins."""
        lockstep, suffix = self._lockstep, f"_{len(self._others) + 2}"
        own = self._own_names
        for name in own:
            # The run ends with the first process; time stands still until its end is noticed.
            lockstep.keep(name)
        names = [f"{name}{suffix}" for name in own]
        for name in names:
            lockstep.expect(name)
        self._others.append(_Other(self._start(suffix), names, time.monotonic()))

    def _end_processes(self) -> None:
        """Kill all processes and remove them from lockstep."""
        for process in (self._first, *(each.process for each in self._others)):
            if process is not None:
                process.end()
        self._submit(self._dismiss)

    def _dismiss(self) -> None:
        lockstep = self._lockstep
        lockstep.expect_nobody()
        for name in lockstep.participants:
            lockstep.drop(name, TOKEN_GONE)

    def _submit(self, act: Callable[[], None]) -> None:
        """Call a function in the simulation's thread and wait for it, unless the run has ended."""
        done = threading.Event()

        def do() -> None:
            act()
            done.set()

        with suppress(SimulationStopped):
            self._host.pacing.intervene(do)
            while not (done.wait(_POLL) or self._host.wait(0.0)):
                pass


@dataclass
class _Other:
    """A process beside the first.

    Attributes:
        started: The time of its start, by the monotonic clock.
        awaited: Whether simulated time waits for it to join.
    """

    process: ControllerProcess
    names: list[str]
    started: float
    awaited: bool = True


GRACE: Final = 2.0
"""Wall seconds in which a controller has to end by itself after the run."""


class ControllerProcess:
    """The process of a controller, with the processes that it starts.

    Args:
        variables: Environment variables in addition to those of this process.

    Raises:
        OSError: It can't be started.
    """

    def __init__(self, words: Sequence[str], folder: Path, variables: Mapping[str, str]) -> None:
        self._tail = Tail()
        self._process = subprocess.Popen(  # noqa: S603 - the user's own command
            words,
            cwd=folder,
            env=os.environ | variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            text=True,
            errors="replace",
        )
        self._reader = threading.Thread(target=self._read, args=(self._process.stdout,), daemon=True)
        self._reader.start()

    def end(self) -> None:
        """Kill it, and read the rest of its output."""
        self.kill()
        self._reader.join(GRACE)

    def wait(self, patience: float) -> None:
        """Wait for its end, at most for *patience* wall seconds."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(patience)

    def kill(self) -> None:
        """Kill it and the processes that it started."""
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    @property
    def code(self) -> int | None:
        """The exit code; None while it runs."""
        return self._process.poll()

    @property
    def output(self) -> str:
        """The last characters that it printed."""
        return self._tail.text

    def _read(self, stream: IO[str]) -> None:
        with suppress(ValueError, OSError), stream:
            while text := stream.read(4096):
                self._tail.write(text)

"""Pacing of simulated time: at a rate of wall time, as fast as possible, or as far as its controllers allow.

Commands are taken from the inbox between events. In real time they are stamped with the simulated time of that
moment; when the machine can't keep up, simulated time lags behind and the lag is reported; time never leaps.
"""

from __future__ import annotations

import logging
import math
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import wall_time
from hmrsim.errors import SimulationStopped
from hmrsim.protocol.commands import Advance, PlanAnswered, TimeCommand
from hmrsim.protocol.goal import Refused
from hmrsim.protocol.time import (
    LOCKSTEP,
    CheckWatchdog,
    Intervene,
    Join,
    Leave,
    ReadTime,
    SetClock,
    TimeState,
    TokenSeen,
)
from hmrsim.settings.run import RunSettings
from hmrsim.timing.lockstep import Lockstep

if TYPE_CHECKING:
    from hmrsim.protocol.commands import AnyCommand, Inbox
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.result_retention import Retention

_log = logging.getLogger(__name__)

Watchers = Callable[["Simulator", "Pacing"], "Sequence[Sink]"]
"""Makes further sinks of a simulation."""

PLANNER: Final = "_planner"
"""Listed among the participants that time waits for, in lockstep, while an external planner has not answered."""

_EVENTS_BETWEEN_POLLS = 4
"""Events that are processed between two polls of the inbox, so that a query is answered soon while many are due."""

_COMMANDS_AT_ONCE = 16
"""Commands that are taken between two rounds of events."""

_EVENTS_OF_A_GRANT = 64
"""Likewise while time is granted, when all participants wait for the grant anyway."""

_yield_core: Callable[[], object] = getattr(os, "sched_yield", partial(time.sleep, 0))
"""Lets another thread run; Windows has no function for that alone."""

_EVENTS_OF_A_ROUND = 64
"""Events that are processed as fast as possible, with a poll after each, before the limits are read again."""

_BETWEEN_WARNINGS = 5.0
"""Wall seconds between two reports of lag."""

_QUANTUM = 0.005
"""Wall seconds from one round of events to the next, where they are many: to wake, and to send a message that goes
alone, costs more than to do the work. What is due in between comes as much late, a command never."""

_MAX_WAIT = 0.25
"""Maximum wall seconds of one wait: a process that was stopped meanwhile is noticed by how late it wakes."""

_MAX_LATENESS = 0.1
"""Wall seconds that an event, or the end of a wait, may be late before simulated time stops catching up."""

_LOOKS = 5
"""Checks for a stalled participant within its timeout."""


class Pacing:
    """Advances a simulator's time until its inbox is closed.

    Args:
        retention: Drops results after some wall seconds; None to keep them by number alone.
        settings: How time moves, at first.
        on_lag: Called with the total lag in wall seconds when it grows; at most every 5 s.
        on_wait: Callbacks for the moments before the thread waits.
        preparations: Work that can be done in advance; done step by step, in lockstep, while time stands.
        lockstep_only: Whether the clock can't be set to anything else.

    Attributes:
        lockstep: Grants time to participants; to be one of the simulator's sinks.
        clock: How time moves: ``realtime`` or ``lockstep``.
        real_time_factor: Simulated seconds a wall second in real time; 0 for as fast as possible.
        lag: Wall seconds that time has lost.
        over: Whether the run has ended, or ends after this instant.
    """

    def __init__(
        self,
        simulator: Simulator,
        inbox: Inbox,
        retention: Retention | None,
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        *,
        on_lag: Callable[[float], None] = lambda _lag: None,
        on_wait: Sequence[Callable[[], None]] = (),
        preparations: Iterator[object] = iter(()),  # noqa: B008 - empty
        lockstep_only: bool = False,
    ) -> None:
        self.lockstep = Lockstep(simulator, awaited=settings.participants, until=settings.duration)
        self.clock: str = settings.clock
        self.real_time_factor = settings.real_time_factor
        self.lag = 0.0
        self._simulator = simulator
        self._inbox = inbox
        self._retention = retention
        self._duration = settings.duration
        self._participant_timeout = settings.participant_timeout
        self._end_on_loss = settings.on_participant_loss == "end"
        self._on_lag = on_lag
        self._on_wait = on_wait
        self._preparations = preparations
        self._generation = simulator.generation
        self._reported = -math.inf
        self._anchor: float | None = None
        self._awake_by = math.inf
        self._lockstep_only = lockstep_only
        self._idle = False
        self.over = False
        self._last_state: TimeState | None = None
        self._handlers: Mapping[type, Callable[[Any], None]] = {
            ReadTime: lambda command: simulator.answer(command.reply_to, self.state),
            SetClock: self._set_clock,
            Join: self._join,
            Advance: self._advance,
            Leave: self.lockstep.leave,
            TokenSeen: lambda command: self.lockstep.token_seen(command.participant, alive=command.alive),
            Intervene: self._intervene,
            CheckWatchdog: self._drop_overdue,
        }

    def run(self) -> None:
        """Run until the inbox is closed or the duration is over; `end` ends goals that still execute."""
        over, interval = threading.Event(), self._participant_timeout / _LOOKS
        if interval < math.inf:
            watch = partial(watch_over, self._look_for_overdue, interval, over)
            threading.Thread(target=watch, name="hmrsim-watch", daemon=True).start()
        try:
            while not (self._inbox.closed or self.over):
                self._round()
        finally:
            over.set()
        self._reach_the_end()

    def run_until_idle(self) -> bool:
        """Run until all that is left is to wait for a command, in whose place this returns; return False at the end.

        For one thread at a time, and an inbox that does not wait.
        """
        self._idle = False
        while not (self._idle or self._inbox.closed or self.over):
            self._round()
        return not (self._inbox.closed or self.over)

    def finish_instant(self) -> None:
        """End the run once all events of this instant are processed; to be called from within the simulation."""
        self.over = True
        self._simulator.halt()

    def intervene(self, act: Callable[[], None]) -> None:
        """Call a function in the simulation's thread after all events of this instant, before time moves on.

        From any thread, and from within the simulation, as a sink may.

        Raises:
            SimulationStopped: The inbox is closed.
        """
        self._inbox.put(Intervene(act))
        self._simulator.halt()

    def end(self, reason: str) -> None:
        """End the run, abort every goal with a reason, and report that to the participants."""
        self.over = True
        try:
            self.lockstep.end(self.loss or reason, reason)
        finally:
            # Every goal gets its end, also where a trace can't take in who has left, as the disk is full.
            self._simulator.stop(reason)

    @property
    def loss(self) -> str:
        """The participant whose loss ended the run, and the reason; empty if the run ended for another reason."""
        return self.lockstep.lost if self._end_on_loss else ""

    def submit(self, command: AnyCommand) -> None:
        """Apply a command now, in the simulation's thread."""
        if isinstance(command, TimeCommand):
            self._handlers[type(command)](command)
            # Another participant that still thinks learns of the end when it asks to advance.
            if self._end_on_loss and self.lockstep.lost and not self.lockstep.thinks:
                self.over = True
        elif isinstance(command, PlanAnswered) and self.clock == LOCKSTEP:
            self._simulator.plans.keep(command)
        else:
            self._simulator.submit(command)

    @property
    def state(self) -> TimeState:
        """The current state of time."""
        lockstep = self.clock == LOCKSTEP
        planner = (PLANNER,) if self._simulator.plans.awaited else ()
        return TimeState(
            now=self._simulator.now,
            clock=self.clock,
            real_time_factor=self.real_time_factor,
            paused=self._simulator.limit < math.inf,
            epoch=self.lockstep.epoch,
            participants=self.lockstep.participants,
            waiting_for=(*self.lockstep.waiting_for, *planner) if lockstep else (),
            lag=self.lag,
        )

    @property
    def hurries(self) -> bool:
        """Return whether simulated time may run faster than wall time."""
        return self.clock == LOCKSTEP or not 0.0 < self.real_time_factor <= 1.0

    @property
    def hindrance(self) -> str:
        """Why time can't advance, even if a client requests it; empty if it can."""
        if self.clock == LOCKSTEP and not self.lockstep.participates:
            return "time stands, as lockstep has no participant; let a controller join, or set the clock to realtime"
        return ""

    def _round(self) -> None:
        simulator = self._simulator
        if self._generation != simulator.generation:
            self._generation, self._anchor = simulator.generation, None
            self.lockstep.restart()
        if self.clock == LOCKSTEP:
            self._lockstep_round()
        elif simulator.paused:
            self._anchor = None
            if not self._take_commands():
                self._wait()
        elif self.real_time_factor == 0 or simulator.limit < math.inf:
            # Steps run as fast as possible, too.
            self._anchor = None
            self._free_round()
        else:
            self._paced_round(self.real_time_factor)

    def _lockstep_round(self) -> None:
        lockstep, inbox = self.lockstep, self._inbox
        taken = self._take_commands()
        interrupted = self.over or self._generation != self._simulator.generation or self.clock != LOCKSTEP
        if taken and (taken == _COMMANDS_AT_ONCE or interrupted):
            return
        if not lockstep.granting and self._begins(prepares=not taken):
            return
        if lockstep.granting:
            while lockstep.proceed(_EVENTS_OF_A_GRANT, wall_time()):
                if inbox.waiting or not lockstep.granting or self.over:
                    return
            ended = not lockstep.granting
            if ended and (inbox.waiting or lockstep.ended or lockstep.ready or self.over):
                return
        self._wait()

    def _begins(self, *, prepares: bool) -> bool:
        """Begin a grant, end the run, or take a step of the preparations; return whether commands come next."""
        lockstep = self.lockstep
        # Checked here first, as it is asked for each grant.
        if self._simulator.env.now >= lockstep.nearly_over and lockstep.over:
            self.over = True
            return True
        if lockstep.ready:
            lockstep.begin()
            # Commands that the start of a goal caused, such as an intervention, come before time moves.
            return self._inbox.waiting
        return prepares and not lockstep.participates and next(self._preparations, self) is not self

    def _free_round(self) -> None:
        simulator = self._simulator
        # A bounded number of commands, then of events, so that neither delays the other for long.
        if self._take_commands():
            # Else the thread that sends the answers may wait for this core until all events are processed.
            _yield_core()
        elif simulator.next_event == math.inf:
            self._wait()
            return
        if self._duration < simulator.next_event < math.inf:
            simulator.advance(self._duration)
            self.over = True
        else:
            until = min(self._duration, simulator.limit)
            # One by one: as all of the time is spent here, most queries arrive during an event.
            for _ in range(_EVENTS_OF_A_ROUND):
                if not simulator.process_events(until, 1, idle=False) or self._inbox.waiting or self.over:
                    return

    def _paced_round(self, factor: float) -> None:
        simulator = self._simulator
        woken = wall_time()
        if self._anchor is None:
            self._anchor = woken - simulator.now / factor
        elif (lost := woken - self._awake_by - _MAX_LATENESS) > 0.0:
            self._anchor += lost
            self._lose(lost)
        self._awake_by = woken
        target = min((woken - self._anchor) * factor, self._duration)
        late = (target - simulator.next_due) / factor
        if late > _MAX_LATENESS:
            self._anchor += late
            target -= late * factor
            self._lose(late)
        if simulator.next_due <= target:
            # Only a part, as commands are polled in between.
            simulator.process_events(target, _EVENTS_BETWEEN_POLLS)
        elif target >= self._duration:
            simulator.advance(self._duration)
            self.over = True
            return
        if self._inbox.waiting:
            self._take_waiting(target)
        elif simulator.next_due > target:
            wake = max(min(simulator.next_due, self._duration) / factor + self._anchor, woken + _QUANTUM)
            pause = min(max(0.0, wake - wall_time()), _MAX_WAIT)
            self._awake_by = wall_time() + pause
            self._wait(pause)

    def _wait(self, timeout: float | None = None) -> None:
        """Wait for the next command; without a timeout, time stands meanwhile."""
        self._idle = True
        interest = self._simulator.interest
        if interest.clock and timeout is None:
            self._simulator.settle()
        if interest.time:
            self._publish_state()
        else:
            self._last_state = None
        for call in self._on_wait:
            call()
        self._inbox.wait(timeout)

    def _reach_the_end(self) -> None:
        """Set the time to the end of the run."""
        simulator = self._simulator
        if self._anchor is not None and not simulator.paused:
            # A goal that ends now ends at this time, not at that of the preceding event.
            target = min((wall_time() - self._anchor) * self.real_time_factor, self._duration)
            if simulator.next_due > target:
                simulator.advance(max(target, simulator.now))

    def _take_commands(self, most: int = _COMMANDS_AT_ONCE) -> int:
        """Submit at most so many commands of the inbox; return how many there were.

        Those after a reset wait: before them, lockstep has to begin anew.
        """
        for taken in range(most):
            command = self._inbox.poll()
            if command is None:
                return taken
            if self._retention is not None:
                self._retention.apply(self._simulator)
            self.submit(command)
            if self._generation != self._simulator.generation:
                return taken + 1
        return most

    def _take_waiting(self, target: float) -> None:
        """Submit the next command at the time of its arrival; when time lags, some commands at the time that it is.

        Overdue events do not all come first, as there may be arbitrarily many.
        """
        if self._simulator.next_due > target:
            self._simulator.advance(max(target, self._simulator.now))
            # The next command may be a reaction to the answer, so that it is later.
            self._take_commands(1)
        else:
            self._take_commands()

    def _join(self, command: Join) -> None:
        if self.over or self.clock != LOCKSTEP:
            self._refuse(command)
        else:
            self.lockstep.join(command, wall_time())

    def _advance(self, command: Advance) -> None:
        if self.over:
            # A participant that was thinking at the end gets the same answer as the others.
            self.lockstep.report_end(command)
        elif self.clock != LOCKSTEP:
            self._refuse(command)
        else:
            self.lockstep.advance(command, wall_time())

    def _refuse(self, command: Join | Advance) -> None:
        why = "the simulation has ended" if self.over else f"the clock is {self.clock}; set it to lockstep first"
        self._simulator.answer(command.reply_to, Refused("", None, why))

    def _intervene(self, command: Intervene) -> None:
        self._simulator.finish_instant()
        command.act()

    def _drop_overdue(self, _command: CheckWatchdog) -> None:
        for name in self.lockstep.overdue(wall_time() - self._participant_timeout):
            self.lockstep.drop(name, f"it has not asked to advance for more than {self._participant_timeout:g} s")

    def _set_clock(self, command: SetClock) -> None:
        clock = command.clock or self.clock
        if self._lockstep_only and clock != LOCKSTEP:
            why = f"{clock!r} is not possible within one process: time moves in lockstep only"
            self._simulator.answer(command.reply_to, Refused("clock", clock, why))
            return
        if clock != self.clock:
            self.lockstep.dismiss(f"the clock was set to {clock}")
        self.clock, self._anchor = clock, None
        if command.real_time_factor is not None:
            self.real_time_factor = command.real_time_factor
        self._simulator.answer(command.reply_to, self.state)

    def _lose(self, seconds: float) -> None:
        """Add wall seconds to the lag, and report it at a limited rate."""
        self.lag += seconds
        now = wall_time()
        if now - self._reported >= _BETWEEN_WARNINGS:
            self._reported = now
            self._on_lag(self.lag)

    def _publish_state(self) -> None:
        """Publish the time state, if it has changed."""
        state = self.state
        # Time and epoch change always.
        if self._last_state is None or state._replace(now=0.0, epoch=0) != self._last_state:
            self._last_state = state._replace(now=0.0, epoch=0)
            self._simulator.emit(state)

    def _look_for_overdue(self) -> None:
        if self.clock == LOCKSTEP and self.lockstep.overdue(wall_time() - self._participant_timeout):
            self._inbox.put(CheckWatchdog())


def unwatched(_simulator: Simulator, _pacing: Pacing) -> Sequence[Sink]:
    """Return no further sinks."""
    return ()


def watch_over(look: Callable[[], None], interval: float, over: threading.Event) -> None:
    """Call a function every *interval* wall seconds until *over*, as the simulation's thread waits for commands.

    After the process was stopped, as by SIGSTOP or a debugger, it does not call it before all that has waited
    meanwhile has had its time: as much as `_LOOKS` intervals.
    """
    looked, resumed = wall_time(), -math.inf
    while not over.wait(interval):
        now = wall_time()
        if now - looked > 2 * interval + _MAX_LATENESS:
            resumed = now
        looked = now
        if now - resumed >= _LOOKS * interval:
            with suppress(SimulationStopped):
                look()

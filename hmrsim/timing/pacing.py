"""How simulated time moves: with the wall, as fast as possible, or as far as its controllers allow.

Commands are taken from the inbox between events. With the wall they are stamped with the simulated time of that
moment; when the machine can't keep up, time lags behind the wall and says so, it never leaps.
"""

from __future__ import annotations

import logging
import math
import threading
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from hmrsim.engine.wall_clock import wall_time
from hmrsim.errors import SimulationStopped
from hmrsim.protocol.gateway import PlanAnswered, Refused, Topic
from hmrsim.protocol.time import (
    LOCKSTEP,
    REALTIME,
    Advance,
    Granted,
    Join,
    Leave,
    LookAround,
    ReadTime,
    SetClock,
    TimeCommand,
    TimeState,
    TokenSeen,
)
from hmrsim.timing.lockstep import LockstepCoordinator

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from hmrsim.protocol.gateway import AnyCommand, Inbox
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.result_retention import Retention

_log = logging.getLogger(__name__)

PLANNER: Final = "_planner"
"""Stands among those whom time waits for, in lockstep, while a planner outside has not answered."""

_EVENTS_BETWEEN_POLLS = 16
"""Events that are taken between two looks into the inbox: a look costs little, an event a microsecond or more."""

_EVENTS_OF_A_GRANT = 64
"""Likewise while time is granted: all who could be kept waiting wait for the grant."""

_BETWEEN_WARNINGS = 5.0
"""Wall seconds from one word about lag to the next."""

_QUANTUM = 0.005
"""Wall seconds from one round of events to the next, where they are many: to wake, and to send a message that goes
alone, costs more than to do the work. What is due in between comes as much late, a command never."""

_MAX_WAIT = 3600.0
"""Wall seconds that are waited at once: there is no end to what a wait of simulated seconds may take."""

_MAX_LATENESS = 0.1
"""Wall seconds that an event may be late before time gives up catching up."""

_LOOKS = 5
"""Looks for a participant that stalls, in the time that it is given."""


@dataclass
class Pacing:
    """Lets a simulator's time move until its inbox is closed.

    Attributes:
        simulator: What to run.
        inbox: Where commands come from.
        retention: Drops old results.
        clock: How time moves: ``realtime`` or ``lockstep``.
        real_time_factor: Simulated seconds a wall second in real time; 0 for as fast as possible.
        duration: Simulated seconds after which to end.
        participants: How many have to join before time moves in lockstep, or their names.
        participant_timeout: Wall seconds that one of them may take from a grant to the next request.
        end_on_loss: Whether the run ends when one of them is lost.
        on_lag: Told how many wall seconds time has lost in all, when it loses some; not more often than every 5 s.
        on_wait: Called, each, whenever there is nothing to do but to wait.
        preparations: What will be of use; done bit by bit, in lockstep, while nobody lets time move.
        lag: Wall seconds that time has lost.
    """

    simulator: Simulator
    inbox: Inbox
    retention: Retention
    clock: str = REALTIME
    real_time_factor: float = 1.0
    duration: float = math.inf
    participants: int | Collection[str] = 1
    participant_timeout: float = math.inf
    end_on_loss: bool = False
    on_lag: Callable[[float], None] = lambda _lag: None
    on_wait: list[Callable[[], None]] = field(default_factory=list)
    preparations: Iterator[object] = field(default_factory=lambda: iter(()))
    lag: float = 0.0
    _told: float = field(default=-math.inf, init=False)
    _anchor: float | None = field(default=None, init=False)
    _over: bool = field(default=False, init=False)
    _last_state: TimeState | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        """Follow what happens in the simulation."""
        self._generation = self.simulator.generation
        self._lockstep = LockstepCoordinator(self.simulator, awaited=self.participants, until=self.duration)
        self.simulator.gate.hindrance = self._hindrance
        self.simulator.attach(self._lockstep)

    def run(self) -> None:
        """Run until the inbox is closed or the duration is over; goals that run then are left to `Simulator.stop`."""
        try:
            with self._watching():
                while not (self.inbox.closed or self._over):
                    self._round()
            self._reach_the_end()
        finally:
            # Whatever it is that ends it, whoever waits for time to move is answered.
            self._over = True
            self._lockstep.dismiss("the simulator was stopped")

    def submit(self, command: AnyCommand) -> None:
        """Apply a command now, in the simulation's thread."""
        if isinstance(command, TimeCommand):
            self._apply(command)
        elif isinstance(command, PlanAnswered) and self.clock == LOCKSTEP:
            self.simulator.plans.keep(command)
        else:
            self.simulator.submit(command)

    @property
    def state(self) -> TimeState:
        """How time moves just now."""
        lockstep = self.clock == LOCKSTEP
        planner = (PLANNER,) if self.simulator.plans.awaited else ()
        return TimeState(
            now=self.simulator.now,
            clock=self.clock,
            real_time_factor=self.real_time_factor,
            paused=self.simulator.limit < math.inf,
            epoch=self._lockstep.epoch,
            participants=self._lockstep.participants,
            waiting_for=(*self._lockstep.waiting_for, *planner) if lockstep else (),
            lag=self.lag,
        )

    def _hindrance(self) -> str:
        if self.clock == LOCKSTEP and not self._lockstep.participants:
            return "nobody takes part in lockstep, so that time stands; let somebody join, or set the clock to realtime"
        return ""

    # --- rounds ---------------------------------------------------------------------------------------------------

    def _round(self) -> None:
        simulator = self.simulator
        if self._generation != simulator.generation:
            self._generation, self._anchor = simulator.generation, None
            self._lockstep.restart()
        if self.clock == LOCKSTEP:
            self._lockstep_round()
        elif simulator.paused:
            self._anchor = None
            self._stand()
        elif self.real_time_factor == 0 or simulator.limit < math.inf:
            # Steps are made as fast as possible, too.
            self._anchor = None
            self._free_round()
        else:
            self._paced_round(self.real_time_factor)

    def _lockstep_round(self) -> None:
        lockstep = self._lockstep
        if self._take_commands():
            return
        if lockstep.granting:
            if lockstep.proceed(_EVENTS_OF_A_GRANT, wall_time()) or not lockstep.granting:
                return
        elif lockstep.over:
            self._over = True
            return
        elif lockstep.ready:
            lockstep.begin()
            return
        elif not lockstep.participants and next(self.preparations, self) is not self:
            return
        self._stand()

    def _free_round(self) -> None:
        simulator = self.simulator
        # Neither keeps the other waiting: so many commands at most, then so many events.
        taken = self._take_commands()
        if not taken and simulator.next_event == math.inf:
            self._stand()
        elif self.duration < simulator.next_event < math.inf:
            simulator.advance(self.duration)
            self._over = True
        else:
            simulator.take(min(self.duration, simulator.limit), _EVENTS_BETWEEN_POLLS, idle=False)

    def _paced_round(self, factor: float) -> None:
        simulator = self.simulator
        woken = wall_time()
        if self._anchor is None:
            self._anchor = woken - simulator.now / factor
        target = min((woken - self._anchor) * factor, self.duration)
        late = (target - simulator.next_due) / factor
        if late > _MAX_LATENESS:
            self._anchor += late
            target -= late * factor
            self._lose(late)
        if simulator.next_due <= target:
            # Some of it: commands are looked for in between.
            simulator.take(target, _EVENTS_BETWEEN_POLLS)
        elif target >= self.duration:
            simulator.advance(self.duration)
            self._over = True
            return
        if self.inbox.waiting:
            self._take_waiting(target)
        elif simulator.next_due > target:
            wake = max(min(simulator.next_due, self.duration) / factor + self._anchor, woken + _QUANTUM)
            self._wait(None if wake == math.inf else min(max(0.0, wake - wall_time()), _MAX_WAIT))

    def _stand(self) -> None:
        """Wait for the next command, however long that takes."""
        if not self._take_commands():
            self.simulator.settle()
            self._wait(None)

    def _wait(self, timeout: float | None) -> None:
        self._tell()
        for call in self.on_wait:
            call()
        self.inbox.wait(timeout)

    def _reach_the_end(self) -> None:
        """Let it be the time at which the run ends."""
        simulator = self.simulator
        if self._anchor is not None and not simulator.paused:
            # Whatever ends now ends at this time, not at that of the event before.
            target = min((wall_time() - self._anchor) * self.real_time_factor, self.duration)
            if simulator.next_due > target:
                simulator.advance(max(target, simulator.now))

    # --- commands -------------------------------------------------------------------------------------------------

    def _take_command(self) -> bool:
        """Submit the next command in the inbox; return whether there was one.

        Only one: the next may come of its answer, and is later than this one.
        """
        command = self.inbox.poll()
        if command is None:
            return False
        self.retention.apply(self.simulator)
        self.submit(command)
        return True

    def _take_commands(self) -> int:
        """Submit some commands; return how many."""
        taken = 0
        while taken < _EVENTS_BETWEEN_POLLS and self._take_command():
            taken += 1
        return taken

    def _take_waiting(self, target: float) -> None:
        """Submit the next command at the time of its arrival; when time lags, some commands at the time that it is.

        What is overdue does not come before them all, as there may be no end to it.
        """
        if self.simulator.next_due > target:
            self.simulator.advance(max(target, self.simulator.now))
            self._take_command()
        else:
            self._take_commands()

    def _apply(self, command: TimeCommand) -> None:
        """Apply a command that is about time, not about the world."""
        lockstep = self._lockstep
        match command:
            case ReadTime(reply_to):
                self.simulator.answer(reply_to, self.state)
            case SetClock():
                self._set_clock(command)
            case Join() | Advance():
                self._let_move(command)
            case Leave():
                lockstep.leave(command)
            case TokenSeen(name, alive):
                lockstep.token_seen(name, alive=alive)
            case LookAround():
                for name in lockstep.overdue(wall_time() - self.participant_timeout):
                    lockstep.drop(name, f"it has not asked to advance for more than {self.participant_timeout:g} s")
        if self.end_on_loss and lockstep.lost:
            self._over = True

    def _let_move(self, command: Join | Advance) -> None:
        if self._over and isinstance(command, Advance):
            # Whoever was thinking when it ended learns of it as the others have.
            self.simulator.answer(command.reply_to, Granted(self._lockstep.epoch, self.simulator.now, "end"))
        elif self._over or self.clock != LOCKSTEP:
            why = "the simulation has ended" if self._over else f"the clock is {self.clock}; set it to lockstep first"
            self.simulator.answer(command.reply_to, Refused("", None, why))
        elif isinstance(command, Join):
            self._lockstep.join(command, wall_time())
        else:
            self._lockstep.advance(command, wall_time())

    def _set_clock(self, command: SetClock) -> None:
        clock = command.clock or self.clock
        if clock != self.clock:
            self._lockstep.dismiss(f"the clock was set to {clock}")
        self.clock, self._anchor = clock, None
        if command.real_time_factor is not None:
            self.real_time_factor = command.real_time_factor
        self.simulator.answer(command.reply_to, self.state)

    # --- what is told ---------------------------------------------------------------------------------------------

    def _lose(self, seconds: float) -> None:
        """Count wall seconds that time lags, and tell, but not every time."""
        self.lag += seconds
        now = wall_time()
        if now - self._told >= _BETWEEN_WARNINGS:
            self._told = now
            self.on_lag(self.lag)

    def _tell(self) -> None:
        """Tell how time moves, if that has changed and somebody listens."""
        if not self.simulator.interest.in_(Topic.TIME):
            self._last_state = None
            return
        state = self.state
        # Time and epoch change always.
        if self._last_state is None or state._replace(now=0.0, epoch=0) != self._last_state:
            self._last_state = state._replace(now=0.0, epoch=0)
            self.simulator.tell(state)

    def _watching(self) -> _Watch:
        def look() -> None:
            if self.clock == LOCKSTEP and self._lockstep.overdue(wall_time() - self.participant_timeout):
                self.inbox.put(LookAround())

        return _Watch(look, self.participant_timeout / _LOOKS)


class _Watch:
    """Looks again and again in a thread of its own: who waits for a command has no other alarm."""

    def __init__(self, look: Callable[[], None], interval: float) -> None:
        self._look = look
        self._interval = interval
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="hmrsim-watch", daemon=True)

    def __enter__(self) -> None:
        if self._interval < math.inf:
            self._thread.start()

    def __exit__(self, *_error: object) -> None:
        self._over.set()

    def _run(self) -> None:
        while not self._over.wait(self._interval):
            with suppress(SimulationStopped):
                self._look()

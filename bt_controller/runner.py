"""Running trees: they are ticked when something happened, and each period of simulated time.

All trees of a runner are ticked by one thread, one after the other, in the robots' order. What other threads
hear (a goal's verdict, feedback, the clock) only wakes it.

Two things of py_trees to know: its timers count wall time, and a ``Parallel`` whose policy does not synchronise
ticks finished children again, so that their goals are sent again.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from py_trees.common import Status

from bt_controller.directory import Directory
from bt_controller.mailbox import CLOCK, STOP, Mailbox
from bt_controller.sim_clock import SimClock

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from bt_controller.mission import Mission
    from bt_controller.snapshot import Snapshot
    from hmrsim_zenoh.client import Client

_LOOK_AROUND: Final = 0.5
"""Wall seconds after which the runner looks whether the simulator is there, when nothing else wakes it."""

_LAST_WORDS: Final = 0.5
"""Wall seconds that canceled goals have to end when a behaviour blocks."""


@dataclass(frozen=True)
class Outcome:
    """How the trees ended.

    Attributes:
        statuses: By robot, the root's status; RUNNING where the tree was stopped.
        interrupted: Whether the user stopped it.
        gone: Whether it was given up because the simulator is gone.
        left: The robots of which a goal has not ended yet: it is being canceled, as far as we know.
    """

    statuses: dict[str, Status]
    interrupted: bool = False
    gone: bool = False
    left: tuple[str, ...] = ()

    @property
    def succeeded(self) -> bool:
        """Whether every tree succeeded."""
        return all(status is Status.SUCCESS for status in self.statuses.values())

    def to_json(self) -> dict[str, Any]:
        """Return the outcome as JSON has it."""
        return {
            "succeeded": self.succeeded,
            "interrupted": self.interrupted,
            "gone": self.gone,
            "robots": {robot: status.value for robot, status in self.statuses.items()},
            "left": list(self.left),
        }


class Runner:
    """Runs a tree for each of some robots until all trees have ended.

    Args:
        client: The connection to the simulator; stays open.
        missions: The robots and their trees.
        show: Called with each tree after each tick of it.
        period: Simulated seconds between ticks when nothing happens.
        mailbox: Where to put `STOP` to end it.
        grace: Wall seconds for which the simulator may be out of reach, and in which canceled goals may end.
    """

    def __init__(
        self,
        client: Client,
        missions: Sequence[Mission],
        *,
        show: Callable[[Snapshot], None],
        period: float = 1.0,
        mailbox: Mailbox | None = None,
        grace: float = 3.0,
    ) -> None:
        self._client = client
        self._missions = missions
        self._show = show
        self._period = period
        self._mailbox = mailbox or Mailbox()
        self._grace = grace
        self._absent_since: float | None = None

    def run(self) -> Outcome:
        """Set the trees up and tick them until all have ended; whatever ends that, no goal is left behind.

        Raises:
            NotServed: The simulator lacks a robot or an action.
            NobodyThere, SimulatorGone, Unreachable: It does not say what it has.
            TreeCrashed: A behaviour raised an error.
        """
        directory = Directory.from_info(self._client.info())
        clock = SimClock(self._client, self._period, partial(self._mailbox.put, CLOCK))
        try:
            for mission in self._missions:
                mission.setup(self._client, directory, partial(self._mailbox.put, mission.robot))
            outcome = self._follow(clock)
        finally:
            for mission in self._missions:
                mission.interrupt()
            self._settle(self._grace)
            for mission in self._missions:
                mission.shutdown()
            clock.close()
        return self._with_left(outcome)

    def give_up(self) -> Outcome:
        """Cancel the goals while a behaviour keeps the trees' own thread from it; from another thread."""
        for mission in self._missions:
            mission.cancel()
        # Nobody has taken what is in there, such as what asked for the end.
        self._mailbox.wait(0.0)
        self._settle(_LAST_WORDS)
        return self._with_left(self._outcome(interrupted=True))

    def _follow(self, clock: SimClock) -> Outcome:
        self._tick(self._missions, clock)
        while not all(mission.over for mission in self._missions):
            woken = self._mailbox.wait(_LOOK_AROUND)
            if STOP in woken:
                return self._outcome(interrupted=True)
            if self._gone():
                # Their goals have failed by now, and what waits for something else would wait for ever.
                self._tick(self._missions, clock)
                return self._outcome(gone=True)
            self._tick([each for each in self._missions if CLOCK in woken or each.robot in woken], clock)
        return self._outcome()

    def _with_left(self, outcome: Outcome) -> Outcome:
        return replace(outcome, left=tuple(mission.robot for mission in self._missions if mission.open_goals))

    def _outcome(self, *, interrupted: bool = False, gone: bool = False) -> Outcome:
        return Outcome({mission.robot: mission.status for mission in self._missions}, interrupted, gone)

    def _tick(self, missions: Iterable[Mission], clock: SimClock) -> None:
        for mission in missions:
            while not mission.over:
                mission.tick()
                self._show(mission.snapshot(clock.now))
                if mission.status is Status.RUNNING:
                    break

    def _gone(self) -> bool:
        """Return whether the simulator has been out of reach for longer than a router takes to restart."""
        if self._client.alive:
            self._absent_since = None
            return False
        now = time.monotonic()
        if self._absent_since is None:
            self._absent_since = now
        return now - self._absent_since >= self._grace

    def _settle(self, seconds: float) -> None:
        """Wait until the canceled goals have ended: a session closed too soon could lose a cancel on its way."""
        until = time.monotonic() + seconds
        while any(mission.open_goals for mission in self._missions):
            left = until - time.monotonic()
            if left <= 0 or STOP in self._mailbox.wait(left):
                return

"""Running trees: they are ticked when something happened, or when one of them has to be.

All trees of a runner are ticked by one thread, one after the other, in the robots' order. What other threads
hear (a goal's verdict, feedback, the clock) only wakes it. Its clock says how time goes by.

A thing of py_trees to know: a ``Parallel`` whose policy does not synchronise ticks finished children again, so that
their goals are sent again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from py_trees.common import Status

from bt_controller.directory import Directory
from bt_controller.due import due, next_period
from bt_controller.mailbox import STOP
from bt_controller.places import NamedPlaces
from bt_controller.topics import Topics
from hmrsim_zenoh.errors import Idle, NobodyThere, SimulatorGone

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from bt_controller.clocks import Clock
    from bt_controller.mailbox import Mailbox
    from bt_controller.mission import Mission
    from bt_controller.snapshot import Snapshot
    from hmrsim_zenoh.client import Client

_PERIOD: Final = 1.0
"""Simulated seconds between looks at what nobody tells us."""

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
        clock: Its time; closed in the end.
        mailbox: Where to put `STOP` to end it; the clock's.
        show: Called with each tree after each tick of it.
        period: Simulated seconds between ticks of every tree; None to tick where it is needed only.
        grace: Wall seconds in which canceled goals may end.
    """

    def __init__(
        self,
        client: Client,
        missions: Sequence[Mission],
        clock: Clock,
        mailbox: Mailbox,
        *,
        show: Callable[[Snapshot], None],
        period: float | None = None,
        grace: float = 3.0,
    ) -> None:
        self._client = client
        self._missions = missions
        self._clock = clock
        self._mailbox = mailbox
        self._show = show
        self._period = period
        self._grace = grace
        self._dues = dict.fromkeys((mission.robot for mission in missions), math.inf)

    def run(self) -> Outcome:
        """Set the trees up and tick them until all have ended; whatever ends that, no goal is left behind.

        Raises:
            NotServed: The simulator lacks a robot or an action.
            NobodyThere, SimulatorGone, Unreachable: It does not say what it has.
            TreeCrashed: A behaviour raised an error.
            Idle: A tree waits for what can't happen.
            Dropped: The simulator goes on without us.
        """
        topics = Topics(self._client, asks=self._client.lockstep is not None)
        places = NamedPlaces(self._client)
        try:
            known = {"directory": Directory.from_info(self._client.info()), "topics": topics, "places": places}
            for mission in self._missions:
                mission.setup(self._client, partial(self._mailbox.put, mission.robot), **known)
            outcome = self._follow()
        finally:
            for mission in self._missions:
                mission.interrupt()
            self._clock.settle(self._settled, self._grace)
            for mission in self._missions:
                mission.shutdown()
            topics.close()
            self._clock.close()
        return self._with_left(outcome)

    def give_up(self) -> Outcome:
        """Cancel the goals while a behaviour keeps the trees' own thread from it; from another thread."""
        for mission in self._missions:
            mission.cancel()
        # Nobody has taken what is in there, such as what asked for the end.
        self._mailbox.wait(0.0)
        self._clock.settle(self._settled, _LAST_WORDS)
        outcome = self._with_left(self._outcome(interrupted=True))
        self._clock.close()
        return outcome

    def _follow(self) -> Outcome:
        before = self._tick(self._missions)
        while not all(mission.over for mission in self._missions):
            try:
                woken = self._clock.wait(self._until())
            except (NobodyThere, SimulatorGone):
                # Their goals have failed by now, and what waits for something else would wait for ever.
                self._tick(self._missions)
                return self._outcome(gone=True)
            except Idle as error:
                waiting = ", ".join(mission.robot for mission in self._missions if not mission.over)
                raise Idle(f"{error}; what the trees of {waiting} wait for can't happen") from None
            if STOP in woken:
                return self._outcome(interrupted=True)
            now = self._clock.now
            # Time that went back has been reset, and no deadline of the time before will come.
            back = now is not None and before is not None and now < before
            before = self._tick(
                [each for each in self._missions if back or each.robot in woken or self._is_due(each, now)]
            )
        return self._outcome()

    def _until(self) -> float | None:
        """Return when the next tree has to be ticked; None for when something happens."""
        earliest = min(self._dues[mission.robot] for mission in self._missions if not mission.over)
        return None if earliest == math.inf else earliest

    def _is_due(self, mission: Mission, now: float | None) -> bool:
        return now is not None and now >= self._dues[mission.robot]

    def _tick(self, missions: Iterable[Mission]) -> float | None:
        """Tick trees; return the time at which it was."""
        now = self._clock.now
        for mission in missions:
            while not mission.over:
                mission.tick(now)
                self._show(mission.snapshot(now))
                if mission.status is Status.RUNNING:
                    self._dues[mission.robot] = self._due(mission, now)
                    break
        return now

    def _due(self, mission: Mission, now: float | None) -> float:
        if now is None:
            return math.inf
        needed = due(mission.root, now, self._period or _PERIOD)
        return needed if self._period is None else min(needed, next_period(now, self._period))

    def _settled(self) -> bool:
        return not any(mission.open_goals for mission in self._missions)

    def _with_left(self, outcome: Outcome) -> Outcome:
        return replace(outcome, left=tuple(mission.robot for mission in self._missions if mission.open_goals))

    def _outcome(self, *, interrupted: bool = False, gone: bool = False) -> Outcome:
        return Outcome({mission.robot: mission.status for mission in self._missions}, interrupted, gone)

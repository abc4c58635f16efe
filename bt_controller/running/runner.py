"""Running trees: they are ticked when something happened, or when one of them has to be.

One thread ticks all trees of a runner, one after the other. Other threads, which receive results, feedback and the
clock, only wake it. The runner's clock moves time. The trees with an event at one instant are ticked in the missions'
order, and no other tree is touched: the cost of a thousand robots is that of their events.

A thing of py_trees to know: a ``Parallel`` whose policy does not synchronize ticks finished children again, so that
their goals are sent again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from py_trees.common import Status

from bt_controller.core.robots import Directory, Topics
from bt_controller.running.clocks import RESET, STOP, Mailbox, clock_for
from bt_controller.running.mission import missions_for
from bt_controller.running.schedule import POLL_SECONDS, Alarms, TimerQueue, next_period
from bt_controller.running.snapshot import nodes_of, reasons, tip
from hmrsim_zenoh.errors import Idle, SimulatorGone, SimulatorNotFound

if TYPE_CHECKING:
    from bt_controller.coverage import TreeCoverage
    from bt_controller.loading.trees import Plan
    from bt_controller.running.clocks import Clock
    from bt_controller.running.mission import Mission
    from hmrsim_zenoh.client.client import Client


_MAX_TURNS: Final = 10
"""Ticks of one tree at one instant, if each of them writes something new."""

_LAST_WORDS: Final = 0.5
"""Wall seconds that canceled goals have to end when a behavior blocks."""


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run of trees.

    Attributes:
        statuses: By robot, the root's status; RUNNING where the tree was stopped.
        interrupted: Whether the user stopped it.
        gone: Whether the run ended because the simulator is gone.
        left: The robots with a goal that has not ended yet, although its cancellation was requested.
        reasons: By robot whose tree failed, the behaviors that made it fail; where it had not ended, the one that was
            running. Each with its ``node``, its ``message`` and, if it comes from a file, its ``origin`` there.
    """

    statuses: dict[str, Status]
    interrupted: bool = False
    gone: bool = False
    left: tuple[str, ...] = ()
    reasons: Mapping[str, Sequence[Mapping[str, str]]] = field(default_factory=dict)

    @property
    def succeeded(self) -> bool:
        """True if every tree succeeded."""
        return all(status is Status.SUCCESS for status in self.statuses.values())

    def why(self, robot: str) -> str:
        """Return why the tree of a robot failed, or what was running, in words; empty if it has succeeded."""
        reasons = self.reasons.get(robot, ())
        return "; ".join(map(_in_words, reasons))

    def to_json(self) -> dict[str, Any]:
        """Return the outcome as JSON values."""
        return {
            "succeeded": self.succeeded,
            "interrupted": self.interrupted,
            "gone": self.gone,
            "robots": {robot: status.value for robot, status in self.statuses.items()},
            "left": list(self.left),
            "reasons": {robot: list(reasons) for robot, reasons in self.reasons.items()},
        }


class Runner:
    """Runs a tree for each of some robots until all trees have ended.

    Args:
        client: The connection to the simulator; stays open.
        missions: The robots and their trees.
        clock: Its time; closed in the end.
        mailbox: Where to put `STOP` to end it; the clock's.
        show: Called after each tick of a tree with its mission and the simulated time, or None. The display takes
            a snapshot then, or later.
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
        show: Callable[[Mission, float | None], None] | None,
        period: float | None = None,
        grace: float = 3.0,
    ) -> None:
        self._client = client
        self._missions = missions
        self._clock = clock
        self._mailbox = mailbox
        self._show = show
        self._period = period
        self._polls = period or POLL_SECONDS
        self._grace = grace
        self._numbers = {mission.robot: number for number, mission in enumerate(missions)}
        self._running = set(self._numbers.values())
        self._timers = TimerQueue()
        self._timed = False
        self._topics = Topics(client, asks=client.lockstep is not None)
        stops = client.lockstep if period is None else None
        self._alarms = Alarms(stops, self._topics, mailbox.put) if stops is not None else None

    def run(self) -> Outcome:
        """Set the trees up and tick them until all have ended; whatever ends that, no goal is left behind.

        Raises:
            NotServed: The simulator lacks a robot or an action.
            SimulatorNotFound, SimulatorGone, Unreachable: It does not say what it has.
            TreeCrashed: A behavior raised an error.
            Idle: A tree waits for what can't happen.
            Dropped: The simulator goes on without this client.
        """
        places = self._client.places
        try:
            known = {"directory": Directory.from_info(self._client.info()), "topics": self._topics, "places": places}
            for mission in self._missions:
                mission.setup(self._client, partial(self._mailbox.put, mission.robot), **known)
            outcome = self._follow()
        finally:
            for mission in self._missions:
                mission.interrupt(self._clock.elapsed)
            unsettled = [*self._missions]
            self._clock.settle(partial(_settled, unsettled), self._grace)
            for mission in self._missions:
                mission.shutdown()
            self._topics.close()
            self._clock.close()
        return _with_left(outcome, unsettled)

    def give_up(self) -> Outcome:
        """Cancel the goals from another thread, while a behavior blocks the thread of the trees."""
        for mission in self._missions:
            mission.cancel()
        # The mailbox may still hold reasons, such as the one that requested the end.
        self._mailbox.wait(0.0)
        unsettled = [*self._missions]
        self._clock.settle(partial(_settled, unsettled), _LAST_WORDS)
        outcome = _with_left(self._outcome(interrupted=True), unsettled)
        self._clock.close()
        return outcome

    def _follow(self) -> Outcome:
        try:
            return self._outcome(interrupted=self._stopped())
        except (SimulatorNotFound, SimulatorGone):
            # Their goals have failed by now, and nodes that wait for something else would wait forever.
            for mission in self._missions:
                mission.end_coverage()
            with suppress(SimulatorNotFound, SimulatorGone):
                self._tick(self._numbers.values(), self._clock.elapsed)
            return self._outcome(gone=True)
        except Idle as error:
            waiting = ", ".join(mission.robot for mission in self._missions if not mission.over)
            raise Idle(f"{error}; what the trees of {waiting} wait for can't happen") from None

    def _stopped(self) -> bool:
        """Tick the trees until all have ended or the user stops them; return whether the user did."""
        self._tick(self._numbers.values(), self._clock.elapsed)
        while self._running:
            earliest = self._timers.earliest
            woken = self._clock.wait(None if earliest == math.inf else earliest)
            if STOP in woken:
                return True
            time = self._clock.elapsed
            self._tick(self._whose_turn(woken, time), time)
        return False

    def _whose_turn(self, woken: frozenset[str], time: float | None) -> Iterable[int]:
        """Return the numbers of the trees that have to be ticked."""
        if RESET in woken and self._alarms is not None:
            self._alarms.clear()
        if RESET in woken or (time is not None and not self._timed):
            # After a reset, and before the first clock message, the state of their goals and timers is unknown.
            return self._numbers.values()
        due_now = [] if time is None else self._timers.pop_due(time)
        return sorted({*due_now, *map(self._numbers.__getitem__, woken & self._numbers.keys())})

    def _tick(self, numbers: Iterable[int], time: float | None) -> None:
        """Tick trees, with a time that never goes back, so that timers keep their durations after a reset."""
        now = None if self._show is None else self._clock.now
        # Events since then may have changed a topic, even if no time has passed.
        self._topics.forget()
        self._timed = time is not None
        for number in numbers:
            mission, turns = self._missions[number], 0
            while not mission.over:
                mission.tick(time, self._polls)
                turns += 1
                if self._show is not None:
                    self._show(mission, now)
                if mission.status is Status.RUNNING:
                    needed, awaited = mission.due
                    if self._period is not None and time is not None:
                        needed = min(needed, next_period(time, self._period))
                    # A write may change the result of polled nodes, which then need not wait for a period.
                    again = needed != math.inf and mission.changed_entries and turns < _MAX_TURNS
                    if again and time is not None and needed <= next_period(time, self._polls):
                        continue
                    self._timers.put(number, needed)
                    if self._alarms is not None:
                        self._alarms.set(mission.robot, awaited)
                    break
            if mission.over:
                self._running.discard(number)
                self._timers.put(number, math.inf)
                if self._alarms is not None:
                    self._alarms.set(mission.robot, ())

    def _outcome(self, *, interrupted: bool = False, gone: bool = False) -> Outcome:
        statuses = {mission.robot: mission.status for mission in self._missions}
        unfit = (Status.FAILURE, Status.RUNNING)
        why = {mission.robot: _reasons(mission) for mission in self._missions if mission.status in unfit}
        return Outcome(statuses, interrupted, gone, reasons=why)


def _settled(missions: list[Mission]) -> bool:
    """Return whether the canceled goals have ended; remove trees whose goals have from the end of the list."""
    while missions and not missions[-1].open_goals:
        missions.pop()
    return not missions


def _with_left(outcome: Outcome, unsettled: Sequence[Mission]) -> Outcome:
    left = [mission.robot for mission in unsettled if mission.open_goals]
    return replace(outcome, left=tuple(left)) if left else outcome


def _reasons(mission: Mission) -> list[dict[str, str]]:
    nodes = nodes_of(mission.root)
    return [
        {"node": node.name, "message": node.message, **({"origin": node.origin} if node.origin else {})}
        for node in (reasons(nodes) or (tip(nodes),))
    ]


def _in_words(reason: Mapping[str, str]) -> str:
    node = f"{reason['node']} ({reason['origin']})" if "origin" in reason else reason["node"]
    return f"{node}: {reason['message']}" if reason["message"] else node


_GRACE = 3.0
"""Wall seconds for which the simulator may be unreachable, and within which canceled goals have to end."""


def run_tree(
    client: Client,
    plan: Plan,
    robots: Sequence[str],
    *,
    period: float | None = None,
    show: Callable[[Mission, float | None], None] | None = None,
    coverage: TreeCoverage | None = None,
) -> Outcome:
    """Run a tree for each robot, or one tree for all robots if it is for a fleet, and return the outcome.

    Args:
        client: The connection to the simulator; stays open.
        plan: The tree, as `bt_controller.loading.trees.load` returns it.
        robots: The names of the robots.
        period: Simulated seconds between ticks of every tree; None to tick where it is needed only.
        show: Called after each tick of a tree with its mission and the simulated time, or None.
        coverage: Counts the outcomes of the trees' nodes; None for no counting.

    Raises:
        TreeError: The tree can't be built.
        NotServed: The simulator lacks a robot or an action.
        SimulatorNotFound, SimulatorGone, Unreachable: No simulator answers.
        TreeCrashed: A behavior raised an error.
        Idle: A tree waits for what can't happen.
        Dropped: The simulator goes on without this client.
    """
    missions = missions_for(robots, plan, coverage=coverage)
    feedback = period is not None or any(mission.wants_feedback for mission in missions)
    mailbox = Mailbox()
    clock = clock_for(client, mailbox, feedback=feedback, grace=_GRACE)
    return Runner(client, missions, clock, mailbox, show=show, period=period, grace=_GRACE).run()

"""The events of goals in lockstep: what has happened since the last grant, of which participants are told with it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Final

from hmrsim.engine.sim_time import stamp
from hmrsim.protocol.commands import InterestChanged
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged, GoalTold

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Advance
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.participants import Told

NO_KINDS: Final[frozenset[str]] = frozenset()
"""Of participants that want to be told of nothing."""


class GoalEvents:
    """The events since the last grant, in the order in which participants are told of them.

    Args:
        on_event: Called with the kind of each that is recorded: `status`, `result` or `feedback`.
    """

    def __init__(self, simulator: Simulator, on_event: Callable[[str], None]) -> None:
        self._simulator = simulator
        self._on_event = on_event
        self._kinds = NO_KINDS
        self._events: list[Told] = []
        self._withheld: list[GoalChanged] = []

    @property
    def all(self) -> tuple[Told, ...]:
        """All of them."""
        return tuple(self._events)

    @property
    def samples(self) -> bool:
        """Whether feedback is recorded."""
        return "feedback" in self._kinds

    def record(self, kinds: frozenset[str]) -> None:
        """Record events of these kinds from now on."""
        if (kinds ^ self._kinds) & {"feedback"}:
            self._kinds = kinds
            self._simulator.submit(InterestChanged())
        self._kinds = kinds

    def record_nothing(self) -> None:
        """Record no more, as nobody takes part."""
        self._kinds = NO_KINDS
        self._events.clear()
        self._simulator.submit(InterestChanged())

    def any_of(self, kinds: frozenset[str]) -> bool:
        """Return whether there is an event of one of these kinds."""
        return any(kind in kinds for kind, _, _ in self._events)

    def wanted(self, advance: Advance) -> tuple[Told, ...]:
        """Return those of which a participant wants to be told."""
        wanted = kinds_wanted(advance)
        return tuple(event for event in self._events if event[0] in wanted)

    def sampled(self, advances: Iterable[Advance]) -> list[Told]:
        """Return the feedback of this instant, if a participant asks to have it reported without waking for it."""
        if not any("feedback" in advance.report - advance.wake for advance in advances):
            return []
        now = stamp(self._simulator.now)
        return [("feedback", now, feedback) for feedback in self._simulator.dispatcher.feedback.current()]

    def sort(self) -> None:
        """Put samples of one instant into the order of robots, as other subscribers could change theirs."""
        ordered: list[Told] = []
        for (kind, _), group in itertools.groupby(self._events, key=lambda event: event[:2]):
            found = list(group)
            if kind == "feedback":
                found.sort(key=lambda event: (event[2].robot, event[2].action, event[2].goal_id))
            ordered += found
        self._events = ordered

    def clear(self) -> None:
        """Forget all events, as participants have been told of them."""
        self._events.clear()

    def note_news(self, news: GoalChanged | GoalTold) -> None:
        """Record a change of a goal when participants may know it."""
        if isinstance(news, GoalTold):
            self._note_change(news.change)
        elif news.robot not in self._simulator.dispatcher.news:
            self._note_change(news)

    def note_feedback(self, feedback: FeedbackSent) -> None:
        """Record a sample of the feedback of a goal."""
        if self.samples:
            self._note("feedback", stamp(self._simulator.now), feedback)

    def note_withheld(self) -> None:
        """Record the withheld changes of goals of robots that are connected again."""
        withheld, self._withheld = self._withheld, []
        for event in withheld:
            self._note_change(event)

    def _note_change(self, event: GoalChanged) -> None:
        if event.robot in self._simulator.dispatcher.cut_off:
            self._withheld.append(event)
            return
        if "status" in self._kinds:
            self._note("status", event.stamp, event)
        if event.result is not None and "result" in self._kinds:
            self._note("result", event.stamp, event)

    def _note(self, kind: str, at: int, event: GoalChanged | FeedbackSent) -> None:
        self._events.append((kind, at, event))
        self._on_event(kind)


def kinds_wanted(advance: Advance) -> frozenset[str]:
    """Return the kinds of events that a participant is told of as they come."""
    return advance.wake | (advance.report - {"feedback"})

"""Grants of time in lockstep: each is begun, goes as far as those allow who ask for it, and is answered.

A grant collects what participants are told of with it: answers to their commands, events of goals, conditions that
were met. What they want to be woken for ends it, with the instant at which it happens.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Final

from hmrsim.engine.sim_time import end_of_instant, stamp
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.outputs import (
    Answered,
    FeedbackSent,
    GoalChanged,
    GoalTold,
    Granted,
    PlanWanted,
    RosterChanged,
    TimeRestarted,
)
from hmrsim.protocol.topics import Topic
from hmrsim.timing.conditions import Conditions
from hmrsim.timing.given_commands import GivenCommands
from hmrsim.timing.goal_events import NO_KINDS, GoalEvents, kinds_wanted
from hmrsim.timing.participants import Slot

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Advance
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.absences import Absences
    from hmrsim.timing.participants import Participant, Participants, Told

ENDED: Final = "the simulation has ended"
"""What ended a run of which nobody has said."""


class Grants:
    """The grants of a run, one at a time.

    Args:
        absences: The stalled participants, without which time goes on, and those that it stands for.
        until: When the run ends, in simulated seconds.
        on_over: Called at that time instead of the answers to the last grant.

    Attributes:
        epoch: The next grant.
        under_way: Whether time is being granted just now.
        why_over: What ended the run; empty before that.
    """

    def __init__(
        self,
        simulator: Simulator,
        participants: Participants,
        absences: Absences,
        *,
        until: float,
        on_over: Callable[[], None],
    ) -> None:
        self._simulator = simulator
        self._participants = participants
        self._absences = absences
        self._end = until
        self._on_over = on_over
        self.epoch = 0
        self.under_way = False
        self.why_over = ""
        self._horizon = math.inf
        self._wake = NO_KINDS
        self._woken = False
        self._events = GoalEvents(simulator, self._note_event)
        self._conditions = Conditions(simulator, self._note_met)
        self._given = GivenCommands(simulator, participants, self._conditions, self._halt)

    @property
    def next(self) -> int:
        """The epoch that may be asked for: the one after that which is being granted."""
        return self.epoch + self.under_way

    @property
    def over(self) -> bool:
        """Whether it is the time at which the run ends."""
        return self._end < math.inf and stamp(self._simulator.now) >= stamp(self._end)

    @property
    def thinking(self) -> list[Participant]:
        """The participants that time waits for: those that have yet to ask to advance, and are not stalled."""
        return [each for each in self._participants.thinking if not self._absences.stalled(each.name)]

    @property
    def _asking(self) -> list[tuple[Participant, Advance]]:
        """The participants that get the grant under way and are not stalled, with their requests."""
        stalled = self._absences.stalled
        return [pair for pair in self._participants.asking if pair[0].begun and not stalled(pair[0].name)]

    def begin(self) -> None:
        """Begin a grant: apply the commands of this epoch."""
        self.under_way, self._woken = True, False
        self.submit_changes()
        stalled = self._absences.stalled
        asked = [
            (participant, advance)
            for participant, advance in self._participants.asking
            if not participant.begun and (participant.early or not stalled(participant.name))
        ]
        for participant, advance in asked:
            participant.begun, participant.behind = True, None
            participant.kinds = kinds_wanted(advance)
        self._limit_grant()
        self._events.record(NO_KINDS.union(*(each.kinds for each in self._participants.all)))
        if self._has_news:
            # A client that does not take part has caused an event meanwhile, or a stalled participant has missed it.
            self._halt()
        for participant, advance in asked:
            wakes = "result" in advance.wake and not stalled(participant.name)
            self._given.give(participant, advance.commands, wakes=wakes)
        self._conditions.refresh()

    def _limit_grant(self) -> None:
        """Let the grant go as far as those allow who ask for it, and end with the kinds of events that wake them."""
        now = self._simulator.now
        asked = [advance for _, advance in self._asking]
        self._horizon = min(max(until, now) for until in (self._absences.due, *(each.until for each in asked)))
        self._wake = NO_KINDS.union(*(each.wake for each in asked))

    @property
    def _has_news(self) -> bool:
        """Whether there is something to wake a participant that asks, or one is to join first."""
        if self._absences.awaited or self._events.any_of(self._wake):
            return True
        asked = self._asking
        if any(kind in advance.wake for each, advance in asked for kind, _, _ in each.missed):
            return True
        if any(slot.woke for each, _ in asked for slot in each.slots):
            return True
        return bool({each.name for each, _ in asked}.intersection(self._conditions.met))

    def reconsider(self) -> None:
        """Let the grant under way go as far as those allow who are left."""
        if not self.under_way:
            return
        self._woken = False
        self._limit_grant()
        if self._has_news:
            self._halt()

    def proceed(self, most: int, wall: float) -> bool:
        """Process at most so many events of a grant; return whether more may be processed at once.

        At the end of the grant every participant gets its answer.
        """
        simulator = self._simulator
        plans = simulator.plans
        if plans.awaited:
            # All of this instant comes first, and time stands; it can't matter when, and in which order, they come.
            return simulator.process_events(end_of_instant(simulator.now), most) or (
                plans.all_kept and self._submit_plans()
            )
        stop = self._next_stop
        if simulator.process_events(end_of_instant(stop), most, idle=stop < math.inf) or stop != self._next_stop:
            return True
        if stop == self._conditions.due < math.inf:
            simulator.advance_clock(stop)
            self._conditions.look()
            return True
        if self._woken:
            self._finish("event", wall)
        elif simulator.limit < math.inf and stop == simulator.limit:
            # A client has paused the simulation, or makes it step.
            simulator.advance_clock(stop)
        elif stop == self._horizon < math.inf:
            simulator.advance_clock(stop)
            self._finish("until", wall)
        elif stop < math.inf:
            simulator.advance_clock(stop)
            self._finish("end", wall)
        else:
            if not self._asking:
                self._absences.give_up()
            self._finish("idle", wall)
        return False

    @property
    def _next_stop(self) -> float:
        """Up to when time may move before something is to be decided."""
        return min(self._horizon, self._simulator.limit, self._end, self._conditions.due)

    def _finish(self, reason: str, wall: float) -> None:
        self.under_way = False
        self.epoch += 1
        for name in self._absences.end(self._simulator.now):
            if participant := self._participants.get(name):
                participant.since = wall
        asked = self._asking
        if self.over:
            self._on_over()
            return
        self._events.sort()
        sampled = self._events.sampled(advance for _, advance in asked)
        for participant, _ in asked:
            participant.since = wall
            self.answer(participant, reason, sampled)
        self._forget_events()

    def _forget_events(self) -> None:
        """Forget the events, other than those that stalled participants would be told of now."""
        for each in self._participants.all:
            if self._absences.stalled(each.name) or each.behind is not None:
                each.missed += [event for event in self._events.all if event[0] in each.kinds]
        self._events.clear()

    def answer(self, participant: Participant, reason: str, sampled: Iterable[Told] = ()) -> None:
        """Answer one participant, which thinks from now on."""
        advance = participant.open
        if advance is None:
            raise AssertionError
        now = self._simulator.now
        if reason == "until" and stamp(advance.until) == stamp(now):
            # Times are whole nanoseconds; a participant that rounds otherwise must not get an earlier time.
            now = max(now, advance.until)
        missed = [each for each in participant.missed if each[0] in kinds_wanted(advance)]
        events = (*missed, *self._events.wanted(advance))
        if "feedback" in advance.report - advance.wake:
            events = (*events, *sampled)
        accepted = tuple(slot.answer for slot in participant.slots)
        met = self._conditions.take_met(participant.name)
        granted = Granted(self.epoch, now, reason, accepted, events, met, self.why_over)
        participant.last = (advance.epoch, granted)
        self._given.stop_waiting(participant)
        askers, participant.open, participant.slots, participant.askers = participant.askers, None, [], []
        participant.missed, participant.behind = [], None
        for reply_to in askers:
            self._simulator.answer(reply_to, granted)

    def _submit_plans(self) -> bool:
        answers = self._simulator.plans.take_kept()
        for answer in answers:
            self._simulator.submit(answer)
        return bool(answers)

    def abandon(self) -> None:
        """Give up the grant under way."""
        self.under_way = False

    def close(self, why: str) -> None:
        """Give up the grant under way, as the run ends; no other follows."""
        self.why_over = why
        self.under_way = False

    def tell_ended(self, asked: Iterable[Participant]) -> None:
        """Tell participants that wait for a grant that the run has ended."""
        self._events.sort()
        for participant in asked:
            self.answer(participant, "end")

    def tell_end(self, command: Advance) -> None:
        """Answer a participant that asks to advance after the end of the run."""
        events = self._events.wanted(command)
        granted = Granted(self.epoch, self._simulator.now, "end", events=events, over=self.why_over or ENDED)
        self._simulator.answer(command.reply_to, granted)

    def dismiss(self) -> None:
        """Collect nothing more, as nobody takes part."""
        self.submit_kept()
        self._events.record_nothing()

    def restart(self) -> None:
        """Restart at epoch 0; a participant that waits for a grant receives the changes of its goals by the reset."""
        self.under_way = False
        self.epoch = 0
        thinking = self.thinking
        for each in self._participants.all:
            each.behind = None
        for participant, _ in self._participants.asking:
            if not self._absences.stalled(participant.name):
                self.answer(participant, "event")
        if not thinking:
            self._forget_events()

    def stop_waiting(self, participant: Participant) -> None:
        """Wait no longer for results that a participant wanted and that are not there yet."""
        self._given.stop_waiting(participant)

    def forget(self, name: str) -> None:
        """Forget the conditions of a participant that is gone."""
        self._conditions.drop(name)

    def submit_changes(self) -> None:
        """Submit the changes of participation since the last grant."""
        for change in self._participants.take_changes():
            self._simulator.submit(change, change.participant)

    def submit_kept(self) -> None:
        """Submit the changes of participation, and the plans that are kept for the end of an instant."""
        self.submit_changes()
        self._submit_plans()

    def wants(self, topic: Topic) -> bool:
        """Return whether a participant waits for something on a topic; changes of goals are emitted anyway."""
        return (topic is Topic.FEEDBACK and self._events.samples) or self._conditions.wants(topic)

    def emit(self, output: Output) -> None:
        """Record an event that a participant waits for."""
        kind = type(output)
        if kind is GoalChanged or kind is GoalTold:
            self._events.note_news(output)  # type: ignore[arg-type]  # by its exact type, as this is asked for each event
        elif kind is FeedbackSent:
            self._events.note_feedback(output)  # type: ignore[arg-type]
        elif kind is TimeRestarted:
            self._absences.shift(output.ended / NANOSECONDS)  # type: ignore[union-attr]
        elif kind is RosterChanged:
            self._events.note_withheld()
            self._conditions.follow()
        elif kind is PlanWanted:
            if self.under_way:
                self._simulator.halt()
        elif kind is Answered and type(output.reply_to) is Slot:  # type: ignore[union-attr]
            self._given.note_answer(output.reply_to, output.answer)  # type: ignore[union-attr]
        if self._conditions:
            self._conditions.emit(output)

    def _note_met(self) -> None:
        if self.under_way and not self._woken and self._has_news:
            self._halt()

    def _note_event(self, kind: str) -> None:
        if self.under_way and not self._woken and kind in self._wake:
            self._halt()

    def _halt(self) -> None:
        """Grant no more than this instant."""
        self._woken = True
        self._horizon = self._simulator.now
        self._simulator.halt()

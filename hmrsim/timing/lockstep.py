"""Lockstep: simulated time advances only as far as all controllers allow, as with HLA's next message request.

Time is granted in epochs. A grant begins when every participant has asked to advance. First its commands are
applied in order of (participant's name, index), then events are taken up to the least time that was asked for, or
to the end of the first instant with an event that a participant wants to be woken for. So neither
the order of messages on the network nor a participant's thinking time affects the run.

This module uses neither network nor wall clock: `hmrsim.timing.pacing` passes requests to it and calls `proceed`.
"""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Callable, Collection, Iterable
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import end_of_instant, stamp
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.answers import Refused, ResultResponse
from hmrsim.protocol.commands import (
    Advance,
    CancelGoal,
    GetResult,
    InterestChanged,
    SendGoal,
    StopWaiting,
    Unreadable,
)
from hmrsim.protocol.conditions import Unwatch, Watch
from hmrsim.protocol.goal_ids import made_goal_id
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
from hmrsim.protocol.time import HasLeft, Join, Joined, Leave
from hmrsim.protocol.topics import Topic
from hmrsim.timing.absences import Absences
from hmrsim.timing.conditions import Conditions
from hmrsim.timing.participants import Participants, Slot

if TYPE_CHECKING:
    from hmrsim.protocol.commands import PlanAnswered
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.participants import Participant

_log = logging.getLogger(__name__)

_Given = SendGoal | CancelGoal | GetResult | Watch | Unwatch | Unreadable

_NO_KINDS: frozenset[str] = frozenset()
_ENDED = "the simulation has ended"


class LockstepCoordinator:
    """Grants time to participants; a sink of the simulation, so that it receives the events that they wait for.

    Args:
        awaited: How many participants have to join before time moves for the first time, or their names.
        until: When the run ends, in simulated seconds.

    Attributes:
        epoch: The next grant.
        lost: Which participant was dropped last, and why; empty if none was.
    """

    def __init__(self, simulator: Simulator, *, awaited: int | Collection[str] = 1, until: float = math.inf) -> None:
        self._simulator = simulator
        self._end = until
        self.epoch = 0
        self.lost = ""
        self._over = ""
        self._participants = Participants(awaited)
        self._absences = Absences()
        self._granting = False
        self._horizon = math.inf
        self._wake = self._reported = _NO_KINDS
        self._woken = False
        self._events: list[tuple[str, int, GoalChanged | FeedbackSent]] = []
        self._withheld: list[GoalChanged] = []
        self._conditions = Conditions(simulator, self._note_met)

    @property
    def participants(self) -> tuple[str, ...]:
        """The names of the participants."""
        return self._participants.names

    @property
    def thinks(self) -> bool:
        """Whether a participant has yet to ask to advance."""
        return bool(self._thinking)

    @property
    def waiting_for(self) -> tuple[str, ...]:
        """The participants that have yet to ask to advance, or to join for the first time."""
        thinking = [each.name for each in self._thinking]
        return tuple(sorted((*thinking, *self._participants.missing, *self._absences.awaited)))

    @property
    def _thinking(self) -> list[Participant]:
        """The participants that time waits for: not those that are stalled."""
        return [each for each in self._participants.thinking if not self._absences.stalled(each.name)]

    @property
    def _asking(self) -> list[tuple[Participant, Advance]]:
        """The participants that have asked to advance and are not stalled, with their requests."""
        return [pair for pair in self._participants.asking if not self._absences.stalled(pair[0].name)]

    def join(self, command: Join, wall: float) -> None:
        """Add a participant from the next grant on; *wall* is the time by the watchdog's clock."""
        name, participants = command.name, self._participants
        there = participants.get(name)
        if there is not None:
            if command.token and command.token == there.joined_with and there.last is None:
                self._welcome(command)
                return
            self._refuse(command.reply_to, "name", name, f"participant {name!r} has joined already; take another name")
            return
        participants.add(name, wall, command.token)
        self._absences.forget(name)
        waiting = f"; waiting for {', '.join(participants.missing)}" if participants.missing else ""
        _log.info("sim %.3f | participant %s has joined%s", self._simulator.now, name, waiting)
        self._welcome(command)

    def _welcome(self, command: Join) -> None:
        goals = self._participants.goals_of(command.name)
        self._simulator.answer(command.reply_to, Joined(command.name, self._next, self._simulator.now, goals))

    def leave(self, command: Leave) -> None:
        """Remove a participant on its own request."""
        name = command.participant
        if not self._participants.get(name):
            self._refuse(command.reply_to, "participant", name, self._participants.why_unknown(name))
            return
        _log.info("sim %.3f | participant %s has left", self._simulator.now, name)
        self._remove(name, "left")
        self._simulator.answer(command.reply_to, HasLeft(name))

    def token_seen(self, name: str, *, alive: bool) -> None:
        """Record whether a participant has its liveliness token; a participant that has lost its token is dropped."""
        if self._participants.lost_token(name, alive=alive):
            self.drop(name, "its liveliness token is gone")

    def overdue(self, before: float) -> list[str]:
        """Return participants that have been thinking since before *before*, by the watchdog's clock.

        There are none while time is granted or the simulation is paused.
        """
        if self._granting or self._simulator.paused:
            return []
        return sorted(each.name for each in self._thinking if each.since < before)

    def stall(self, name: str, until: float) -> None:
        """Let time go on without a participant until some time: it hears nothing, and what it says is not heard.

        What it said before is done. At that time it is told of all that has happened, as it would have been before.
        Nothing happens if there is no such participant.

        Args:
            name: Who is stalled.
            until: Simulated seconds; it may be stalled for longer already.
        """
        participant = self._participants.get(name)
        if participant is None:
            return
        if participant.open is not None:
            participant.early = True
        elif participant.behind is None:
            participant.behind = self._next
        for slot in participant.slots:
            slot.wakes = slot.woke = False
        self._absences.stall(name, until)
        self._reconsider()

    def expect(self, name: str, at: float = 0.0, on_due: Callable[[], None] = lambda: None) -> None:
        """Let time go on until some time, also without any participant, and wait there for one to join.

        Args:
            name: Who joins; empty for nobody, so that nothing is waited for.
            at: Simulated seconds; infinite to let time go on as far as anything is scheduled.
            on_due: Called when it is that time.
        """
        self._absences.expect(name, at, on_due)
        self._absences.end(self._simulator.now)
        self._reconsider()

    def expect_no_more(self, name: str) -> None:
        """Do not wait for a participant that was expected."""
        self._absences.forget(name)

    def keep(self, name: str) -> None:
        """Whenever a participant goes, wait for it to join again, unless something else is said of it then."""
        self._absences.keep(name)

    def expect_nobody(self) -> None:
        """Wait for nobody that is not there, also not for those that were to be kept."""
        self._absences.clear()

    @property
    def expects(self) -> bool:
        """Whether time goes on, or stands, for the sake of a participant that is not there."""
        return bool(self._absences or self._absences.awaited)

    def drop(self, name: str, why: str) -> None:
        """Drop a participant; its goals continue to execute."""
        _log.warning("sim %.3f | participant %s is dropped: %s", self._simulator.now, name, why)
        self.lost = f"participant {name!r} was dropped at {self._simulator.now:.3f} s: {why}"
        error = f"{self.lost}; join again"
        participant = self._participants.get(name)
        if participant and participant.open is not None:
            for reply_to in participant.askers:
                self._refuse(reply_to, "participant", name, error)
            self._stop_waiting(participant)
            participant.open = None
        self._remove(name, "dropped", why, error=error)
        self._reconsider()

    def end(self, why: str, reason: str) -> None:
        """End the run: abort every goal, and remove all participants, which are told how their goals have ended.

        Those that wait for a grant are told now, the others when they ask; nothing happens if it has ended already.

        Args:
            why: What ended the run.
            reason: The message in the results of the goals.
        """
        if self._over:
            return
        self._over, self._granting = why, False
        self._absences.clear()
        asked = [participant for participant, _ in self._participants.asking]
        for name in self.participants:
            self._participants.remove(name, "left", why, error=f"participant {name!r} was removed: {why}")
        self._apply_changes()
        self._submit_plans(self._simulator.plans.take_kept())
        self._simulator.stop(reason)
        self._events = _in_order(self._events)
        for participant in asked:
            self._grant(participant, "end")

    def tell_end(self, command: Advance) -> None:
        """Answer a participant that asks to advance after the end of the run."""
        events = self._wanted(command)
        granted = Granted(self.epoch, self._simulator.now, "end", events=events, over=self._over or _ENDED)
        self._simulator.answer(command.reply_to, granted)

    def dismiss(self, why: str) -> None:
        """Remove all participants, as the clock is no longer lockstep."""
        self._granting = False
        for name in self.participants:
            self._remove(name, "left", why, error=f"participant {name!r} was removed: {why}; join again")
        self._apply_changes()
        self._submit_plans(self._simulator.plans.take_kept())
        self._reported = _NO_KINDS
        self._events.clear()
        self._simulator.submit(InterestChanged())

    def restart(self) -> None:
        """Restart at epoch 0; a participant that waits for a grant receives the changes of its goals by the reset."""
        self._granting = False
        self.epoch = 0
        thinking = self._thinking
        for each in self._participants.all:
            each.behind = None
        for participant, _ in self._asking:
            self._grant(participant, "event")
        if not thinking:
            self._keep_missed()
            self._events.clear()

    def _remove(self, name: str, change: str, why: str = "", *, error: str = "") -> None:
        participant = self._participants.get(name)
        if participant and participant.open is not None:
            self._grant(participant, "end")
        self._participants.remove(name, change, why, error=error)
        self._absences.note_gone(name)
        self._conditions.drop(name)
        if not self._participants:
            self._granting = False
            if not self._participants.missing:
                self._apply_changes()

    def _apply_changes(self) -> None:
        """Submit the changes of participation since the last grant."""
        for change in self._participants.take_changes():
            self._simulator.submit(change, change.participant)

    @property
    def _next(self) -> int:
        """The epoch that may be asked for: the one after that which is being granted."""
        return self.epoch + self._granting

    def advance(self, command: Advance, wall: float) -> None:
        """Record a participant's request to advance; a repeated request gets the same answer."""
        name = command.participant
        participant = self._participants.get(name)
        if participant is None:
            self._refuse(command.reply_to, "participant", name, self._participants.why_unknown(name))
            return
        if participant.open is not None and participant.open.epoch == command.epoch:
            participant.askers.append(command.reply_to)
        elif participant.last is not None and participant.last[0] == command.epoch != self._next:
            self._simulator.answer(command.reply_to, participant.last[1])
        elif command.epoch in (self._next, participant.behind) and participant.open is None:
            participant.open, participant.since = command, wall
            participant.askers = [command.reply_to]
            participant.begun = participant.early = False
        else:
            text = f"epoch {command.epoch} is not the current one, which is {self._next}"
            if participant.open is not None:
                text = f"epoch {participant.open.epoch} is being waited for; its answer says which is next"
            self._refuse(command.reply_to, "epoch", command.epoch, text)

    @property
    def ready(self) -> bool:
        """Whether a grant may begin: all awaited participants have joined, and every participant has asked for it."""
        if self._granting or self._simulator.paused or not (self._participants or self._absences):
            return False
        return not (self._thinking or self._participants.missing or self._absences.awaited)

    @property
    def granting(self) -> bool:
        """Whether time is being granted just now."""
        return self._granting

    @property
    def over(self) -> bool:
        """Whether it is the time at which the run ends."""
        return self._end < math.inf and stamp(self._simulator.now) >= stamp(self._end)

    def begin(self) -> None:
        """Begin a grant: apply the commands of this epoch."""
        self._granting, self._woken = True, False
        self._apply_changes()
        stalled = self._absences.stalled
        asked = [
            (participant, advance)
            for participant, advance in self._participants.asking
            if not participant.begun and (participant.early or not stalled(participant.name))
        ]
        for participant, advance in asked:
            participant.begun, participant.behind = True, None
            participant.kinds = _wanted_by(advance)
        self._limit_grant()
        reported = _NO_KINDS.union(*(each.kinds for each in self._participants.all))
        if (reported ^ self._reported) & {"feedback"}:
            self._reported = reported
            self._simulator.submit(InterestChanged())
        self._reported = reported
        if self._has_news:
            # A client that does not take part has caused an event meanwhile, or a stalled participant has missed it.
            self._halt()
        for participant, advance in asked:
            wakes = "result" in advance.wake and not stalled(participant.name)
            participant.slots = [Slot(wakes) for _ in advance.commands]
            for command, slot in zip(advance.commands, participant.slots, strict=True):
                self._give(command, participant.name, slot)
        self._conditions.refresh()

    def _limit_grant(self) -> None:
        """Let the grant go as far as those allow who ask for it, and end with the kinds of events that wake them."""
        now = self._simulator.now
        asked = [advance for participant, advance in self._asking if participant.begun]
        self._horizon = min(max(until, now) for until in (self._absences.due, *(each.until for each in asked)))
        self._wake = _NO_KINDS.union(*(each.wake for each in asked))

    @property
    def _has_news(self) -> bool:
        """Whether there is something to wake a participant that asks, or one is to join first."""
        if self._absences.awaited or any(kind in self._wake for kind, _, _ in self._events):
            return True
        asked = [(participant, advance) for participant, advance in self._asking if participant.begun]
        if any(kind in advance.wake for each, advance in asked for kind, _, _ in each.missed):
            return True
        if any(slot.woke for each, _ in asked for slot in each.slots):
            return True
        return bool({each.name for each, _ in asked}.intersection(self._conditions.met))

    def _reconsider(self) -> None:
        """Let the grant under way go as far as those allow who are left."""
        if not self._granting:
            return
        self._woken = False
        self._limit_grant()
        if self._has_news:
            self._halt()

    def _give(self, command: _Given, name: str, slot: Slot) -> None:
        match command:
            case Watch():
                answer = self._conditions.watch(name, command)
                self._note_answer(slot, answer, goes_on=_goes_on(answer))
                return
            case Unwatch():
                slot.answer = self._conditions.unwatch(name, command.name)
                return
            case Unreadable(answer):
                # It may be a goal that its sender has numbered.
                self._participants.next_goal(name)
                self._note_answer(slot, answer, goes_on=False)
                return
            case SendGoal():
                number = self._participants.next_goal(name)
                goal_id = made_goal_id(name, number) if command.goal_id is None else command.goal_id
                command = command._replace(goal_id=goal_id)
            case GetResult():
                slot.wanted = command
        self._simulator.submit(command._replace(reply_to=slot), name)

    def proceed(self, most: int, wall: float) -> bool:
        """Process at most so many events of a grant; return whether more may be processed at once.

        At the end of the grant every participant gets its answer.
        """
        simulator = self._simulator
        plans = simulator.plans
        if plans.awaited:
            # All of this instant comes first, and time stands; it can't matter when, and in which order, they come.
            return simulator.process_events(end_of_instant(simulator.now), most) or (
                plans.all_kept and self._submit_plans(plans.take_kept())
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
            if not any(each.begun for each, _ in self._asking):
                self._absences.give_up()
            self._finish("idle", wall)
        return False

    @property
    def _next_stop(self) -> float:
        """Up to when time may move before something is to be decided."""
        return min(self._horizon, self._simulator.limit, self._end, self._conditions.due)

    def _submit_plans(self, answers: Collection[PlanAnswered]) -> bool:
        for answer in answers:
            self._simulator.submit(answer)
        return bool(answers)

    def _finish(self, reason: str, wall: float) -> None:
        self._granting = False
        self.epoch += 1
        for name in self._absences.end(self._simulator.now):
            if participant := self._participants.get(name):
                participant.since = wall
        asked = [pair for pair in self._asking if pair[0].begun]
        if self.over:
            self.end(f"it was to last {self._end:g} s", _ENDED)
            return
        self._events = _in_order(self._events)
        sampled = self._sampled(advance for _, advance in asked)
        for participant, _ in asked:
            participant.since = wall
            self._grant(participant, reason, sampled)
        self._keep_missed()
        self._events.clear()

    def _keep_missed(self) -> None:
        """Keep the events that stalled participants would be told of now."""
        for each in self._participants.all:
            if self._absences.stalled(each.name) or each.behind is not None:
                each.missed += [event for event in self._events if event[0] in each.kinds]

    def _sampled(self, advances: Iterable[Advance]) -> list[tuple[str, int, FeedbackSent]]:
        """Return the feedback of this instant, if a participant asks to have it reported without waking for it."""
        if not any("feedback" in advance.report - advance.wake for advance in advances):
            return []
        now = stamp(self._simulator.now)
        return [("feedback", now, feedback) for feedback in self._simulator.dispatcher.feedback.current()]

    def _grant(
        self, participant: Participant, reason: str, sampled: Iterable[tuple[str, int, FeedbackSent]] = ()
    ) -> None:
        """Answer one participant, which thinks from now on."""
        advance = participant.open
        if advance is None:
            raise AssertionError
        now = self._simulator.now
        if reason == "until" and stamp(advance.until) == stamp(now):
            # Times are whole nanoseconds; a participant that rounds otherwise must not get an earlier time.
            now = max(now, advance.until)
        events = (*(each for each in participant.missed if each[0] in _wanted_by(advance)), *self._wanted(advance))
        if "feedback" in advance.report - advance.wake:
            events = (*events, *sampled)
        accepted = tuple(slot.answer for slot in participant.slots)
        met = self._conditions.take_met(participant.name)
        granted = Granted(self.epoch, now, reason, accepted, events, met, self._over)
        participant.last = (advance.epoch, granted)
        self._stop_waiting(participant)
        askers, participant.open, participant.slots, participant.askers = participant.askers, None, [], []
        participant.missed, participant.behind = [], None
        for reply_to in askers:
            self._simulator.answer(reply_to, granted)

    def _wanted(self, advance: Advance) -> tuple[tuple[str, int, GoalChanged | FeedbackSent], ...]:
        """Return the events since the last grant of which a participant wants to be told."""
        wanted = _wanted_by(advance)
        return tuple(event for event in self._events if event[0] in wanted)

    def _stop_waiting(self, participant: Participant) -> None:
        """Wait no longer for results that a participant wanted and that are not there yet."""
        for slot in participant.slots:
            if slot.wanted is not None and slot.answer is None:
                self._simulator.submit(StopWaiting(*slot.wanted[:3], reply_tos=(slot,)))

    def _refuse(self, reply_to: Any, name: str, value: object, text: str) -> None:
        self._simulator.answer(reply_to, Refused(name, value, text))

    def wants(self, topic: Topic) -> bool:
        """Return whether a participant waits for something on a topic; changes of goals are emitted anyway."""
        return (topic is Topic.FEEDBACK and "feedback" in self._reported) or self._conditions.wants(topic)

    def emit(self, output: Output) -> None:
        """Record an event that a participant waits for."""
        kind = type(output)
        if kind is GoalChanged or kind is GoalTold:
            self._note_news(output)  # type: ignore[arg-type]  # by its exact type, as this is asked for each event
        elif kind is FeedbackSent:
            if "feedback" in self._reported:
                self._note("feedback", stamp(self._simulator.now), output)  # type: ignore[arg-type]
        elif kind is TimeRestarted:
            self._absences.shift(output.ended / NANOSECONDS)  # type: ignore[union-attr]
        elif kind is RosterChanged:
            self._note_withheld()
            self._conditions.follow()
        elif kind is PlanWanted:
            if self._granting:
                self._simulator.halt()
        elif kind is Answered and type(output.reply_to) is Slot:  # type: ignore[union-attr]
            answer = output.answer  # type: ignore[union-attr]
            self._note_answer(output.reply_to, answer, goes_on=_goes_on(answer))  # type: ignore[union-attr]
        if self._conditions:
            self._conditions.emit(output)

    def _note_answer(self, slot: Slot, answer: Any, *, goes_on: bool) -> None:
        slot.answer = answer
        if slot.wakes and not goes_on:
            # It counts as the result: no later event could wake the participant that sent the command.
            slot.woke = True
            self._halt()

    def _note_met(self) -> None:
        if self._granting and not self._woken and self._has_news:
            self._halt()

    def _note_withheld(self) -> None:
        """Record the withheld changes of goals of robots that are connected again."""
        withheld, self._withheld = self._withheld, []
        for event in withheld:
            self._note_change(event)

    def _note_news(self, news: GoalChanged | GoalTold) -> None:
        """Record a change of a goal when participants may know it."""
        if isinstance(news, GoalTold):
            self._note_change(news.change)
        elif news.robot not in self._simulator.dispatcher.news:
            self._note_change(news)

    def _note_change(self, event: GoalChanged) -> None:
        if event.robot in self._simulator.dispatcher.cut_off:
            self._withheld.append(event)
            return
        if "status" in self._reported:
            self._note("status", event.stamp, event)
        if event.result is not None and "result" in self._reported:
            self._note("result", event.stamp, event)

    def _note(self, kind: str, at: int, event: GoalChanged | FeedbackSent) -> None:
        self._events.append((kind, at, event))
        if self._granting and not self._woken and kind in self._wake:
            self._halt()

    def _halt(self) -> None:
        """Grant no more than this instant."""
        self._woken = True
        self._horizon = self._simulator.now
        self._simulator.halt()


def _wanted_by(advance: Advance) -> frozenset[str]:
    """Return the kinds of events that a participant is told of as they come."""
    return advance.wake | (advance.report - {"feedback"})


def _goes_on(answer: Any) -> bool:
    """Return whether a command has an effect of which an event will tell."""
    return not isinstance(answer, (Refused, ResultResponse)) and getattr(answer, "accepted", True)


def _in_order(
    events: list[tuple[str, int, GoalChanged | FeedbackSent]],
) -> list[tuple[str, int, GoalChanged | FeedbackSent]]:
    """Return the events, with samples of one instant in the order of robots, as other subscribers could change it."""
    ordered = []
    for (kind, _), group in itertools.groupby(events, key=lambda event: event[:2]):
        found = list(group)
        if kind == "feedback":
            found.sort(key=lambda event: (event[2].robot, event[2].action, event[2].goal_id))
        ordered += found
    return ordered

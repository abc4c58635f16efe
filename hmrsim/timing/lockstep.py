"""Lockstep: simulated time advances only as far as all controllers allow, as with HLA's next message request.

Time is granted in epochs. A grant begins when every participant has asked to advance. First its commands are
applied in order of (participant's name, index), then events are taken up to the least time that was asked for, or
to the end of the first instant with an event that a participant wants to be woken for. So neither
the order of messages on the network nor a participant's thinking time affects the run.

This module uses neither network nor wall clock: `hmrsim.timing.pacing` passes requests to it and has it `proceed`.
"""

from __future__ import annotations

import itertools
import logging
import math
from collections.abc import Callable, Collection, Sequence
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import end_of_instant, stamp
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.commands import CancelGoal, GetResult, InterestChanged, SendGoal, StopWaiting, Unreadable
from hmrsim.protocol.goal import Refused, made_goal_id
from hmrsim.protocol.outputs import (
    EventStamped,
    FeedbackSent,
    GoalChanged,
    GoalTold,
    Granted,
    PlanWanted,
    RosterChanged,
    Sampled,
    TimeRestarted,
)
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.time import HasLeft, Join, Joined, Leave
from hmrsim.protocol.topics import Topic, Unwatch, Watch
from hmrsim.timing.conditions import Conditions
from hmrsim.timing.participants import NO_KINDS, Participants, Reported, Slot, State, kinds_wanted

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Advance
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.participants import Participant

_log = logging.getLogger(__name__)

_ENDED: Final = "the simulation has ended"
"""The default reason for the end of a run."""

_ANSWER: Final = attrgetter("answer")

_NEAR: Final = 1e-8
"""Times that are further apart, in simulated seconds, have different stamps."""


class Lockstep(SelectiveSink):
    """Grants time to participants; a sink of the simulation, so that it receives the events they wait for.

    A grant reports to each participant the answers to its commands, the events of goals, and the conditions that were
    met.

    Args:
        awaited: How many participants have to join before time moves for the first time, or their names.
        until: When the run ends, in simulated seconds.

    Attributes:
        epoch: The next grant.
        granting: Whether time is being granted just now.
        lost: Which participant was dropped last, and why; empty if none was.
        ended: Why the run has ended; empty while it goes on.
        nearly_over: From here on, in simulated seconds, `over` has to be asked.
    """

    def __init__(self, simulator: Simulator, *, awaited: int | Collection[str] = 1, until: float = math.inf) -> None:
        self.epoch = 0
        self.granting = False
        self.lost = ""
        self._simulator = simulator
        # Read several times a grant.
        self._env = simulator.env
        self._gate = simulator.gate
        self._end = until
        self.nearly_over = until - _NEAR
        self.ended = ""
        self._participants = Participants(awaited)
        self._conditions = Conditions(simulator, self._on_condition_met)
        # Of the grant under way: how far it goes, the kinds of events that end it, and whether one has.
        self._horizon = math.inf
        self._wake = NO_KINDS
        self._woken = False
        # The events since the last grant, of the kinds that any participant wants.
        self._events: list[Reported] = []
        self._kinds = NO_KINDS
        # Changes of goals of robots that clients can't reach.
        self._withheld: list[GoalChanged] = []
        self._handlers: dict[type, Callable[[Any], None]] = {
            GoalChanged: self._on_goal_changed,
            GoalTold: lambda told: self._record_change(told.change),
            FeedbackSent: self._on_feedback,
            TimeRestarted: lambda restarted: self._participants.shift(restarted.ended / NANOSECONDS),
            RosterChanged: self._on_roster_changed,
            PlanWanted: lambda _wanted: simulator.halt() if self.granting else None,
            Sampled: self._follow,
            EventStamped: self._follow,
        }

    @property
    def participants(self) -> tuple[str, ...]:
        """The names of the participants."""
        return self._participants.names

    @property
    def participates(self) -> bool:
        """Return whether there is a participant."""
        return bool(self._participants.all)

    @property
    def thinks(self) -> bool:
        """Return whether a participant has yet to ask to advance."""
        return bool(self._participants.thinking)

    @property
    def waiting_for(self) -> tuple[str, ...]:
        """The participants that have yet to ask to advance, or to join."""
        there = self._participants
        return tuple(sorted((*there.thinking, *there.missing, *there.awaited)))

    @property
    def expects(self) -> bool:
        """Return whether time moves, or waits, because of a participant that is absent or stalled."""
        there = self._participants
        return there.later or bool(there.awaited) or any(each.state.stalled for each in there.all)

    @property
    def over(self) -> bool:
        """Return whether the simulated time has reached the end of the run."""
        now = self._env.now
        return now >= self.nearly_over and stamp(now) >= stamp(self._end)

    @property
    def _next(self) -> int:
        """The epoch that may be asked for: the one after that which is being granted."""
        return self.epoch + self.granting

    def join(self, command: Join, wall: float) -> None:
        """Add a participant from the next grant on; *wall* is the time by the watchdog's clock."""
        name, participants = command.name, self._participants
        there = participants.by_name.get(name)
        if there is None:
            participants.add(name, wall, command.token)
            waiting = f"; waiting for {', '.join(participants.missing)}" if participants.missing else ""
            _log.info("sim %.3f | participant %s has joined%s", self._simulator.now, name, waiting)
        elif not command.token or command.token != there.joined_with or there.last is not None:
            self._refuse(command.reply_to, "name", name, f"participant {name!r} has joined already; take another name")
            return
        joined = Joined(name, self._next, self._simulator.now, participants.goals_of(name))
        self._simulator.answer(command.reply_to, joined)

    def leave(self, command: Leave) -> None:
        """Remove a participant on its own request."""
        name = command.participant
        if not self._participants.by_name.get(name):
            self._refuse(command.reply_to, "participant", name, self._participants.why_unknown(name))
            return
        _log.info("sim %.3f | participant %s has left", self._simulator.now, name)
        self._remove(name, "left")
        self._simulator.answer(command.reply_to, HasLeft(name))

    def drop(self, name: str, why: str) -> None:
        """Drop a participant; its goals continue to execute."""
        _log.warning("sim %.3f | participant %s is dropped: %s", self._simulator.now, name, why)
        self.lost = f"participant {name!r} was dropped at {self._simulator.now:.3f} s: {why}"
        error = f"{self.lost}; join again"
        participant = self._participants.by_name.get(name)
        if participant is not None:
            self._stop_waiting(participant)
            for reply_to in participant.drop_request():
                self._refuse(reply_to, "participant", name, error)
        self._remove(name, "dropped", why, error=error)
        self._reconsider()

    def token_seen(self, name: str, *, alive: bool) -> None:
        """Record whether a participant has its liveliness token; a participant that has lost its token is dropped."""
        if self._participants.lost_token(name, alive=alive):
            self.drop(name, "its liveliness token is gone")

    def overdue(self, before: float) -> list[str]:
        """Return participants that have been thinking since before *before*, by the watchdog's clock; from any thread.

        There are none while time is granted or the simulation is paused.
        """
        if self.granting or self._simulator.paused:
            return []
        here = list(self._participants.all)
        return [each.name for each in here if each.state is State.THINKING and each.since < before]

    def stall(self, name: str, until: float) -> None:
        """Stall a participant until some time: the simulation continues without it, and its requests have to wait.

        Commands that it sent before are applied. When the stall is over it receives everything that it missed.
        An unknown participant is ignored.

        Args:
            name: Who is stalled.
            until: Simulated seconds; it may be stalled for longer already.
        """
        self._participants.stall(name, until, self._next)
        self._reconsider()

    def expect(self, name: str, at: float = 0.0, on_due: Callable[[], None] = lambda: None) -> None:
        """Run until some time, even without any participant, and wait there for one to join.

        Args:
            name: The participant that joins; empty to wait for no participant.
            at: Simulated seconds; infinite to run as far as events are scheduled.
            on_due: Called at that time.
        """
        self._participants.expect(name, at, on_due)
        self._participants.arrive(self._simulator.now)
        self._reconsider()

    def expect_no_more(self, name: str) -> None:
        """Stop expecting a participant."""
        self._participants.expect_no_more(name)

    def keep(self, name: str) -> None:
        """Wait for a participant to join again whenever it leaves or is dropped, unless `expect` overrides that."""
        self._participants.keep(name)

    def expect_nobody(self) -> None:
        """Wait for no absent participant, including those marked by `keep`."""
        self._participants.expect_nobody()

    def advance(self, command: Advance, wall: float) -> None:
        """Take a participant's request to advance; a repeated request gets the same answer."""
        name, epoch = command.participant, command.epoch
        participant, following = self._participants.by_name.get(name), self.epoch + self.granting
        if participant is None:
            self._refuse(command.reply_to, "participant", name, self._participants.why_unknown(name))
            return
        request = participant.request
        if request is not None and request.epoch == epoch:
            participant.askers.append(command.reply_to)
        elif participant.last is not None and participant.last[0] == epoch != following:
            self._simulator.answer(command.reply_to, participant.last[1])
        elif request is None and epoch in (following, participant.behind):
            participant.ask(command, wall)
        else:
            text = f"epoch {epoch} is not the current one, which is {following}"
            if request is not None:
                text = f"epoch {request.epoch} is pending; its answer says which epoch is next"
            self._refuse(command.reply_to, "epoch", epoch, text)

    @property
    def ready(self) -> bool:
        """Return whether a grant may begin: all expected participants have joined, and each has asked to advance."""
        there = self._participants
        if self.granting or there.missing or there.awaited or self._gate.limit <= self._env.now:
            return False
        for participant in there.all:
            if participant.state is State.THINKING:
                return False
        return bool(there.all) or there.later

    def begin(self) -> None:
        """Begin a grant: apply the commands of this epoch."""
        self.granting, self._woken = True, False
        if self._participants.changes:
            self._submit_changes()
        asked, kinds = [], NO_KINDS
        for participant in self._participants.all:
            if participant.state.begins:
                request = participant.begin()
                asked.append((participant, request))
            kinds |= participant.kinds
        self._limit_grant()
        if kinds != self._kinds:
            self._record(kinds)
        if self._has_news:
            # A client that does not take part has caused an event meanwhile, or a stalled participant has missed it.
            self._halt()
        for participant, request in asked:
            if request.commands:
                self._apply(participant, request)
        if self._conditions.changed:
            self._conditions.refresh()

    def _limit_grant(self) -> None:
        """Set the horizon of the grant, and the kinds of events that end it, from the requests of the participants."""
        horizon, wake = self._participants.due, NO_KINDS
        for participant in self._participants.all:
            if participant.state is State.GRANTED and (request := participant.request):
                horizon = min(horizon, request.until)
                wake |= request.wake
        self._horizon, self._wake = max(horizon, self._env.now), wake

    @property
    def _has_news(self) -> bool:
        """Return whether an event is pending that wakes a participant, or a participant has to join first."""
        if self._participants.awaited:
            return True
        if self._events and any(kind in self._wake for kind, _, _ in self._events):
            return True
        met = self._conditions.met
        for participant in self._participants.all:
            if participant.state is State.GRANTED and (request := participant.request):
                if participant.name in met:
                    return True
                for slot in participant.slots:
                    if slot.woke:
                        return True
                for kind, _, _ in participant.missed:
                    if kind in request.wake:
                        return True
        return False

    def _reconsider(self) -> None:
        """Recompute the limits of the current grant after a participant was removed, stalled or expected."""
        if self.granting:
            self._woken = False
            self._limit_grant()
            if self._has_news:
                self._halt()

    def _apply(self, participant: Participant, request: Advance) -> None:
        """Apply the commands of a participant in order."""
        wakes = "result" in request.wake and not participant.state.stalled
        name = participant.name
        participant.slots = [Slot(self._halt, wakes=wakes) for _ in request.commands]
        for command, slot in zip(request.commands, participant.slots, strict=True):
            match command:
                case SendGoal(robot, action, goal, goal_id):
                    number = self._participants.next_goal(name)
                    goal_id = made_goal_id(name, number) if goal_id is None else goal_id
                    self._simulator.submit(SendGoal(robot, action, goal, goal_id, slot), name)
                case CancelGoal():
                    self._simulator.submit(command._replace(reply_to=slot), name)
                case GetResult():
                    slot.wanted = command
                    self._simulator.submit(command._replace(reply_to=slot), name)
                case Watch():
                    slot.succeed(self._conditions.watch(name, command))
                case Unwatch():
                    slot.answer = self._conditions.unwatch(name, command.name)
                case Unreadable(answer):
                    # It may be a goal that its sender has numbered.
                    self._participants.next_goal(name)
                    slot.succeed(answer)

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
        env = self._env
        if self._woken and env.peek() > env.horizon and not (self._conditions.watched or simulator.interest.sampled):
            # Halted at the end of this instant, since nothing else is due at it.
            self._finish("event", wall)
            return False
        stop = self._next_stop()
        end = end_of_instant(stop) if stop < math.inf else stop
        if simulator.process_events(end, most, idle=stop < math.inf) or stop != self._next_stop():
            return True
        if self._conditions.watched and stop == self._conditions.due < math.inf:
            simulator.advance_clock(stop)
            self._conditions.look()
            return True
        if self._woken:
            self._finish("event", wall)
        elif stop == self._gate.limit < math.inf:
            # A client has paused the simulation, or makes it step.
            simulator.advance_clock(stop)
        elif stop == self._horizon < math.inf:
            simulator.advance_clock(stop)
            self._finish("until", wall)
        elif stop < math.inf:
            simulator.advance_clock(stop)
            self._finish("end", wall)
        else:
            if all(each.state is not State.GRANTED for each in self._participants.all):
                self._participants.expect_only_those_that_come()
            self._finish("idle", wall)
        return False

    def _next_stop(self) -> float:
        """Return up to when time may move before something is to be decided."""
        due = self._conditions.due if self._conditions.watched else math.inf
        return min(self._horizon, self._gate.limit, self._end, due)

    def _finish(self, reason: str, wall: float) -> None:
        self.granting = False
        self.epoch += 1
        if self._participants.due < math.inf:
            self._participants.arrive(self._env.now, wall)
        if self._env.now >= self.nearly_over and self.over:
            self.end(f"it was to last {self._end:g} s", _ENDED)
            return
        if "feedback" in self._kinds:
            self._sort_events()
        asked = [each for each in self._participants.all if each.state is State.GRANTED]
        sampled: Sequence[Reported] | None = None
        for participant in asked:
            participant.since = wall
            if participant.samples and sampled is None:
                feedback = self._simulator.dispatcher.feedback.current()
                sampled = [("feedback", self._env.stamp, each) for each in feedback]
            self._answer(participant, reason, sampled or ())
        self._forget_events()

    def _answer(self, participant: Participant, reason: str, sampled: Sequence[Reported] = ()) -> None:
        """Answer one participant; time waits for its next request."""
        request = participant.request
        if request is None:
            raise AssertionError(f"{participant.name} has asked for nothing")
        now = self._env.now
        if reason == "until" and request.until > now and stamp(request.until) == stamp(now):
            # Times are whole nanoseconds; a participant that rounds otherwise must not get an earlier time.
            now = request.until
        wanted = participant.kinds if participant.state is State.GRANTED else kinds_wanted(request)
        events = (*participant.missed, *self._events)
        if events and not wanted >= self._kinds:
            events = tuple([each for each in events if each[0] in wanted])
        if sampled and participant.samples:
            events = (*events, *sampled)
        accepted = tuple(map(_ANSWER, participant.slots))
        met = self._conditions.take_met(participant.name) if self._conditions.met else ()
        granted = Granted(self.epoch, now, reason, accepted, events, met, self.ended)
        if None in accepted:
            self._stop_waiting(participant)
        for reply_to in participant.answer(request.epoch, granted):
            self._simulator.answer(reply_to, granted)

    def end(self, why: str, reason: str) -> None:
        """End the run: abort every goal, and remove all participants after reporting the ends of their goals.

        Participants that wait for a grant receive the report now, the others when they ask. A second call does nothing.

        Args:
            why: The reason for the end of the run.
            reason: The message in the results of the active goals.
        """
        if self.ended:
            return
        self.ended, self.granting = why, False
        self._participants.expect_nobody()
        asked = [each for each in self._participants.all if each.request is not None]
        for name in self.participants:
            self._participants.remove(name, "left", why, error=f"participant {name!r} was removed: {why}")
        self._submit_changes()
        self._submit_plans()
        self._simulator.stop(reason)
        if "feedback" in self._kinds:
            self._sort_events()
        for participant in asked:
            self._answer(participant, "end")

    def report_end(self, command: Advance) -> None:
        """Answer a participant that asks to advance after the end of the run."""
        wanted = kinds_wanted(command)
        events = tuple(each for each in self._events if each[0] in wanted)
        granted = Granted(self.epoch, self._simulator.now, "end", events=events, over=self.ended or _ENDED)
        self._simulator.answer(command.reply_to, granted)

    def dismiss(self, why: str) -> None:
        """Remove all participants, as the clock is no longer lockstep."""
        self.granting = False
        for name in self.participants:
            self._remove(name, "left", why, error=f"participant {name!r} was removed: {why}; join again")
        self._submit_changes()
        self._submit_plans()
        self._events.clear()
        self._record(NO_KINDS)

    def restart(self) -> None:
        """Restart at epoch 0; a participant that waits for a grant receives the changes of its goals by the reset."""
        self.granting = False
        self.epoch = 0
        thinks = self.thinks
        for participant in self._participants.all:
            participant.behind = None
            if participant.request is not None and not participant.state.stalled:
                self._answer(participant, "event")
        if not thinks:
            self._forget_events()

    def _remove(self, name: str, change: str, why: str = "", *, error: str = "") -> None:
        participant = self._participants.by_name.get(name)
        if participant and participant.request is not None:
            self._answer(participant, "end")
        self._participants.remove(name, change, why, error=error)
        self._conditions.drop(name)
        if not self._participants.all:
            self.granting = False
            if not self._participants.missing:
                self._submit_changes()

    def _submit_changes(self) -> None:
        """Submit the changes of participation since the last grant."""
        for change in self._participants.take_changes():
            self._simulator.submit(change, change.participant)

    def _submit_plans(self) -> bool:
        """Submit the plans that are kept for the end of an instant; return whether there are any."""
        answers = self._simulator.plans.take_kept()
        for answer in answers:
            self._simulator.submit(answer)
        return bool(answers)

    def _stop_waiting(self, participant: Participant) -> None:
        """Wait no longer for results that a participant wanted and that are not there yet."""
        for slot in participant.slots:
            if slot.wanted is not None and slot.answer is None:
                self._simulator.submit(StopWaiting(*slot.wanted[:3], reply_tos=(slot,)))

    @property
    def topics(self) -> Collection[Topic]:
        """The topics on which a participant waits for something; changes of goals are emitted anyway."""
        topics = self._conditions.topics
        return topics | {Topic.FEEDBACK} if "feedback" in self._kinds else topics

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._handlers.get(kind)

    def _follow(self, output: Output) -> None:
        if self._conditions.watched:
            self._conditions.emit(output)

    def _record(self, kinds: frozenset[str]) -> None:
        """Record events of these kinds from now on."""
        changed = (kinds ^ self._kinds) & {"feedback"}
        self._kinds = kinds
        if changed:
            self._simulator.submit(InterestChanged())

    def _on_goal_changed(self, change: GoalChanged) -> None:
        dispatcher = self._simulator.dispatcher
        # Every goal changes several times, and most participants wait for its result alone.
        relevant = change.result is not None or "status" in self._kinds or change.robot in dispatcher.cut_off
        if relevant and change.robot not in dispatcher.updates.late:
            self._record_change(change)
        if self._conditions.watched:
            self._conditions.emit(change)

    def _record_change(self, change: GoalChanged) -> None:
        """Record a change of a goal when participants may know it."""
        if change.robot in self._simulator.dispatcher.cut_off:
            self._withheld.append(change)
            return
        if "status" in self._kinds:
            self._record_event("status", change.stamp, change)
        if change.result is not None and "result" in self._kinds:
            self._record_event("result", change.stamp, change)

    def _on_feedback(self, feedback: FeedbackSent) -> None:
        if "feedback" in self._kinds:
            self._record_event("feedback", stamp(self._simulator.now), feedback)
        self._follow(feedback)

    def _on_roster_changed(self, _changed: RosterChanged) -> None:
        """Record the withheld changes of goals of robots that are connected again."""
        withheld, self._withheld = self._withheld, []
        for change in withheld:
            self._record_change(change)
        self._conditions.follow()

    def _record_event(self, kind: str, at: int, event: GoalChanged | FeedbackSent) -> None:
        self._events.append((kind, at, event))
        if self.granting and not self._woken and kind in self._wake:
            self._halt()

    def _on_condition_met(self) -> None:
        if self.granting and not self._woken and self._has_news:
            self._halt()

    def _halt(self) -> None:
        """End the grant with this instant."""
        self._woken = True
        self._horizon = self._env.now
        self._simulator.halt()

    def _sort_events(self) -> None:
        """Put samples of one instant into the order of robots, as other subscribers could change theirs."""
        ordered: list[Reported] = []
        for (kind, _), group in itertools.groupby(self._events, key=lambda event: event[:2]):
            found = list(group)
            if kind == "feedback":
                found.sort(key=lambda event: (event[2].robot, event[2].action, event[2].goal_id))
            ordered += found
        self._events = ordered

    def _forget_events(self) -> None:
        """Clear the events, but keep those that stalled participants have missed."""
        for each in self._participants.all:
            if each.state.stalled or each.behind is not None:
                each.missed += [event for event in self._events if event[0] in each.kinds]
        self._events.clear()

    def _refuse(self, reply_to: Any, name: str, value: object, text: str) -> None:
        self._simulator.answer(reply_to, Refused(name, value, text))

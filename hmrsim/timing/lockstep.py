"""Lockstep: simulated time advances only as far as all controllers allow, as with HLA's next message request.

Time is granted in epochs. A grant begins when every participant has asked to advance. First its commands are
applied in order of (participant's name, index), then events are taken up to the least time that was asked for, or
to the end of the first instant with an event that a participant wants to be woken for. So neither
the order of messages on the network nor a participant's thinking time affects the run.

This module uses neither network nor wall clock: `hmrsim.timing.pacing` passes requests to it and calls `proceed`.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from hmrsim.protocol.answers import Refused
from hmrsim.protocol.time import HasLeft, Join, Joined, Leave
from hmrsim.timing.absences import Absences
from hmrsim.timing.grants import ENDED, Grants
from hmrsim.timing.participants import Participants

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Advance
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic
    from hmrsim.simulation.simulator import Simulator

_log = logging.getLogger(__name__)


class LockstepCoordinator:
    """Grants time to participants; a sink of the simulation, so that it receives the events that they wait for.

    Args:
        awaited: How many participants have to join before time moves for the first time, or their names.
        until: When the run ends, in simulated seconds.

    Attributes:
        lost: Which participant was dropped last, and why; empty if none was.
    """

    def __init__(self, simulator: Simulator, *, awaited: int | Collection[str] = 1, until: float = math.inf) -> None:
        self._simulator = simulator
        self._end = until
        self.lost = ""
        self._participants = Participants(awaited)
        self._absences = Absences()
        self._grants = Grants(simulator, self._participants, self._absences, until=until, on_over=self._end_in_time)

    @property
    def epoch(self) -> int:
        """The next grant."""
        return self._grants.epoch

    @property
    def participants(self) -> tuple[str, ...]:
        """The names of the participants."""
        return self._participants.names

    @property
    def thinks(self) -> bool:
        """Whether a participant has yet to ask to advance."""
        return bool(self._grants.thinking)

    @property
    def waiting_for(self) -> tuple[str, ...]:
        """The participants that have yet to ask to advance, or to join for the first time."""
        thinking = [each.name for each in self._grants.thinking]
        return tuple(sorted((*thinking, *self._participants.missing, *self._absences.awaited)))

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
        self._simulator.answer(command.reply_to, Joined(command.name, self._grants.next, self._simulator.now, goals))

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
        if self._grants.under_way or self._simulator.paused:
            return []
        return sorted(each.name for each in self._grants.thinking if each.since < before)

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
            participant.behind = self._grants.next
        for slot in participant.slots:
            slot.wakes = slot.woke = False
        self._absences.stall(name, until)
        self._grants.reconsider()

    def expect(self, name: str, at: float = 0.0, on_due: Callable[[], None] = lambda: None) -> None:
        """Let time go on until some time, also without any participant, and wait there for one to join.

        Args:
            name: Who joins; empty for nobody, so that nothing is waited for.
            at: Simulated seconds; infinite to let time go on as far as anything is scheduled.
            on_due: Called when it is that time.
        """
        self._absences.expect(name, at, on_due)
        self._absences.end(self._simulator.now)
        self._grants.reconsider()

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
            self._grants.stop_waiting(participant)
            participant.open = None
        self._remove(name, "dropped", why, error=error)
        self._grants.reconsider()

    def end(self, why: str, reason: str) -> None:
        """End the run: abort every goal, and remove all participants, which are told how their goals have ended.

        Those that wait for a grant are told now, the others when they ask; nothing happens if it has ended already.

        Args:
            why: What ended the run.
            reason: The message in the results of the goals.
        """
        if self._grants.why_over:
            return
        self._grants.close(why)
        self._absences.clear()
        asked = [participant for participant, _ in self._participants.asking]
        for name in self.participants:
            self._participants.remove(name, "left", why, error=f"participant {name!r} was removed: {why}")
        self._grants.submit_kept()
        self._simulator.stop(reason)
        self._grants.tell_ended(asked)

    def tell_end(self, command: Advance) -> None:
        """Answer a participant that asks to advance after the end of the run."""
        self._grants.tell_end(command)

    def dismiss(self, why: str) -> None:
        """Remove all participants, as the clock is no longer lockstep."""
        self._grants.abandon()
        for name in self.participants:
            self._remove(name, "left", why, error=f"participant {name!r} was removed: {why}; join again")
        self._grants.dismiss()

    def restart(self) -> None:
        """Restart at epoch 0; a participant that waits for a grant receives the changes of its goals by the reset."""
        self._grants.restart()

    def _remove(self, name: str, change: str, why: str = "", *, error: str = "") -> None:
        participant = self._participants.get(name)
        if participant and participant.open is not None:
            self._grants.answer(participant, "end")
        self._participants.remove(name, change, why, error=error)
        self._absences.note_gone(name)
        self._grants.forget(name)
        if not self._participants:
            self._grants.abandon()
            if not self._participants.missing:
                self._grants.submit_changes()

    def advance(self, command: Advance, wall: float) -> None:
        """Record a participant's request to advance; a repeated request gets the same answer."""
        name = command.participant
        participant = self._participants.get(name)
        if participant is None:
            self._refuse(command.reply_to, "participant", name, self._participants.why_unknown(name))
            return
        if participant.open is not None and participant.open.epoch == command.epoch:
            participant.askers.append(command.reply_to)
        elif participant.last is not None and participant.last[0] == command.epoch != self._grants.next:
            self._simulator.answer(command.reply_to, participant.last[1])
        elif command.epoch in (self._grants.next, participant.behind) and participant.open is None:
            participant.open, participant.since = command, wall
            participant.askers = [command.reply_to]
            participant.begun = participant.early = False
        else:
            text = f"epoch {command.epoch} is not the current one, which is {self._grants.next}"
            if participant.open is not None:
                text = f"epoch {participant.open.epoch} is being waited for; its answer says which is next"
            self._refuse(command.reply_to, "epoch", command.epoch, text)

    @property
    def ready(self) -> bool:
        """Whether a grant may begin: all awaited participants have joined, and every participant has asked for it."""
        if self._grants.under_way or self._simulator.paused or not (self._participants or self._absences):
            return False
        return not (self._grants.thinking or self._participants.missing or self._absences.awaited)

    @property
    def granting(self) -> bool:
        """Whether time is being granted just now."""
        return self._grants.under_way

    @property
    def over(self) -> bool:
        """Whether it is the time at which the run ends."""
        return self._grants.over

    def begin(self) -> None:
        """Begin a grant: apply the commands of this epoch."""
        self._grants.begin()

    def proceed(self, most: int, wall: float) -> bool:
        """Process at most so many events of a grant; return whether more may be processed at once.

        At the end of the grant every participant gets its answer.
        """
        return self._grants.proceed(most, wall)

    def wants(self, topic: Topic) -> bool:
        """Return whether a participant waits for something on a topic; changes of goals are emitted anyway."""
        return self._grants.wants(topic)

    def emit(self, output: Output) -> None:
        """Record an event that a participant waits for."""
        self._grants.emit(output)

    def _end_in_time(self) -> None:
        self.end(f"it was to last {self._end:g} s", ENDED)

    def _refuse(self, reply_to: Any, name: str, value: object, text: str) -> None:
        self._simulator.answer(reply_to, Refused(name, value, text))

"""The commands that participants in lockstep send with their requests to advance, and where the answers go."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from hmrsim.protocol.answers import Refused, ResultResponse
from hmrsim.protocol.commands import CancelGoal, GetResult, SendGoal, StopWaiting, Unreadable
from hmrsim.protocol.conditions import Unwatch, Watch
from hmrsim.protocol.goal_ids import made_goal_id
from hmrsim.timing.participants import Slot

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.conditions import Conditions
    from hmrsim.timing.participants import Participant, Participants

Given = SendGoal | CancelGoal | GetResult | Watch | Unwatch | Unreadable
"""A command that is sent with a request to advance."""


class GivenCommands:
    """Applies such commands, and fills in the slots of their answers.

    Args:
        on_woken: Called for an answer that wakes its participant, as no event would.
    """

    def __init__(
        self,
        simulator: Simulator,
        participants: Participants,
        conditions: Conditions,
        on_woken: Callable[[], None],
    ) -> None:
        self._simulator = simulator
        self._participants = participants
        self._conditions = conditions
        self._on_woken = on_woken

    def give(self, participant: Participant, commands: Iterable[Given], *, wakes: bool) -> None:
        """Apply a participant's commands in order; *wakes*: it wants to be woken for results."""
        given = [(command, Slot(wakes)) for command in commands]
        participant.slots = [slot for _, slot in given]
        for command, slot in given:
            self._give(command, participant.name, slot)

    def _give(self, command: Given, name: str, slot: Slot) -> None:
        match command:
            case Watch():
                self.note_answer(slot, self._conditions.watch(name, command))
                return
            case Unwatch():
                slot.answer = self._conditions.unwatch(name, command.name)
                return
            case Unreadable(answer):
                # It may be a goal that its sender has numbered.
                self._participants.next_goal(name)
                self._fill(slot, answer, goes_on=False)
                return
            case SendGoal():
                number = self._participants.next_goal(name)
                goal_id = made_goal_id(name, number) if command.goal_id is None else command.goal_id
                command = command._replace(goal_id=goal_id)
            case GetResult():
                slot.wanted = command
        self._simulator.submit(command._replace(reply_to=slot), name)

    def note_answer(self, slot: Slot, answer: Any) -> None:
        """Take the answer to a command."""
        self._fill(slot, answer, goes_on=_goes_on(answer))

    def stop_waiting(self, participant: Participant) -> None:
        """Wait no longer for results that a participant wanted and that are not there yet."""
        for slot in participant.slots:
            if slot.wanted is not None and slot.answer is None:
                self._simulator.submit(StopWaiting(*slot.wanted[:3], reply_tos=(slot,)))

    def _fill(self, slot: Slot, answer: Any, *, goes_on: bool) -> None:
        slot.answer = answer
        if slot.wakes and not goes_on:
            # It counts as the result: no later event could wake the participant that sent the command.
            slot.woke = True
            self._on_woken()


def _goes_on(answer: Any) -> bool:
    """Return whether a command has an effect of which an event will tell."""
    return not isinstance(answer, (Refused, ResultResponse)) and getattr(answer, "accepted", True)

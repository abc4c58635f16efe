"""The connection to the robot is lost: nothing that it publishes arrives, requests to it are refused."""

from __future__ import annotations

from collections.abc import Callable

from hmrsim.faults import Case, FaultType, Name, Spell


class MessagesLost(Spell):
    """The loss of a robot's connection.

    Attributes:
        robot: The robot's name.
    """

    robot: Name


def _begin(case: Case[MessagesLost]) -> Callable[[], None]:
    name = case.settings.robot
    case.roster.connect(name, connected=False)

    def end() -> None:
        if not case.concurrent():
            case.roster.connect(name, connected=True)

    return end


FAULT = FaultType(
    name="messages_lost",
    settings=MessagesLost,
    begin=_begin,
    example={"robot": "wall_e"},
    title="Connection lost",
    changes="connected",
)

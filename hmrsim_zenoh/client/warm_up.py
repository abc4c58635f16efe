"""Work of a client that takes long when it is done first, done before a robot waits for it.

pydantic builds what reads and writes a message when that is first used: a tenth of a second for MoveIt's large ones.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim_zenoh.wire.envelopes import GetResultResponse, SendGoalRequest, SendGoalResponse, around, plain, read

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message

_ACCEPTED = b'{"accepted":true,"goal_id":"","stamp":{}}'
_ENDED = b'{"status":0,"result":{}}'


def for_client(action: AnyAction) -> None:
    """Be ready to send goals of an action, and to read what comes of them."""
    result: type[Message] = action.result
    SendGoalRequest(goal_id="", goal=action.goal()).model_dump_json()
    read(plain(SendGoalResponse), _ACCEPTED)
    read(around(GetResultResponse, result), _ENDED)

"""Slow first-time work of a client, done before a robot waits for it.

pydantic builds a message's validator and serializer upon first use, which takes 0.1 s for MoveIt's large messages.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import GetResultResponse, SendGoalResponse, around, plain, read

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message

_ACCEPTED = b'{"accepted":true,"goal_id":"","stamp":{}}'
_ENDED = b'{"status":0,"result":{}}'


def for_client(action: AnyAction) -> None:
    """Prepare to send goals of an action and to read their feedback and results."""
    result: type[Message] = action.result
    encoding.message(action.goal())
    read(plain(SendGoalResponse), _ACCEPTED)
    read(around(GetResultResponse, result), _ENDED)

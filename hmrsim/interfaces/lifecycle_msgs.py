"""The states of nodes that are configured and activated, as Nav2's are."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.message import Message, String, UInt8


class State(Message):
    """A state by number and name."""

    PRIMARY_STATE_UNKNOWN: ClassVar[int] = 0
    PRIMARY_STATE_UNCONFIGURED: ClassVar[int] = 1
    PRIMARY_STATE_INACTIVE: ClassVar[int] = 2
    PRIMARY_STATE_ACTIVE: ClassVar[int] = 3
    PRIMARY_STATE_FINALIZED: ClassVar[int] = 4

    TRANSITION_STATE_CONFIGURING: ClassVar[int] = 10
    TRANSITION_STATE_CLEANINGUP: ClassVar[int] = 11
    TRANSITION_STATE_SHUTTINGDOWN: ClassVar[int] = 12
    TRANSITION_STATE_ACTIVATING: ClassVar[int] = 13
    TRANSITION_STATE_DEACTIVATING: ClassVar[int] = 14
    TRANSITION_STATE_ERRORPROCESSING: ClassVar[int] = 15

    id: UInt8 = 0
    label: String = ""


class GetState:
    """Ask a node for its state."""

    class Request(Message):
        """Empty."""

    class Response(Message):
        """The state it is in."""

        current_state: State = Field(default_factory=State)

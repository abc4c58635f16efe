"""The states of nodes that are configured and activated, as Nav2's are."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from hmrsim.interfaces.message import Bool, Message, String, UInt8


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


class Transition(Message):
    """A change of state, by number and name; a number for each beginning and for each end."""

    TRANSITION_CREATE: ClassVar[int] = 0
    TRANSITION_CONFIGURE: ClassVar[int] = 1
    TRANSITION_CLEANUP: ClassVar[int] = 2
    TRANSITION_ACTIVATE: ClassVar[int] = 3
    TRANSITION_DEACTIVATE: ClassVar[int] = 4
    TRANSITION_UNCONFIGURED_SHUTDOWN: ClassVar[int] = 5
    TRANSITION_INACTIVE_SHUTDOWN: ClassVar[int] = 6
    TRANSITION_ACTIVE_SHUTDOWN: ClassVar[int] = 7
    TRANSITION_DESTROY: ClassVar[int] = 8

    id: UInt8 = 0
    label: String = ""


class TransitionDescription(Message):
    """A transition and the states that it connects."""

    transition: Transition = Field(default_factory=Transition)
    start_state: State = Field(default_factory=State)
    goal_state: State = Field(default_factory=State)


class ChangeState:
    """Ask a node for a transition."""

    class Request(Message):
        """The transition; its label, if there is one, matters more than its number."""

        transition: Transition = Field(default_factory=Transition)

    class Response(Message):
        """Whether the node is in the new state."""

        success: Bool = False


class GetAvailableStates:
    """Ask a node for the states that it may have."""

    class Request(Message):
        """Empty."""

    class Response(Message):
        """The states."""

        available_states: list[State] = Field(default_factory=list)


class GetAvailableTransitions:
    """Ask a node for its transitions: those from its state, or all."""

    class Request(Message):
        """Empty."""

    class Response(Message):
        """The transitions."""

        available_transitions: list[TransitionDescription] = Field(default_factory=list)

"""The states and transitions of managed nodes, such as Nav2's."""

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
    """Return the state of a node."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The current state of the node."""

        current_state: State = Field(default_factory=State)


class Transition(Message):
    """A transition by number and name; its start and each of its ends have their own numbers."""

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
    """Change the state of a node."""

    class Request(Message):
        """The transition; a label takes precedence over the number."""

        transition: Transition = Field(default_factory=Transition)

    class Response(Message):
        """True if the node is in the new state."""

        success: Bool = False


class GetAvailableStates:
    """List the states that a node can have."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The states that the node can have."""

        available_states: list[State] = Field(default_factory=list)


class GetAvailableTransitions:
    """List the transitions of a node: all, or those from its state."""

    class Request(Message):
        """The request, which has no fields."""

    class Response(Message):
        """The transitions of the node."""

        available_transitions: list[TransitionDescription] = Field(default_factory=list)

"""The states of the ROS nodes that serve robots' actions: one that is not active rejects goals, as Nav2's do.

Goals know actions only; the command that changes a state says which actions the node serves.
"""

from __future__ import annotations

from collections import defaultdict
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.errors import GoalRejected
from hmrsim.interfaces.lifecycle_msgs import State, Transition

if TYPE_CHECKING:
    from hmrsim.protocol.commands import ChangeState, SendGoal

ACTIVE: Final = State.PRIMARY_STATE_ACTIVE

NAMES: Final = MappingProxyType(
    {
        State.PRIMARY_STATE_UNCONFIGURED: "unconfigured",
        State.PRIMARY_STATE_INACTIVE: "inactive",
        ACTIVE: "active",
        State.PRIMARY_STATE_FINALIZED: "finalized",
    }
)
"""The names of the states that a node stays in."""

TRANSITIONS: Final = MappingProxyType(
    {
        Transition.TRANSITION_CONFIGURE: (State.PRIMARY_STATE_UNCONFIGURED, State.PRIMARY_STATE_INACTIVE),
        Transition.TRANSITION_CLEANUP: (State.PRIMARY_STATE_INACTIVE, State.PRIMARY_STATE_UNCONFIGURED),
        Transition.TRANSITION_ACTIVATE: (State.PRIMARY_STATE_INACTIVE, ACTIVE),
        Transition.TRANSITION_DEACTIVATE: (ACTIVE, State.PRIMARY_STATE_INACTIVE),
        Transition.TRANSITION_UNCONFIGURED_SHUTDOWN: (State.PRIMARY_STATE_UNCONFIGURED, State.PRIMARY_STATE_FINALIZED),
        Transition.TRANSITION_INACTIVE_SHUTDOWN: (State.PRIMARY_STATE_INACTIVE, State.PRIMARY_STATE_FINALIZED),
        Transition.TRANSITION_ACTIVE_SHUTDOWN: (ACTIVE, State.PRIMARY_STATE_FINALIZED),
    }
)
"""The transitions that a client may ask for, each with the states before and after."""


class NodeStates:
    """The states of all nodes: a node is active unless a client has changed that."""

    def __init__(self) -> None:
        self._states: defaultdict[str, dict[str, int]] = defaultdict(dict)
        self._inactive: dict[tuple[str, str], str] = {}

    def of(self, robot: str, node: str) -> int:
        """Return the state of a node."""
        return self._states[robot].get(node, ACTIVE) if robot in self._states else ACTIVE

    def change(self, command: ChangeState) -> bool:
        """Change the state of a node; return whether the transition begins at its state."""
        robot, node = command.robot, command.node
        before, after = TRANSITIONS.get(command.transition, (None, ACTIVE))
        if before != self.of(robot, node):
            return False
        self._states[robot][node] = after
        for action in command.actions:
            if after == ACTIVE:
                self._inactive.pop((robot, action), None)
            else:
                self._inactive[robot, action] = node
        return True

    def check(self, command: SendGoal) -> None:
        """Check that the node which serves an action is active.

        Raises:
            GoalRejected: It is not.
        """
        node = self._inactive.get((command.robot, command.action)) if self._inactive else None
        if node is not None:
            state = NAMES[self.of(command.robot, node)]
            raise GoalRejected("not_ready", f"{node} of {command.robot} is {state}; activate it")

    def forget(self, robot: str) -> None:
        """Forget a robot that has gone."""
        if self._states.pop(robot, None):
            self._inactive = {key: node for key, node in self._inactive.items() if key[0] != robot}

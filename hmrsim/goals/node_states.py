"""The lifecycle states of the ROS nodes that serve actions; as in Nav2, a node that is not active rejects goals.

Goals name actions and not nodes, so the command that changes a node's state lists the actions that it serves.
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
"""The names of the primary states, in which a node can stay."""

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
"""The transitions that a client may request, each with the states before and after it."""


class NodeStates:
    """The lifecycle states of all nodes; a node is active until a client changes its state."""

    def __init__(self) -> None:
        self._states: defaultdict[str, dict[str, int]] = defaultdict(dict)
        self._inactive: dict[tuple[str, str], str] = {}

    def of(self, robot: str, node: str) -> int:
        """Return the state of a node."""
        return self._states[robot].get(node, ACTIVE) if robot in self._states else ACTIVE

    def change(self, command: ChangeState) -> bool:
        """Change the state of a node; return False if its state does not allow the transition."""
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
            GoalRejected: The node is not active.
        """
        node = self._inactive.get((command.robot, command.action)) if self._inactive else None
        if node is not None:
            state = NAMES[self.of(command.robot, node)]
            raise GoalRejected("not_ready", f"{node} of {command.robot} is {state}; activate it")

    def forget(self, robot: str) -> None:
        """Forget the nodes of a robot that has left the world."""
        if self._states.pop(robot, None):
            self._inactive = {key: node for key, node in self._inactive.items() if key[0] != robot}

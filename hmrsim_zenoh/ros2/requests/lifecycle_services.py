"""The lifecycle services of ROS nodes: states of rcl_lifecycle, and the transitions between them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.goals.node_states import ACTIVE, NAMES, TRANSITIONS
from hmrsim.interfaces.lifecycle_msgs import (
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
    State,
    Transition,
    TransitionDescription,
)
from hmrsim.interfaces.nav2_msgs import ManageLifecycleNodes
from hmrsim.interfaces.std_srvs import Trigger
from hmrsim.protocol.commands import ChangeState
from hmrsim_zenoh.ros2.names import LOCALIZATION, has_lifecycle, nodes_of
from hmrsim_zenoh.ros2.requests.handlers import NodeHandler

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.keys import Node
    from hmrsim_zenoh.ros2.requests.handlers import PendingRosReply

_UNKNOWN, _ERROR = State.PRIMARY_STATE_UNKNOWN, State.TRANSITION_STATE_ERRORPROCESSING

_STATES: Final = MappingProxyType(
    {
        _UNKNOWN: "unknown",
        **NAMES,
        State.TRANSITION_STATE_CONFIGURING: "configuring",
        State.TRANSITION_STATE_CLEANINGUP: "cleaningup",
        State.TRANSITION_STATE_SHUTTINGDOWN: "shuttingdown",
        State.TRANSITION_STATE_ACTIVATING: "activating",
        State.TRANSITION_STATE_DEACTIVATING: "deactivating",
        _ERROR: "errorprocessing",
    }
)
"""All states of rcl_lifecycle, in its order."""

_LABELS: Final = MappingProxyType(
    {
        Transition.TRANSITION_CONFIGURE: "configure",
        Transition.TRANSITION_CLEANUP: "cleanup",
        Transition.TRANSITION_ACTIVATE: "activate",
        Transition.TRANSITION_DEACTIVATE: "deactivate",
        Transition.TRANSITION_UNCONFIGURED_SHUTDOWN: "shutdown",
        Transition.TRANSITION_INACTIVE_SHUTDOWN: "shutdown",
        Transition.TRANSITION_ACTIVE_SHUTDOWN: "shutdown",
    }
)

_DURING: Final = MappingProxyType(
    {
        "configure": State.TRANSITION_STATE_CONFIGURING,
        "cleanup": State.TRANSITION_STATE_CLEANINGUP,
        "activate": State.TRANSITION_STATE_ACTIVATING,
        "deactivate": State.TRANSITION_STATE_DEACTIVATING,
        "shutdown": State.TRANSITION_STATE_SHUTTINGDOWN,
    }
)
"""The transition states; a simulated node leaves them at once."""

_OUTCOMES: Final = ("transition_success", "transition_failure", "transition_error")
"""The labels of the transitions out of transition states; their numbers count from ten times the first's."""


def get_state(simulator: Simulator, node: Node, _request: Mapping[str, Any]) -> Message:
    """Return the state of a node."""
    return GetState.Response(current_state=_state(_state_of(simulator, node)))


def get_available_states(_simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Message:
    """Return all states."""
    return GetAvailableStates.Response(available_states=[_state(number) for number in _STATES])


def get_available_transitions(simulator: Simulator, node: Node, _request: Mapping[str, Any]) -> Message:
    """Return the transitions from the current state of a node."""
    return GetAvailableTransitions.Response(available_transitions=_available(simulator, node))


def get_transition_graph(_simulator: Simulator, _node: Node, _request: Mapping[str, Any]) -> Message:
    """Return all transitions."""
    return GetAvailableTransitions.Response(available_transitions=[*_requestable(), *_outcomes()])


@dataclass(frozen=True)
class _StatesHandler(NodeHandler):
    """The handler of a service that changes the states of nodes.

    Attributes:
        actions: The nodes, each with the actions that it serves.
    """

    actions: Mapping[Node, tuple[str, ...]]

    def answer(self, changed: object) -> Message:
        """Return whether the states have changed."""
        return self.response.model_validate({"success": changed is True})


class ChangeStateHandler(_StatesHandler):
    """The handler of ``change_state`` of a lifecycle node."""

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the command that changes the state."""
        number, label = request["transition"]["id"], request["transition"]["label"]
        if label:
            possible = (one.transition for one in _available(self.simulator, self.node))
            number = next((transition.id for transition in possible if transition.label == label), None)
        if number is None:
            reply_to.answer(False)
            return []
        return [ChangeState(self.node.robot, self.node.name, self.actions[self.node], number, reply_to)]


def managed(nodes: Iterable[Node], manager: Node) -> list[Node]:
    """Return the nodes of a robot that a lifecycle manager manages, as in Nav2's launch files.

    Args:
        nodes: All nodes of the robot.
        manager: The node that serves as the manager: that of localization manages itself, the other one all others.
    """
    of_localization = manager.name == LOCALIZATION
    return [node for node in nodes if has_lifecycle(node) and (node.name == LOCALIZATION) is of_localization]


def is_active(simulator: Simulator, node: Node, _request: Mapping[str, Any]) -> Message:
    """Return whether all nodes of a lifecycle manager are active."""
    actions = tuple(simulator.dispatcher.servers.actions_of(node.robot))
    nodes = managed(nodes_of(node.robot, actions), node)
    return Trigger.Response(success=all(_state_of(simulator, one) == ACTIVE for one in nodes))


RESPONSES: Final = MappingProxyType(
    {
        "get_state": get_state,
        "get_available_states": get_available_states,
        "get_available_transitions": get_available_transitions,
        "get_transition_graph": get_transition_graph,
        "is_active": is_active,
    }
)
"""The function that responds to each lifecycle service, except for ``change_state`` and ``manage_nodes``."""

_UNCONFIGURED, _INACTIVE = State.PRIMARY_STATE_UNCONFIGURED, State.PRIMARY_STATE_INACTIVE

_TARGETS: Final = MappingProxyType(
    {
        ManageLifecycleNodes.Request.STARTUP: ACTIVE,
        ManageLifecycleNodes.Request.PAUSE: _INACTIVE,
        ManageLifecycleNodes.Request.RESUME: ACTIVE,
        ManageLifecycleNodes.Request.RESET: _UNCONFIGURED,
        ManageLifecycleNodes.Request.SHUTDOWN: State.PRIMARY_STATE_FINALIZED,
        ManageLifecycleNodes.Request.CONFIGURE: _INACTIVE,
        ManageLifecycleNodes.Request.CLEANUP: _UNCONFIGURED,
    }
)
"""The state that each command of a lifecycle manager leads to."""


_ASCENT: Final = (_UNCONFIGURED, _INACTIVE, ACTIVE)
_UP: Final = (Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE)
_DOWN: Final = (Transition.TRANSITION_CLEANUP, Transition.TRANSITION_DEACTIVATE)
"""The transitions from each state of the ascent to the next one, and back."""


def _path(state: int, target: int) -> Sequence[int] | None:
    """Return the transitions from one state to another; None if there is no way."""
    if target == State.PRIMARY_STATE_FINALIZED:
        return [number for number, change in TRANSITIONS.items() if change == (state, target)]
    if state not in _ASCENT:
        return None
    here, there = _ASCENT.index(state), _ASCENT.index(target)
    return _UP[here:there] or _DOWN[there:here][::-1]


class ManageNodesHandler(_StatesHandler):
    """The handler of ``manage_nodes`` of a lifecycle manager, whose node serves as the manager."""

    def commands(self, request: Mapping[str, Any], reply_to: PendingRosReply) -> list[AnyCommand]:
        """Return the commands that change the states; the last one is answered."""
        target = _TARGETS.get(request["command"])
        paths = {node: _path(_state_of(self.simulator, node), target) for node in self.actions if target is not None}
        if target is None or self.node.robot in self.simulator.dispatcher.cut_off or None in paths.values():
            reply_to.answer(False)
            return []
        commands = [
            ChangeState(node.robot, node.name, self.actions[node], number)
            for node, path in paths.items()
            for number in path or ()
        ]
        if not commands:
            reply_to.answer(True)
            return []
        return [*commands[:-1], commands[-1]._replace(reply_to=reply_to)]


def _state_of(simulator: Simulator, node: Node) -> int:
    return simulator.dispatcher.nodes.of(node.robot, node.name)


def _available(simulator: Simulator, node: Node) -> list[TransitionDescription]:
    state = _state_of(simulator, node)
    return [one for one in _requestable() if one.start_state.id == state]


def _state(number: int) -> State:
    return State(id=number, label=_STATES[number])


def _transition(number: int, label: str, start: int, goal: int) -> TransitionDescription:
    return TransitionDescription(
        transition=Transition(id=number, label=label), start_state=_state(start), goal_state=_state(goal)
    )


def _requestable() -> Iterator[TransitionDescription]:
    for number, (before, _) in TRANSITIONS.items():
        yield _transition(number, _LABELS[number], before, _DURING[_LABELS[number]])


def _outcomes() -> Iterator[TransitionDescription]:
    """Yield the transitions out of transition states: success, failure and error."""
    unconfigured, inactive, finalized = (
        State.PRIMARY_STATE_UNCONFIGURED,
        State.PRIMARY_STATE_INACTIVE,
        State.PRIMARY_STATE_FINALIZED,
    )
    after = {
        "configure": (inactive, unconfigured),
        "cleanup": (unconfigured, inactive),
        "activate": (ACTIVE, inactive),
        "deactivate": (inactive, ACTIVE),
        "shutdown": (finalized, finalized),
    }
    for tens, (label, (success, failure)) in enumerate(after.items(), start=1):
        for units, (end, goal) in enumerate(zip(_OUTCOMES, (success, failure, _ERROR), strict=True)):
            yield _transition(10 * tens + units, end, _DURING[label], goal)
    for units, (end, goal) in enumerate(zip(_OUTCOMES, (unconfigured, finalized, finalized), strict=True)):
        yield _transition(60 + units, end, _ERROR, goal)

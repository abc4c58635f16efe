"""Handlers of the services that each ROS node has by itself: parameters and lifecycle."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeVar

from hmrsim.goals.fault_effects import no_connection
from hmrsim.goals.node_states import ACTIVE, NAMES, TRANSITIONS
from hmrsim.interfaces.lifecycle_msgs import ChangeState as ChangeStateService
from hmrsim.interfaces.lifecycle_msgs import (
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
    State,
    Transition,
    TransitionDescription,
)
from hmrsim.interfaces.rcl_interfaces import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    ListParametersResult,
    SetParameters,
    SetParametersAtomically,
    SetParametersResult,
)
from hmrsim.protocol.commands import ChangeState
from hmrsim_zenoh.ros2.requests.handlers import Handler
from hmrsim_zenoh.ros2.requests.parameters import names_in, parameters_of

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import AnyCommand
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.keys import Node
    from hmrsim_zenoh.ros2.requests.handlers import ReplyTo
    from hmrsim_zenoh.ros2.requests.parameters import NodeParameter

_Told = TypeVar("_Told")

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
"""The states that a node passes; a simulated one does so in no time."""

_ENDS: Final = ("transition_success", "transition_failure", "transition_error")
"""The labels of the transitions that end the passing states; their numbers count from ten times the beginning's."""


@dataclass(frozen=True)
class NodeHandler(Handler):
    """A handler that answers at once with what the simulation knows of a node.

    Attributes:
        SERVICE: The type of the service; its empty response tells nothing, and that nothing was done.
    """

    SERVICE: ClassVar[Any]

    node: Node
    simulator: Simulator

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Answer at once; there are no commands."""
        if self._robot in self.simulator.dispatcher.cut_off:
            reply_to.refuse(no_connection(self._robot))
        else:
            reply_to.answer(request)
        return []

    def refusal(self, _text: str) -> Message:
        """Return an empty response."""
        response: Message = self.SERVICE.Response()
        return response

    @property
    def _robot(self) -> str:
        return self.node.namespace[1:]

    @property
    def _parameters(self) -> dict[str, NodeParameter]:
        return parameters_of(self.simulator, self.node)

    def _of_each(self, request: Mapping[str, Any], what: Callable[[str, NodeParameter], _Told]) -> list[_Told]:
        """Return something of each parameter that is asked for; nothing at all if one is not there, as by rclcpp."""
        there, names = self._parameters, request["names"]
        return [what(name, there[name]) for name in names] if there.keys() >= set(names) else []

    @property
    def _state(self) -> int:
        return self.simulator.dispatcher.nodes.of(self._robot, self.node.name)


class GetParametersHandler(NodeHandler):
    """The handler of ``get_parameters``."""

    SERVICE = GetParameters

    def answer(self, request: Mapping[str, Any]) -> Message:
        """Return the values."""
        return GetParameters.Response(values=self._of_each(request, lambda _name, one: one.as_value()))


class GetParameterTypesHandler(NodeHandler):
    """The handler of ``get_parameter_types``."""

    SERVICE = GetParameterTypes

    def answer(self, request: Mapping[str, Any]) -> Message:
        """Return the types."""
        return GetParameterTypes.Response(types=self._of_each(request, lambda _name, one: one.type))


class DescribeParametersHandler(NodeHandler):
    """The handler of ``describe_parameters``."""

    SERVICE = DescribeParameters

    def answer(self, request: Mapping[str, Any]) -> Message:
        """Return the descriptions."""
        found = self._of_each(request, lambda name, one: one.as_descriptor(name))
        return DescribeParameters.Response(descriptors=found)


class ListParametersHandler(NodeHandler):
    """The handler of ``list_parameters``."""

    SERVICE = ListParameters

    def answer(self, request: Mapping[str, Any]) -> Message:
        """Return the names."""
        names = names_in(self._parameters, request["prefixes"], request["depth"])
        prefixes = list(dict.fromkeys(name.rpartition(".")[0] for name in names if "." in name))
        return ListParameters.Response(result=ListParametersResult(names=names, prefixes=prefixes))


class SetParametersHandler(NodeHandler):
    """The handler of ``set_parameters``: nothing can be set, as the world's file has the values."""

    SERVICE = SetParameters

    def answer(self, request: Mapping[str, Any]) -> Message:
        """Return why not, for each."""
        there = self._parameters
        return SetParameters.Response(results=[_not_set(one["name"], there) for one in request["parameters"]])


class SetParametersAtomicallyHandler(NodeHandler):
    """The handler of ``set_parameters_atomically``."""

    SERVICE = SetParametersAtomically

    def answer(self, request: Mapping[str, Any]) -> Message:
        """Return why not, for the first."""
        there = self._parameters
        results = [_not_set(one["name"], there) for one in request["parameters"]]
        return SetParametersAtomically.Response(result=(*results, SetParametersResult(successful=True))[0])

    def refusal(self, text: str) -> Message:
        """Return that nothing was set."""
        return SetParametersAtomically.Response(result=SetParametersResult(reason=text))


class GetStateHandler(NodeHandler):
    """The handler of ``get_state``."""

    SERVICE = GetState

    def answer(self, _request: Mapping[str, Any]) -> Message:
        """Return the state of the node."""
        return GetState.Response(current_state=_state(self._state))


class GetAvailableStatesHandler(NodeHandler):
    """The handler of ``get_available_states``."""

    SERVICE = GetAvailableStates

    def answer(self, _request: Mapping[str, Any]) -> Message:
        """Return all states."""
        return GetAvailableStates.Response(available_states=[_state(number) for number in _STATES])


class GetAvailableTransitionsHandler(NodeHandler):
    """The handler of ``get_available_transitions``."""

    SERVICE = GetAvailableTransitions

    def answer(self, _request: Mapping[str, Any]) -> Message:
        """Return the transitions from the state of the node."""
        found = [one for one in _beginnings() if one.start_state.id == self._state]
        return GetAvailableTransitions.Response(available_transitions=found)


class GetTransitionGraphHandler(GetAvailableTransitionsHandler):
    """The handler of ``get_transition_graph``."""

    def answer(self, _request: Mapping[str, Any]) -> Message:
        """Return all transitions."""
        return GetAvailableTransitions.Response(available_transitions=[*_beginnings(), *_endings()])


@dataclass(frozen=True)
class ChangeStateHandler(NodeHandler):
    """The handler of ``change_state``.

    Attributes:
        actions: The actions that the node serves.
    """

    SERVICE = ChangeStateService
    actions: tuple[str, ...]

    def commands(self, request: Mapping[str, Any], reply_to: ReplyTo) -> list[AnyCommand]:
        """Return the command that changes the state."""
        number, label = request["transition"]["id"], request["transition"]["label"]
        if label:
            possible = (one for one in _beginnings() if one.start_state.id == self._state)
            number = next((one.transition.id for one in possible if one.transition.label == label), None)
        if number is None:
            reply_to.answer(False)
            return []
        return [ChangeState(self._robot, self.node.name, self.actions, number, reply_to)]

    def answer(self, changed: object) -> Message:
        """Return whether the state has changed."""
        return ChangeStateService.Response(success=changed is True)


HANDLERS: Final[Mapping[str, type[NodeHandler]]] = MappingProxyType(
    {
        "get_parameters": GetParametersHandler,
        "get_parameter_types": GetParameterTypesHandler,
        "describe_parameters": DescribeParametersHandler,
        "list_parameters": ListParametersHandler,
        "set_parameters": SetParametersHandler,
        "set_parameters_atomically": SetParametersAtomicallyHandler,
        "get_state": GetStateHandler,
        "get_available_states": GetAvailableStatesHandler,
        "get_available_transitions": GetAvailableTransitionsHandler,
        "get_transition_graph": GetTransitionGraphHandler,
    }
)
"""The handlers of nodes' services, except for ``change_state``."""


def _not_set(name: str, there: Mapping[str, NodeParameter]) -> SetParametersResult:
    why = "is read-only: the world or the simulator's options say it" if name in there else "does not exist"
    return SetParametersResult(reason=f"parameter {name!r} {why}")


def _state(number: int) -> State:
    return State(id=number, label=_STATES[number])


def _transition(number: int, label: str, start: int, goal: int) -> TransitionDescription:
    return TransitionDescription(
        transition=Transition(id=number, label=label), start_state=_state(start), goal_state=_state(goal)
    )


def _beginnings() -> Iterator[TransitionDescription]:
    """Yield the transitions that clients may ask for."""
    for number, (before, _) in TRANSITIONS.items():
        yield _transition(number, _LABELS[number], before, _DURING[_LABELS[number]])


def _endings() -> Iterator[TransitionDescription]:
    """Yield the transitions that end those: in success, failure and error."""
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
        for units, (end, goal) in enumerate(zip(_ENDS, (success, failure, _ERROR), strict=True)):
            yield _transition(10 * tens + units, end, _DURING[label], goal)
    for units, (end, goal) in enumerate(zip(_ENDS, (unconfigured, finalized, finalized), strict=True)):
        yield _transition(60 + units, end, _ERROR, goal)

"""What can happen to a node of a kind, at its place in a tree, as far as that is known without running it.

What a leaf can return is known of the leaves of py_trees and of this package; of others, anything is taken as possible.
What a composite can return follows from its children. A node can be canceled if one above it halts running children,
and a failure can be recovered if one above it tries something else, or the same again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, TypeAlias

from py_trees.composites import Selector
from py_trees.composites import Sequence as SequenceOfPyTrees

from bt_controller.coverage.outcomes import CANCELED, FAILURE, RECOVERED, RUNNING, SUCCESS
from bt_controller.scripting.conditions import ScriptConditions

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

Outcomes: TypeAlias = frozenset[str]
_Which: TypeAlias = Callable[[int, int], bool]
"""Which children something is true of: by index and number of children."""


def _none(_index: int, _count: int) -> bool:
    return False


def _all(_index: int, _count: int) -> bool:
    return True


def _first(index: int, _count: int) -> bool:
    return index == 0


def _later(index: int, _count: int) -> bool:
    return index > 0


def _last(index: int, count: int) -> bool:
    return index == count - 1


def _but_last(index: int, count: int) -> bool:
    return index < count - 1


def _siblings(_index: int, count: int) -> bool:
    return count > 1


def _first_of_three(index: int, count: int) -> bool:
    return index == 0 and count > 2  # noqa: PLR2004 - with an else branch


_S: Final = frozenset({SUCCESS})
_F: Final = frozenset({FAILURE})
_R: Final = frozenset({RUNNING})
_NOTHING: Final[Outcomes] = frozenset()
_ANY: Final = _S | _F | _R


def _whole(children: Sequence[Outcomes]) -> Outcomes:
    return _NOTHING.union(*children)


def _sequence(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if all children have to succeed."""
    return _whole(children) if all(SUCCESS in each for each in children) else _whole(children) - _S


def _fallback(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if one child has to succeed."""
    return _whole(children) if all(FAILURE in each for each in children) else _whole(children) - _F


def _anything(_children: Sequence[Outcomes]) -> Outcomes:
    return _ANY


def _first_and_running(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if the first child decides, and the others may take time."""
    return children[0] | (_whole(children) & _R)


def _also(more: Outcomes) -> Callable[[Sequence[Outcomes]], Outcomes]:
    return lambda children: _whole(children) | more


def _becomes(**statuses: str) -> Callable[[Sequence[Outcomes]], Outcomes]:
    """Return what is possible if statuses of the child become others."""
    return lambda children: frozenset(statuses.get(each, each) for each in _whole(children))


@dataclass(frozen=True)
class _Kind:
    """What is known of a composite or a decorator.

    Attributes:
        returns: What it can return, by what its children can.
        halts: Which children it may halt while they run.
        recovers: Of which children it makes up for a failure.
        swallows: For which children a failure does not let it fail.
    """

    returns: Callable[[Sequence[Outcomes]], Outcomes] = _anything
    halts: _Which = _none
    recovers: _Which = _none
    swallows: _Which = _none


_UNKNOWN: Final = _Kind(halts=_all)

_LEAVES: Final[Mapping[str, Outcomes]] = MappingProxyType(
    {
        f"{module}.{name}": outcomes
        for module, outcomes, names in (
            ("py_trees.behaviours", _S, "Success UnsetBlackboardVariable"),
            ("py_trees.behaviours", _F, "Failure"),
            ("py_trees.behaviours", _R, "Running"),
            ("py_trees.behaviours", _S | _F, "CheckBlackboardVariableExists CheckBlackboardVariableValue"),
            ("py_trees.behaviours", _S | _F, "CheckBlackboardVariableValues CompareBlackboardVariables"),
            ("py_trees.behaviours", _S | _F, "SetBlackboardVariable"),
            ("py_trees.behaviours", _S | _R, "WaitForBlackboardVariable WaitForBlackboardVariableValue"),
            ("py_trees.timers", _S | _R, "Timer"),
            ("bt_controller.behaviours.detections", _S | _F, "IsDetected"),
            ("bt_controller.behaviours.places", _S, "ToBlackboard"),
            ("bt_controller.behaviours.subscribers", _S | _R, "WaitForData ToBlackboard"),
            ("bt_controller.core.node", _S | _F, "Condition"),
            ("bt_controller.fleet.fleet_manager", _S | _R, "FleetManager"),
            ("bt_controller.fleet.workers", _S | _R, "Charged"),
            ("bt_controller.nodes.actions.cancels", _S | _F, "_Cancel"),
            ("bt_controller.nodes.actions.entries", _S, "UnsetBlackboard Script"),
            ("bt_controller.nodes.actions.entries", _S | _F, "SetBlackboard"),
            ("bt_controller.nodes.actions.no_ops", _S, "_NoOp"),
            ("bt_controller.nodes.actions.no_ops", _S | _F, "_Selector"),
            ("bt_controller.nodes.actions.outcomes", _S, "AlwaysSuccess"),
            ("bt_controller.nodes.actions.outcomes", _F, "AlwaysFailure"),
            ("bt_controller.nodes.actions.path_parts", _S, "TruncatePath TruncatePathLocal"),
            ("bt_controller.nodes.actions.path_parts", _S | _F, "ConcatenatePaths GetPoseFromPath"),
            ("bt_controller.nodes.actions.poses", _S, "GetCurrentPose RemovePassedGoals AppendGoalPoseToGoals"),
            ("bt_controller.nodes.actions.poses", _S | _F, "GetNextFewGoals"),
            ("bt_controller.nodes.actions.routes", _S | _F, "ExtractRouteNodesAsGoals"),
            ("bt_controller.nodes.actions.sleep", _S | _R, "Sleep"),
            ("bt_controller.nodes.conditions.localisation", _S | _F, "InitialPoseReceived TransformAvailable"),
            ("bt_controller.nodes.conditions.motion", _ANY, "IsStopped"),
        )
        for name in names.split()
    }
)
"""What leaves can return, by class."""

_PARENTS: Final[Mapping[str, _Kind]] = MappingProxyType(
    {
        f"{module}.{name}": kind
        for module, kind, names in (
            ("py_trees.composites", _Kind(_sequence), "Sequence"),
            ("py_trees.composites", _Kind(_fallback, recovers=_but_last), "Selector"),
            ("py_trees.composites", _Kind(_whole, halts=_siblings), "Parallel"),
            ("py_trees.decorators", _Kind(_whole), "PassThrough Count OneShot Repeat"),
            ("py_trees.decorators", _Kind(_also(_R), recovers=_all), "Retry"),
            ("py_trees.decorators", _Kind(_also(_F), halts=_all), "Timeout EternalGuard"),
            ("py_trees.decorators", _Kind(_becomes(SUCCESS=FAILURE, FAILURE=SUCCESS), swallows=_all), "Inverter"),
            ("py_trees.decorators", _Kind(_becomes(FAILURE=SUCCESS), swallows=_all), "FailureIsSuccess"),
            ("py_trees.decorators", _Kind(_becomes(FAILURE=RUNNING), swallows=_all), "FailureIsRunning"),
            ("py_trees.decorators", _Kind(_becomes(SUCCESS=FAILURE)), "SuccessIsFailure"),
            ("py_trees.decorators", _Kind(_becomes(SUCCESS=RUNNING)), "SuccessIsRunning"),
            ("py_trees.decorators", _Kind(_becomes(RUNNING=FAILURE), halts=_all), "RunningIsFailure"),
            ("py_trees.decorators", _Kind(_becomes(RUNNING=SUCCESS), halts=_all), "RunningIsSuccess"),
            ("bt_controller.xml.translation", _Kind(_whole), "SubTree"),
            ("bt_controller.behaviours.charging", _Kind(halts=_all), "BatteryGuard"),
            ("bt_controller.nodes.controls.sequence", _Kind(_sequence), "Sequence SequenceWithMemory"),
            ("bt_controller.nodes.controls.sequence", _Kind(_sequence, halts=_later), "ReactiveSequence"),
            ("bt_controller.nodes.controls.nav2_sequences", _Kind(_sequence), "PersistentSequence"),
            (
                "bt_controller.nodes.controls.nav2_sequences",
                _Kind(_sequence, halts=_siblings),
                "NonblockingSequence PipelineSequence",
            ),
            ("bt_controller.nodes.controls.fallback", _Kind(_fallback, recovers=_but_last), "Fallback"),
            (
                "bt_controller.nodes.controls.fallback",
                _Kind(_fallback, halts=_later, recovers=_but_last),
                "ReactiveFallback",
            ),
            ("bt_controller.nodes.controls.recovery_node", _Kind(_first_and_running, recovers=_first), "RecoveryNode"),
            ("bt_controller.nodes.controls.round_robin", _Kind(_whole, recovers=_all), "RoundRobin"),
            ("bt_controller.nodes.controls.branches", _Kind(_also(_F), swallows=_first_of_three), "IfThenElse"),
            (
                "bt_controller.nodes.controls.branches",
                _Kind(_also(_F), halts=_later, swallows=_first_of_three),
                "WhileDoElse",
            ),
            ("bt_controller.nodes.controls.switch", _Kind(_whole, halts=_all), "Switch"),
            ("bt_controller.nodes.controls.try_catch", _Kind(_whole, swallows=_last), "TryCatch"),
            ("bt_controller.nodes.controls.parallel", _Kind(_whole, halts=_siblings), "Parallel"),
            ("bt_controller.nodes.controls.parallel", _Kind(_also(_S)), "ParallelAll"),
            ("bt_controller.nodes.decorators.controllers", _Kind(_also(_R)), "_Controller"),
            ("bt_controller.nodes.decorators.goal_updater", _Kind(_whole), "GoalUpdater"),
            ("bt_controller.nodes.decorators.once", _Kind(_also(_F)), "SingleTrigger"),
            ("bt_controller.nodes.decorators.once", _Kind(_whole), "RunOnce"),
            ("bt_controller.nodes.decorators.path_longer_on_approach", _Kind(_also(_S)), "PathLongerOnApproach"),
            ("bt_controller.nodes.decorators.precondition", _Kind(), "Precondition"),
            ("bt_controller.nodes.decorators.repetition", _Kind(_whole), "Repeat"),
            ("bt_controller.nodes.decorators.repetition", _Kind(_whole, recovers=_all), "RetryUntilSuccessful"),
            ("bt_controller.nodes.decorators.repetition", _Kind(_becomes(SUCCESS=RUNNING)), "KeepRunningUntilFailure"),
            (
                "bt_controller.nodes.decorators.results",
                _Kind(_becomes(SUCCESS=FAILURE, FAILURE=SUCCESS), swallows=_all),
                "Inverter",
            ),
            ("bt_controller.nodes.decorators.results", _Kind(_becomes(FAILURE=SUCCESS), swallows=_all), "ForceSuccess"),
            ("bt_controller.nodes.decorators.results", _Kind(_becomes(SUCCESS=FAILURE)), "ForceFailure"),
            ("bt_controller.nodes.decorators.timing", _Kind(_also(_R)), "Delay"),
            ("bt_controller.nodes.decorators.timing", _Kind(_also(_F), halts=_all), "Timeout"),
        )
        for name in names.split()
    }
)
"""What is known of composites and decorators, by class."""


def possible_outcomes(root: Behaviour) -> Iterator[tuple[Behaviour, Outcomes]]:
    """Yield the nodes of a tree, parents first, with what can happen to each of them."""
    returned: dict[Behaviour, Outcomes] = {}
    _returns(root, returned)
    yield from _marked(root, returned, halted=False, recovered=False)


def recovers(node: Behaviour) -> bool:
    """Return whether a node makes up for a failure of one of its children."""
    count = len(node.children)
    return any(_kind(node).recovers(index, count) for index in range(count))


def _marked(
    node: Behaviour, returned: Mapping[Behaviour, Outcomes], *, halted: bool, recovered: bool
) -> Iterator[tuple[Behaviour, Outcomes]]:
    found = returned[node]
    canceled = {CANCELED} if halted and RUNNING in found else set[str]()
    yield node, found | canceled | ({RECOVERED} if recovered and FAILURE in found else set[str]())
    kind, count = _kind(node), len(node.children)
    for index, child in enumerate(node.children):
        yield from _marked(
            child,
            returned,
            halted=halted or kind.halts(index, count),
            recovered=kind.recovers(index, count) or (recovered and not kind.swallows(index, count)),
        )


def _returns(node: Behaviour, returned: dict[Behaviour, Outcomes]) -> Outcomes:
    children = [_returns(child, returned) for child in node.children]
    found = _kind(node).returns(children) if children else _of_leaf(type(node))
    returned[node] = found
    return found


def _of_leaf(kind: type[Behaviour]) -> Outcomes:
    for each in kind.__mro__:
        if (found := _LEAVES.get(f"{each.__module__}.{each.__name__}")) is not None:
            return found
    return _ANY


def _kind(node: Behaviour) -> _Kind:
    if isinstance(node, ScriptConditions):
        more = (_S if "_successIf" in node.scripts else _NOTHING) | (_F if "_failureIf" in node.scripts else _NOTHING)
        return _Kind(_also(more), halts=_all if "_while" in node.scripts else _none)
    for each in type(node).__mro__:
        if (found := _PARENTS.get(f"{each.__module__}.{each.__name__}")) is not None:
            if isinstance(node, (SequenceOfPyTrees, Selector)) and not node.memory:
                return _Kind(found.returns, _later, found.recovers)
            return found
    return _UNKNOWN

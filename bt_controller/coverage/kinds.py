"""The possible outcomes of a node at its place in a tree, as far as they are known without running it.

The outcomes of leaves of py_trees and of this package are known; other leaves may return any status. The outcomes of a
composite follow from those of its children. A node can be canceled if one above it halts running children. A failure
can be recovered if a node above it tries something else, or the same again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import repeat
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, TypeAlias

from py_trees.composites import Selector
from py_trees.composites import Sequence as SequenceOfPyTrees

from bt_controller.coverage.node_coverage import CANCELED, FAILURE, RECOVERED, RUNNING, SKIPPED, SUCCESS
from bt_controller.scripting.scripted import ScriptConditions

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
_SKIPPED: Final = frozenset({SKIPPED})
_NOTHING: Final[Outcomes] = frozenset()
_ANY: Final = _S | _F | _R


def _whole(children: Sequence[Outcomes]) -> Outcomes:
    return _NOTHING.union(*children)


def _sequence(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if all children have to succeed that are not skipped."""
    return _whole(children) if all(each & (_S | _SKIPPED) for each in children) else _whole(children) - _S


def _fallback(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if one child has to succeed, and all fail that are not skipped."""
    return _whole(children) if all(each & (_F | _SKIPPED) for each in children) else _whole(children) - _F


def _parallel(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if some children have to succeed, or to be skipped."""
    found = _whole(children)
    return found | _S if found & _SKIPPED else found


def _anything(_children: Sequence[Outcomes]) -> Outcomes:
    return _ANY | _SKIPPED


def _first_and_running(children: Sequence[Outcomes]) -> Outcomes:
    """Return what is possible if the first child decides, and the others may take time."""
    return children[0] | (_whole(children) & _R)


def _also(more: Outcomes) -> Callable[[Sequence[Outcomes]], Outcomes]:
    return lambda children: _whole(children) | more


def _becomes(**statuses: str) -> Callable[[Sequence[Outcomes]], Outcomes]:
    """Return what is possible if statuses of the child become others."""
    return lambda children: frozenset(statuses.get(each, each) for each in _whole(children))


@dataclass(frozen=True)
class Kind:
    """The effects of a composite or a decorator on its children.

    Attributes:
        returns: Its possible outcomes, given those of its children.
        halts: Which children it may halt while they run.
        recovers: Of which children it makes up for a failure.
        swallows: For which children a failure does not let it fail.
    """

    returns: Callable[[Sequence[Outcomes]], Outcomes] = _anything
    halts: _Which = _none
    recovers: _Which = _none
    swallows: _Which = _none


_UNKNOWN: Final = Kind(halts=_all)

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
            ("bt_controller.nodes.actions.navigation", _S | _F, "_Cancel"),
            ("bt_controller.nodes.actions.btcpp", _S, "UnsetBlackboard Script"),
            ("bt_controller.nodes.actions.btcpp", _S | _F, "SetBlackboard"),
            ("bt_controller.nodes.actions.no_ops", _S, "_NoOp"),
            ("bt_controller.nodes.actions.no_ops", _S | _F, "_Selector"),
            ("bt_controller.nodes.actions.btcpp", _S, "AlwaysSuccess"),
            ("bt_controller.nodes.actions.btcpp", _F, "AlwaysFailure"),
            ("bt_controller.nodes.actions.paths", _S, "TruncatePath TruncatePathLocal"),
            ("bt_controller.nodes.actions.paths", _S | _F, "ConcatenatePaths GetPoseFromPath"),
            ("bt_controller.nodes.actions.poses", _S, "GetCurrentPose RemovePassedGoals AppendGoalPoseToGoals"),
            ("bt_controller.nodes.actions.poses", _S | _F, "GetNextFewGoals"),
            ("bt_controller.nodes.actions.routes", _S | _F, "ExtractRouteNodesAsGoals"),
            ("bt_controller.nodes.actions.btcpp", _S | _R, "Sleep"),
            ("bt_controller.nodes.conditions.motion", _S | _F, "InitialPoseReceived TransformAvailable"),
            ("bt_controller.nodes.conditions.motion", _ANY, "IsStopped"),
        )
        for name in names.split()
    }
)
"""What leaves can return, by class."""

_PARENTS: Final[Mapping[str, Kind]] = MappingProxyType(
    {
        f"{module}.{name}": kind
        for module, kind, names in (
            ("py_trees.composites", Kind(_sequence), "Sequence"),
            ("py_trees.composites", Kind(_fallback, recovers=_but_last), "Selector"),
            ("py_trees.composites", Kind(_whole, halts=_siblings), "Parallel"),
            ("py_trees.decorators", Kind(_whole), "PassThrough Count OneShot"),
            ("py_trees.decorators", Kind(_also(_R)), "Repeat"),
            ("py_trees.decorators", Kind(_also(_R), recovers=_all), "Retry"),
            ("py_trees.decorators", Kind(_also(_F), halts=_all), "Timeout EternalGuard"),
            ("py_trees.decorators", Kind(_becomes(SUCCESS=FAILURE, FAILURE=SUCCESS), swallows=_all), "Inverter"),
            ("py_trees.decorators", Kind(_becomes(FAILURE=SUCCESS), swallows=_all), "FailureIsSuccess"),
            ("py_trees.decorators", Kind(_becomes(FAILURE=RUNNING), swallows=_all), "FailureIsRunning"),
            ("py_trees.decorators", Kind(_becomes(SUCCESS=FAILURE)), "SuccessIsFailure"),
            ("py_trees.decorators", Kind(_becomes(SUCCESS=RUNNING)), "SuccessIsRunning"),
            ("py_trees.decorators", Kind(_becomes(RUNNING=FAILURE), halts=_all), "RunningIsFailure"),
            ("py_trees.decorators", Kind(_becomes(RUNNING=SUCCESS), halts=_all), "RunningIsSuccess"),
            ("bt_controller.loading.builder", Kind(_whole), "SubTree"),
            ("bt_controller.behaviours.charging", Kind(halts=_all), "BatteryGuard"),
            ("bt_controller.nodes.controls.sequences", Kind(_sequence), "Sequence SequenceWithMemory"),
            ("bt_controller.nodes.controls.sequences", Kind(_sequence, halts=_later), "ReactiveSequence"),
            ("bt_controller.nodes.controls.nav2", Kind(_sequence), "PersistentSequence"),
            (
                "bt_controller.nodes.controls.nav2",
                Kind(_sequence, halts=_siblings),
                "NonblockingSequence PipelineSequence",
            ),
            ("bt_controller.nodes.controls.sequences", Kind(_fallback, recovers=_but_last), "Fallback"),
            (
                "bt_controller.nodes.controls.sequences",
                Kind(_fallback, halts=_later, recovers=_but_last),
                "ReactiveFallback",
            ),
            ("bt_controller.nodes.controls.nav2", Kind(_first_and_running, recovers=_first), "RecoveryNode"),
            ("bt_controller.nodes.controls.nav2", Kind(_whole, recovers=_all), "RoundRobin"),
            ("bt_controller.nodes.controls.branches", Kind(_also(_F), swallows=_first_of_three), "IfThenElse"),
            (
                "bt_controller.nodes.controls.branches",
                Kind(_also(_F), halts=_later, swallows=_first_of_three),
                "WhileDoElse",
            ),
            ("bt_controller.nodes.controls.branches", Kind(_whole, halts=_all), "Switch"),
            ("bt_controller.nodes.controls.branches", Kind(_whole, swallows=_last), "TryCatch"),
            ("bt_controller.nodes.controls.parallel", Kind(_parallel, halts=_siblings), "Parallel"),
            ("bt_controller.nodes.controls.parallel", Kind(_also(_S)), "ParallelAll"),
            ("bt_controller.nodes.decorators.nav2", Kind(_also(_R)), "_Controller"),
            ("bt_controller.nodes.decorators.nav2", Kind(_whole), "GoalUpdater"),
            ("bt_controller.nodes.decorators.gates", Kind(_also(_F)), "SingleTrigger"),
            ("bt_controller.nodes.decorators.gates", Kind(_also(_SKIPPED)), "RunOnce"),
            ("bt_controller.nodes.decorators.nav2", Kind(_also(_S)), "PathLongerOnApproach"),
            ("bt_controller.nodes.decorators.gates", Kind(), "Precondition"),
            ("bt_controller.nodes.decorators.repetition", Kind(_whole), "Repeat"),
            ("bt_controller.nodes.decorators.repetition", Kind(_whole, recovers=_all), "RetryUntilSuccessful"),
            ("bt_controller.nodes.decorators.repetition", Kind(_becomes(SUCCESS=RUNNING)), "KeepRunningUntilFailure"),
            (
                "bt_controller.nodes.decorators.gates",
                Kind(_becomes(SUCCESS=FAILURE, FAILURE=SUCCESS), swallows=_all),
                "Inverter",
            ),
            ("bt_controller.nodes.decorators.gates", Kind(_becomes(FAILURE=SUCCESS), swallows=_all), "ForceSuccess"),
            ("bt_controller.nodes.decorators.gates", Kind(_becomes(SUCCESS=FAILURE)), "ForceFailure"),
            ("bt_controller.nodes.decorators.gates", Kind(_also(_R)), "Delay"),
            ("bt_controller.nodes.decorators.gates", Kind(_also(_F), halts=_all), "Timeout"),
        )
        for name in names.split()
    }
)
"""What is known of composites and decorators, by class."""


_CLASSES: Final = 1024
"""How many classes are remembered: trees in XML make some of their own."""


@lru_cache(_CLASSES)
def outcomes_of_leaf(kind: type[Behaviour]) -> Outcomes:
    """Return what a leaf of a class can return."""
    for each in kind.__mro__:
        if (found := _LEAVES.get(f"{each.__module__}.{each.__name__}")) is not None:
            return found
    return _ANY


def kind_of(node: Behaviour) -> Kind:
    """Return what is known of a node with children."""
    found, forgets = _known(type(node))
    if found is _UNKNOWN and isinstance(node, ScriptConditions):
        ends = {"_successIf": _S, "_failureIf": _F, "_skipIf": _SKIPPED, "_while": _SKIPPED}
        more = [outcome for attribute, outcome in ends.items() if attribute in node.scripts]
        return Kind(_also(_whole(more)), halts=_all if "_while" in node.scripts else _none)
    return Kind(found.returns, _later, found.recovers) if forgets and not getattr(node, "memory", True) else found


@lru_cache(_CLASSES)
def _known(kind: type[Behaviour]) -> tuple[Kind, bool]:
    """Return what is known of a class, and whether its nodes may have no memory."""
    for each in kind.__mro__:
        if (found := _PARENTS.get(f"{each.__module__}.{each.__name__}")) is not None:
            return found, issubclass(kind, (SequenceOfPyTrees, Selector))
    return _UNKNOWN, False


_CANCELED: Final = frozenset({CANCELED})
_RECOVERED: Final = frozenset({RECOVERED})


def possible_outcomes(root: Behaviour) -> dict[Behaviour, Outcomes]:
    """Return what can happen to each node of a tree; parents come first."""
    returned: dict[Behaviour, Outcomes] = {}
    _returns(root, returned)
    found: dict[Behaviour, Outcomes] = {}
    _mark(root, returned, found, halted=False, recovered=False)
    return found


def recovers(node: Behaviour) -> bool:
    """Return whether a node makes up for a failure of one of its children."""
    count = len(node.children)
    return count > 0 and any(map(kind_of(node).recovers, range(count), repeat(count)))


def _mark(
    node: Behaviour,
    returned: Mapping[Behaviour, Outcomes],
    found: dict[Behaviour, Outcomes],
    *,
    halted: bool,
    recovered: bool,
) -> None:
    """Find what can happen to a node and those below it, by what can happen above it."""
    outcomes = returned[node]
    if halted and RUNNING in outcomes:
        outcomes |= _CANCELED
    if recovered and FAILURE in outcomes:
        outcomes |= _RECOVERED
    found[node] = outcomes
    if not (count := len(node.children)):
        return
    kind = kind_of(node)
    for index, child in enumerate(node.children):
        may_halt = halted or kind.halts(index, count)
        may_recover = kind.recovers(index, count) or (recovered and not kind.swallows(index, count))
        _mark(child, returned, found, halted=may_halt, recovered=may_recover)


def _returns(node: Behaviour, returned: dict[Behaviour, Outcomes]) -> Outcomes:
    if node.children:
        found = kind_of(node).returns([_returns(child, returned) for child in node.children])
    else:
        found = outcomes_of_leaf(type(node))
    returned[node] = found
    return found

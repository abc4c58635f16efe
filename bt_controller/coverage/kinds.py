"""The possible outcomes of a node at its place in a tree, as far as they are known without running it.

The outcomes of the leaves of py_trees and of this package are known; other leaves may return any status. The outcomes
of a composite follow from those of its children. A node can be canceled if a node above it halts running children. A
failure can be recovered if a node above it tries something else, or retries.
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

from bt_controller.core.node import MAX_CLASSES
from bt_controller.coverage.node_coverage import CANCELED, FAILURE, RECOVERED, RUNNING, SKIPPED, SUCCESS
from bt_controller.scripting.scripted import ScriptConditions

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

Outcomes: TypeAlias = frozenset[str]
_Children: TypeAlias = Callable[[int, int], bool]
"""A predicate on the children of a node, by index and number of children."""


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


def _any_with_siblings(_index: int, count: int) -> bool:
    return count > 1


def _first_of_three(index: int, count: int) -> bool:
    return index == 0 and count > 2  # noqa: PLR2004 - the third child is the else branch


_S: Final = frozenset({SUCCESS})
_F: Final = frozenset({FAILURE})
_R: Final = frozenset({RUNNING})
_SKIPPED: Final = frozenset({SKIPPED})
_NOTHING: Final[Outcomes] = frozenset()
_ANY: Final = _S | _F | _R


def _union(children: Sequence[Outcomes]) -> Outcomes:
    return _NOTHING.union(*children)


def _sequence(children: Sequence[Outcomes]) -> Outcomes:
    """Return the outcomes of a node that succeeds if all children succeed or are skipped."""
    may_succeed = all(outcomes & (_S | _SKIPPED) for outcomes in children)
    return _union(children) if may_succeed else _union(children) - _S


def _fallback(children: Sequence[Outcomes]) -> Outcomes:
    """Return the outcomes of a node that fails if all children fail or are skipped."""
    may_fail = all(outcomes & (_F | _SKIPPED) for outcomes in children)
    return _union(children) if may_fail else _union(children) - _F


def _parallel(children: Sequence[Outcomes]) -> Outcomes:
    """Return the outcomes of a node that counts skipped children as successful."""
    union = _union(children)
    return union | _S if union & _SKIPPED else union


def _anything(_children: Sequence[Outcomes]) -> Outcomes:
    return _ANY | _SKIPPED


def _first_and_running(children: Sequence[Outcomes]) -> Outcomes:
    """Return the outcomes of a node that ends as its first child does, and runs while any child runs."""
    return children[0] | (_union(children) & _R)


def _also(more: Outcomes) -> Callable[[Sequence[Outcomes]], Outcomes]:
    """Return a function that adds outcomes to those of the children."""
    return lambda children: _union(children) | more


def _becomes(**statuses: str) -> Callable[[Sequence[Outcomes]], Outcomes]:
    """Return a function that maps the outcomes of the child to others."""
    return lambda children: frozenset(statuses.get(outcome, outcome) for outcome in _union(children))


@dataclass(frozen=True)
class Kind:
    """A kind of composite or decorator: its outcomes, and its effects on its children.

    Attributes:
        returns: Returns its possible outcomes, given those of its children.
        halts: The children that it may halt while they run.
        recovers: The children from whose failure it recovers, by a retry or an alternative.
        swallows: The children whose failure does not make it fail.
    """

    returns: Callable[[Sequence[Outcomes]], Outcomes] = _anything
    halts: _Children = _none
    recovers: _Children = _none
    swallows: _Children = _none


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
            (".behaviours.detections", _S | _F, "IsDetected"),
            (".behaviours.places", _S, "ToBlackboard"),
            (".behaviours.subscribers", _S | _R, "WaitForData ToBlackboard"),
            (".core.node", _S | _F, "Condition"),
            (".fleet.fleet_manager", _S | _R, "FleetManager"),
            (".fleet.workers", _S | _R, "Charged"),
            (".nodes.actions.navigation", _S | _F, "_Cancel _Selector"),
            (".nodes.actions.btcpp", _S, "UnsetBlackboard Script AlwaysSuccess"),
            (".nodes.actions.btcpp", _S | _F, "SetBlackboard"),
            (".nodes.actions.navigation", _S, "_NoOp"),
            (".nodes.actions.btcpp", _F, "AlwaysFailure"),
            (".nodes.actions.paths", _S, "TruncatePath TruncatePathLocal"),
            (".nodes.actions.paths", _S | _F, "ConcatenatePaths GetPoseFromPath GetNextFewGoals"),
            (".nodes.actions.paths", _S, "GetCurrentPose RemovePassedGoals AppendGoalPoseToGoals"),
            (".nodes.actions.routes", _S | _F, "ExtractRouteNodesAsGoals"),
            (".nodes.actions.btcpp", _S | _R, "Sleep"),
            (".nodes.conditions.robot", _S | _F, "InitialPoseReceived TransformAvailable"),
            (".nodes.conditions.robot", _ANY, "IsStopped"),
        )
        for name in names.split()
    }
)
"""The possible outcomes of leaves, by class; the modules of this package have relative names."""

_PARENTS: Final[Mapping[str, Kind]] = MappingProxyType(
    {
        f"{module}.{name}": kind
        for module, kind, names in (
            ("py_trees.composites", Kind(_sequence), "Sequence"),
            ("py_trees.composites", Kind(_fallback, recovers=_but_last), "Selector"),
            ("py_trees.composites", Kind(_union, halts=_any_with_siblings), "Parallel"),
            ("py_trees.decorators", Kind(_union), "PassThrough Count OneShot"),
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
            (".loading.builder", Kind(_union), "SubTree"),
            (".behaviours.battery_guard", Kind(halts=_all), "BatteryGuardNode"),
            (".nodes.controls.sequences", Kind(_sequence), "Sequence SequenceWithMemory"),
            (".nodes.controls.sequences", Kind(_sequence, halts=_later), "ReactiveSequence"),
            (".nodes.controls.nav2", Kind(_sequence), "PersistentSequence"),
            (".nodes.controls.nav2", Kind(_sequence, halts=_any_with_siblings), "NonblockingSequence PipelineSequence"),
            (".nodes.controls.sequences", Kind(_fallback, recovers=_but_last), "Fallback"),
            (".nodes.controls.sequences", Kind(_fallback, halts=_later, recovers=_but_last), "ReactiveFallback"),
            (".nodes.controls.nav2", Kind(_first_and_running, recovers=_first), "RecoveryNode"),
            (".nodes.controls.nav2", Kind(_union, recovers=_all), "RoundRobin"),
            (".nodes.controls.branches", Kind(_also(_F), swallows=_first_of_three), "IfThenElse"),
            (".nodes.controls.branches", Kind(_also(_F), halts=_later, swallows=_first_of_three), "WhileDoElse"),
            (".nodes.controls.branches", Kind(_union, halts=_all), "_Switch"),
            (".nodes.controls.branches", Kind(_union, swallows=_last), "TryCatch"),
            (".nodes.controls.sequences", Kind(_parallel, halts=_any_with_siblings), "Parallel"),
            (".nodes.controls.sequences", Kind(_also(_S)), "ParallelAll"),
            (".nodes.decorators.nav2", Kind(_also(_R)), "_Controller"),
            (".nodes.decorators.nav2", Kind(_union), "GoalUpdater"),
            (".nodes.decorators.gates", Kind(_also(_F)), "SingleTrigger"),
            (".nodes.decorators.gates", Kind(_also(_SKIPPED)), "RunOnce"),
            (".nodes.decorators.nav2", Kind(_also(_S)), "PathLongerOnApproach"),
            (".nodes.decorators.gates", Kind(), "Precondition"),
            (".nodes.decorators.repetition", Kind(_union), "Repeat"),
            (".nodes.decorators.repetition", Kind(_union, recovers=_all), "RetryUntilSuccessful"),
            (".nodes.decorators.repetition", Kind(_becomes(SUCCESS=RUNNING)), "KeepRunningUntilFailure"),
            (".nodes.decorators.gates", Kind(_becomes(SUCCESS=FAILURE, FAILURE=SUCCESS), swallows=_all), "Inverter"),
            (".nodes.decorators.gates", Kind(_becomes(FAILURE=SUCCESS), swallows=_all), "ForceSuccess"),
            (".nodes.decorators.gates", Kind(_becomes(SUCCESS=FAILURE)), "ForceFailure"),
            (".nodes.decorators.gates", Kind(_also(_R)), "Delay"),
            (".nodes.decorators.gates", Kind(_also(_F), halts=_all), "Timeout"),
        )
        for name in names.split()
    }
)
"""The kinds of composites and decorators, by class, as above."""


def _name_of(kind: type) -> str:
    return f"{kind.__module__.removeprefix('bt_controller')}.{kind.__name__}"


@lru_cache(MAX_CLASSES)
def outcomes_of_leaf(kind: type[Behaviour]) -> Outcomes:
    """Return the possible outcomes of a leaf of a class."""
    for base in kind.__mro__:
        if (outcomes := _LEAVES.get(_name_of(base))) is not None:
            return outcomes
    return _ANY


def kind_of(node: Behaviour) -> Kind:
    """Return the kind of a node with children."""
    kind, may_lack_memory = _kind_of_class(type(node))
    if kind is _UNKNOWN and isinstance(node, ScriptConditions):
        ends = {"_successIf": _S, "_failureIf": _F, "_skipIf": _SKIPPED, "_while": _SKIPPED}
        more = [outcome for attribute, outcome in ends.items() if attribute in node.scripts]
        return Kind(_also(_union(more)), halts=_all if "_while" in node.scripts else _none)
    if may_lack_memory and not getattr(node, "memory", True):
        return Kind(kind.returns, _later, kind.recovers)
    return kind


def variant_of(node: Behaviour) -> object:
    """Return what the kind of a node depends on besides its class, as a key."""
    if not node.children:
        return None
    kind, may_lack_memory = _kind_of_class(type(node))
    if kind is _UNKNOWN and isinstance(node, ScriptConditions):
        return tuple(node.scripts)
    return not may_lack_memory or bool(getattr(node, "memory", True))


@lru_cache(MAX_CLASSES)
def _kind_of_class(cls: type[Behaviour]) -> tuple[Kind, bool]:
    """Return the kind of a class, and whether its nodes may lack a memory, as in py_trees."""
    for base in cls.__mro__:
        if (kind := _PARENTS.get(_name_of(base))) is not None:
            return kind, issubclass(cls, (SequenceOfPyTrees, Selector))
    return _UNKNOWN, False


_CANCELED: Final = frozenset({CANCELED})
_RECOVERED: Final = frozenset({RECOVERED})


def possible_outcomes(root: Behaviour) -> dict[Behaviour, Outcomes]:
    """Return the possible outcomes of each node of a tree; parents come first."""
    returned: dict[Behaviour, Outcomes] = {}
    _collect_returned(root, returned)
    possible: dict[Behaviour, Outcomes] = {}
    _collect_possible(root, returned, possible, halted=False, recovered=False)
    return possible


def recovers(node: Behaviour) -> bool:
    """Return whether a node recovers from the failure of one of its children."""
    count = len(node.children)
    return count > 0 and any(map(kind_of(node).recovers, range(count), repeat(count)))


def _collect_possible(
    node: Behaviour,
    returned: Mapping[Behaviour, Outcomes],
    possible: dict[Behaviour, Outcomes],
    *,
    halted: bool,
    recovered: bool,
) -> None:
    """Add the possible outcomes of a node, which a node above may halt or recover, and of those below it."""
    outcomes = returned[node]
    if halted and RUNNING in outcomes:
        outcomes |= _CANCELED
    if recovered and FAILURE in outcomes:
        outcomes |= _RECOVERED
    possible[node] = outcomes
    if not (count := len(node.children)):
        return
    kind = kind_of(node)
    for index, child in enumerate(node.children):
        may_halt = halted or kind.halts(index, count)
        may_recover = kind.recovers(index, count) or (recovered and not kind.swallows(index, count))
        _collect_possible(child, returned, possible, halted=may_halt, recovered=may_recover)


def _collect_returned(node: Behaviour, returned: dict[Behaviour, Outcomes]) -> Outcomes:
    """Add the statuses that a node and those below it can return."""
    if node.children:
        outcomes = kind_of(node).returns([_collect_returned(child, returned) for child in node.children])
    else:
        outcomes = outcomes_of_leaf(type(node))
    returned[node] = outcomes
    return outcomes

"""The coverage of a node: its possible outcomes, the ends of its goals, and how often each has occurred."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import GoalRejected
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.errors import SimulatorGone

if TYPE_CHECKING:
    from hmrsim_zenoh.client.goal_handle import GoalHandle


@dataclass
class NodeCoverage:
    """The counts of a node, in all trees that have it at this path.

    Attributes:
        place: The index of each ancestor, and of the node itself, among its siblings, from the root.
        path: The names from the root; siblings of one name are numbered, and the robot's own name is ``{robot}``.
        kind: Its class.
        origin: File and line, if it comes from a file.
        possible: Its possible outcomes, as far as they are known without running it.
        counts: The count of each outcome: of statuses per tick, of other outcomes per occurrence.
    """

    place: tuple[int, ...]
    path: str
    kind: str
    origin: str = ""
    possible: frozenset[str] = frozenset()
    counts: defaultdict[str, int] = field(default_factory=partial(defaultdict, int))

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition("/")[2] if self.place else self.path

    @property
    def ticks(self) -> int:
        """The number of its ticks."""
        return sum(self.counts.get(status, 0) for status in (SUCCESS, FAILURE, RUNNING, SKIPPED))

    @property
    def points(self) -> tuple[str, ...]:
        """The outcomes that count for the share: the possible ones, and unexpected ones that have occurred."""
        return tuple(each for each in ENDINGS if each in self.possible or self.counts.get(each))

    @property
    def missing(self) -> tuple[str, ...]:
        """The outcomes that count and have never occurred."""
        return tuple(each for each in self.points if not self.counts.get(each))

    @property
    def seen(self) -> dict[str, int]:
        """The count of each outcome that has occurred, by name."""
        return {outcome: count for outcome, count in sorted(self.counts.items()) if count}

    @property
    def ends(self) -> dict[str, int]:
        """The counts of `seen` without RUNNING."""
        return {outcome: count for outcome, count in self.seen.items() if outcome != RUNNING}

    @property
    def never(self) -> list[str]:
        """The possible events that have never occurred: ``ticked``, or one of `WORDS`."""
        return [*([] if self.ticks else [TICKED]), *(WORDS[outcome] for outcome in self.missing)]

    def merge(self, other: NodeCoverage) -> None:
        """Add the counts of the same node in another coverage."""
        self.place = min(self.place, other.place)
        self.origin = self.origin or other.origin
        self.possible |= other.possible
        for outcome, count in other.counts.items():
            self.counts[outcome] += count


SUCCESS: Final = "SUCCESS"
FAILURE: Final = "FAILURE"
RUNNING: Final = "RUNNING"
SKIPPED: Final = "SKIPPED"
"""A tick without a result, as of skipped nodes in XML trees."""
CANCELED: Final = "CANCELED"
"""The node was halted or suspended while it was running, or another client canceled its goal."""
RECOVERED: Final = "RECOVERED"
"""The node failed, but a node above it succeeded by an alternative or a retry."""
REJECTED: Final = "REJECTED"
"""The goal was not accepted."""
PREEMPTED: Final = "PREEMPTED"
"""Another goal preempted the goal."""
LOST: Final = "LOST"
"""The end of the goal is unknown."""

ABORTED: Final = "ABORTED/"
"""The goal was aborted; the error code follows."""

ENDINGS: Final = (SUCCESS, FAILURE, CANCELED, RECOVERED)
"""The outcomes that count for the share of a tree that is covered."""

WORDS: Final[Mapping[str, str]] = MappingProxyType(
    {SUCCESS: "succeeded", FAILURE: "failed", CANCELED: "canceled", RECOVERED: "recovered"}
)
"""The outcomes in words."""

TICKED: Final = "ticked"

_PREEMPTED: Final = "preempted"
_ENDED: Final = "ended"


def ended_with_run(handle: GoalHandle[Any, Any] | None) -> bool:
    """Return whether a goal ended because the simulation did, which does not count as an outcome of the tree."""
    return handle is not None and (handle.cause == _ENDED or isinstance(handle.error, SimulatorGone))


def ending_of(handle: GoalHandle[Any, Any]) -> str | None:
    """Return the outcome of a goal that has ended; None if it succeeded."""
    if handle.error is not None:
        return REJECTED if isinstance(handle.error, GoalRejected) else LOST
    match handle.status:
        case GoalStatus.SUCCEEDED:
            return None
        case GoalStatus.CANCELED:
            return CANCELED
    return PREEMPTED if handle.cause == _PREEMPTED else f"{ABORTED}{_code_of(handle.result_message)}"


def _code_of(result: Any) -> int:
    """Return the error code of a result of Nav2, MoveIt or the simulation; 0 if it has none."""
    own = getattr(getattr(result, "result", None), "result", 0)
    code: Any = getattr(result, "error_code", own)
    return int(getattr(code, "val", code))

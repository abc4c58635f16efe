"""The state of a robot's tree on `Keys.tree`; a subscriber needs no py_trees."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Status = Literal["SUCCESS", "FAILURE", "RUNNING", "INVALID"]
"""As in py_trees; INVALID: not active."""


class NodeCounts(BaseModel):
    """The coverage of a behavior over all trees of the controller that contain it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    counts: Annotated[
        dict[str, int], Field(description="How often each outcome was seen, such as FAILURE or ABORTED/104")
    ]
    never: Annotated[
        tuple[Literal["ticked", "succeeded", "failed", "canceled", "recovered"], ...],
        Field(description="The outcomes that are possible but were never seen"),
    ]


class TreeNode(BaseModel):
    """One behavior of a tree, after a tick."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    depth: Annotated[int, Field(ge=0, description="0 for the root")]
    symbol: Annotated[str, Field(description="py_trees' symbol for its kind, such as {-} for a sequence with memory")]
    kind: Annotated[str, Field(description="The behavior's class")]
    name: str
    status: Status
    message: Annotated[str, Field(description="Its feedback message; empty while it is not active")]
    origin: Annotated[str, Field(description="File and line, if it comes from a file")] = ""
    coverage: Annotated[
        NodeCounts | None, Field(description="Its coverage, if the controller counts that (`--coverage`)")
    ] = None


class TreeState(BaseModel):
    """The tree of one robot after a tick."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    robot: str
    sim_time: Annotated[float | None, Field(description="Simulated seconds; null before the first clock message")]
    tick: Annotated[int, Field(ge=0, description="The number of ticks; 0 before the first")]
    status: Annotated[Status, Field(description="The root's status")]
    ended: Annotated[bool, Field(description="Whether the tree will not be ticked again")]
    nodes: Annotated[tuple[TreeNode, ...], Field(min_length=1, description="Parents before their children")]
    blackboard: Annotated[dict[str, Any], Field(description="The entries of its blackboard that have a JSON form")]

"""The state of a robot's tree on `Keys.tree`; a subscriber needs no py_trees."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

Status = Literal["SUCCESS", "FAILURE", "RUNNING", "INVALID"]
"""As in py_trees; INVALID: not active."""


class TreeNode(BaseModel):
    """One behaviour."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    depth: Annotated[int, Field(ge=0, description="0 for the root")]
    symbol: Annotated[str, Field(description="py_trees' symbol for its kind, such as {-} for a sequence with memory")]
    kind: Annotated[str, Field(description="Its class")]
    name: str
    status: Status
    message: Annotated[str, Field(description="What it has to say; empty where it is not active")]
    origin: Annotated[str, Field(description="File and line, where a file has it")] = ""


class TreeState(BaseModel):
    """The tree of one robot after a tick."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    robot: str
    sim_time: Annotated[float | None, Field(description="Simulated seconds; null while no clock was heard")]
    tick: Annotated[int, Field(ge=0, description="Which tick it was; 0 before the first")]
    status: Annotated[Status, Field(description="The root's")]
    ended: Annotated[bool, Field(description="Whether it is not going to be ticked again")]
    nodes: Annotated[tuple[TreeNode, ...], Field(min_length=1, description="Parents before their children")]
    blackboard: Annotated[dict[str, Any], Field(description="What is on its blackboard, as far as JSON has it")]

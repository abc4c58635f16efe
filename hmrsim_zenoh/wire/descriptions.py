"""Descriptions of simulators and trees, which may come from another version or from another program."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal, NoReturn

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from hmrsim.diagnostics import dotted, shown
from hmrsim_zenoh.wire.envelopes import UnreadableError

_MAX_TEXT = 1_000


def _plain(text: str) -> str:
    """Return a text that may be printed on a terminal."""
    if not text.isprintable() or len(text) > _MAX_TEXT:
        raise ValueError(f"{shown(text)} is not a printable text of at most {_MAX_TEXT} characters")
    return text


_Text = Annotated[str, AfterValidator(_plain)]


class _Part(BaseModel):
    """A part of a description: its known fields have the right types, others are passed on."""

    model_config = ConfigDict(extra="allow", strict=True, frozen=True, allow_inf_nan=False, defer_build=True)


class _World(_Part):
    name: _Text = ""
    hash: _Text = ""
    units: _Text = "m"


class _Robot(_Part):
    name: _Text
    type: _Text = ""
    components: list[_Text] = []
    actions: list[_Text] = []
    planner: _Text = ""
    tags: list[_Text] = []


class _Place(_Part):
    name: _Text
    tags: list[_Text] = []


class _Service(_Part):
    name: _Text
    type: _Text = ""


class WorldInfo(_Part):
    """The message that ``_world/info`` returns: the simulator, its world, robots and services."""

    contract: int | _Text | None = None
    hmrsim: _Text = ""
    run_id: _Text = ""
    clock: _Text = ""
    world: _World = _World.model_construct()
    robots: list[_Robot] = []
    places: list[_Place] = []
    actions: list[_Text] = []
    aliases: dict[_Text, _Text] = {}
    services: list[_Service] = []
    planner_present: bool = False


class TimeInfo(_Part):
    """The message that ``_world/time/state`` returns: the clock and the participants of lockstep."""

    now: float = 0.0
    clock: _Text = ""
    real_time_factor: float = 1.0
    paused: bool = False
    epoch: int | None = None
    participants: list[_Text] = []
    waiting_for: list[_Text] = []
    lag: float = 0.0


class _Session(_Part):
    session: _Text
    name: _Text


class SessionsInfo(_Part):
    """The message that ``_world/sessions`` returns: the connected sessions with their certificates' names."""

    sessions: list[_Session] = []


class TreeInfo(_Part):
    """The message of a behavior tree's state, as far as an overview shows it."""

    status: _Text = ""


def plain_values(name: str, payload: bytes) -> Any:
    """Return the values of a JSON payload; *name* is the key that it came from, for errors.

    Raises:
        UnreadableError: It is no JSON, is nested too deep, or has a number that is not finite.
    """
    try:
        return json.loads(payload, parse_constant=_refuse, parse_float=_finite)
    except RecursionError:
        raise UnreadableError(f"{name}: is nested too deep") from None
    except ValueError as error:
        raise UnreadableError(f"{name}: is not valid JSON: {error}") from None


def described(name: str, payload: bytes, kind: type[BaseModel]) -> dict[str, Any]:
    """Return a description in plain values; its known fields have the types of *kind*.

    Raises:
        UnreadableError: A known field has another type.
    """
    found = plain_values(name, payload)
    if not isinstance(found, dict):
        raise UnreadableError(f"{name}: a JSON object is expected, got {shown(found)}")
    try:
        kind.model_validate(found)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise UnreadableError(f"{name}: {dotted(first['loc'])}: {first['msg']}") from None
    return found


def _refuse(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a finite number")


def _finite(text: str) -> float:
    value = float(text)
    if value - value != 0.0:
        _refuse(text[:20])
    return value


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

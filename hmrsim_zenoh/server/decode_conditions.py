"""The conditions of an advance: JSON to values."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final

from pydantic import Field

from hmrsim.protocol.conditions import ORDERS, Comparison, Unwatch, Watch
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.wire.envelopes import MAX_TEXT, Envelope, UnreadableError, unreadable_at
from hmrsim_zenoh.wire.keys import ActionKey, Keys, TopicKey, Verb

MAX_COMPARISONS: Final = 20
"""The comparisons of a condition."""

_OPERATORS: Final = ("==", "!=", *ORDERS)
_TOPICS: Final = {"odom": Topic.ODOM, "battery_state": Topic.BATTERY_STATE, "detections": Topic.DETECTIONS}
_ESCAPED: Final = re.compile(r"~[01]")

_Text = Annotated[str, Field(max_length=MAX_TEXT)]
_Comparison = Annotated[list[_Text | bool | int | float | None], Field(min_length=3, max_length=3)]


class WatchRequest(Envelope):
    """A condition that stops time once: all comparisons hold in one message of a topic."""

    watch: _Text = Field(description="What the participant calls the condition.")
    key: _Text = Field(description="The topic, without the prefix.")
    when: list[_Comparison] = Field(
        default_factory=list, max_length=MAX_COMPARISONS, description="JSON pointer, operator and value of each."
    )


class UnwatchRequest(Envelope):
    """A condition that is to be watched no longer."""

    unwatch: _Text


def condition(request: WatchRequest | UnwatchRequest, keys: Keys) -> Watch | Unwatch:
    """Return the condition of a request.

    Raises:
        UnreadableError: There is no such topic or operator.
    """
    if isinstance(request, UnwatchRequest):
        return Unwatch(request.unwatch)
    comparisons = tuple(_comparison(each, f"when.{number}") for number, each in enumerate(request.when))
    match keys.parse(f"{keys.prefix}/{request.key}"):
        case TopicKey(robot, "events") if robot == WORLD:
            return Watch(request.watch, Topic.EVENTS, comparisons=comparisons)
        case TopicKey(robot, topic) if robot != WORLD and topic in _TOPICS:
            return Watch(request.watch, _TOPICS[topic], robot, comparisons=comparisons)
        case ActionKey(robot, action, Verb.FEEDBACK):
            return Watch(request.watch, Topic.FEEDBACK, robot, action, comparisons)
    known = ", ".join((f"{WORLD}/events", *(f"ROBOT/{name}" for name in _TOPICS), "ROBOT/ACTION/_action/feedback"))
    raise unreadable_at("key", f"no topic {request.key!r} for conditions; there are: {known}", request.key)


def _comparison(parts: list[Any], where: str) -> Comparison:
    pointer, operator, value = parts
    if not isinstance(pointer, str) or (pointer and not pointer.startswith("/")):
        raise unreadable_at(f"{where}.0", "not a JSON pointer, such as '/percentage'", pointer)
    if operator not in _OPERATORS:
        raise unreadable_at(f"{where}.1", f"no operator {operator!r}; there are: {' '.join(_OPERATORS)}", operator)
    if isinstance(value, float) and value - value != 0:
        raise UnreadableError(f"{where}.2: not a finite number")
    path = [_ESCAPED.sub(lambda found: "/" if found[0] == "~1" else "~", part) for part in pointer.split("/")[1:]]
    return Comparison(tuple(path), operator, value)

"""Conditions on topics, at which simulated time stops for a client in lockstep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

Operator = Literal["==", "!=", "<", "<=", ">", ">="]

Value = float | str | bool | None


@dataclass(frozen=True)
class Condition:
    """A condition on a message of a topic, such as ``Condition("eve/battery_state", [("/percentage", "<", 0.3)])``.

    Attributes:
        key: The topic, without the prefix.
        when: JSON pointer, operator and value of each comparison; without one any message will do.
    """

    key: str
    when: Sequence[tuple[str, Operator, Value]] = ()


class Watched(NamedTuple):
    """A command of an advance: watch a condition.

    Attributes:
        name: The sender's name for the condition.
    """

    name: str
    condition: Condition

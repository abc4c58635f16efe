"""Conditions on topics, for which a client in lockstep has time stop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

Operator = Literal["==", "!=", "<", "<=", ">", ">="]

Value = float | str | bool | None


@dataclass(frozen=True)
class Condition:
    """What has to hold in one message of a topic: ``Condition("eve/battery_state", [("/percentage", "<", 0.3)])``.

    Attributes:
        key: The topic, without the prefix.
        when: JSON pointer, operator and value of each comparison; without one any message will do.
    """

    key: str
    when: Sequence[tuple[str, Operator, Value]] = ()


class Watched(NamedTuple):
    """The command of an advance that has a condition watched.

    Attributes:
        name: What its sender calls it.
    """

    name: str
    condition: Condition

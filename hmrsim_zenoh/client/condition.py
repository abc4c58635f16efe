"""Conditions on topics, for which a client in lockstep has time stop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from pydantic_core import to_json

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

    def to_json(self, name: str) -> bytes:
        """Return the command that has it watched, called *name*."""
        return to_json({"watch": name, "key": self.key, "when": self.when})

"""A case: a schedule, and the world it happens in."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from hmrsim.fault_search.schedules.thing import Schedule, key_of


@dataclass(frozen=True)
class Case:
    """What one run is made of, beside the controller.

    Attributes:
        schedule: What goes wrong.
        definition: The world as a native file has it, without the schedule; None for the world of the check.
    """

    schedule: Schedule = ()
    definition: Mapping[str, Any] | None = None

    @cached_property
    def key(self) -> str:
        """SHA-256 of both, as 64 hex digits; equal cases have equal keys."""
        world = "" if self.definition is None else json.dumps(self.definition, sort_keys=True)
        return hashlib.sha256(f"{key_of(self.schedule)}{world}".encode()).hexdigest()

    def with_schedule(self, schedule: Schedule) -> Case:
        """Return the same world with another schedule."""
        return replace(self, schedule=schedule)

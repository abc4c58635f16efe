"""Components that robots can carry, one per file.

World files name them, robots are built with them, and actions ask for them.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import BaseModel, ConfigDict

from hmrsim.plugins import discover


class Settings(BaseModel):
    """The settings of a component in a world file: unknown keys, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)


@dataclass(frozen=True)
class Component:
    """A kind of component that robots can carry.

    Attributes:
        name: As in world files, and that of its module.
        settings: The model of its settings.
        create: Makes the component of one robot from its settings.
    """

    name: str
    settings: type[Settings]
    create: Any


@cache
def registry() -> dict[str, Component]:
    """Return all components by name."""
    return discover(sys.modules[__name__], "COMPONENT", Component)

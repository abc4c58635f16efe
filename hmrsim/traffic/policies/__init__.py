"""Traffic policies, which decide which vehicle may be where; one policy per file.

Waypoints and lanes are *slots*, numbered as in `hmrsim.navigation.lanes`: first the waypoints, then the lanes in either
direction.
A vehicle holds the slots of the leg that it drives, which are the lane and the waypoint at its end, or the slot that it
stands on. A policy decides when it may have them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field

from hmrsim.plugins import discover
from hmrsim.traffic.rules import Rules, Vehicle, Wait
from hmrsim.world.model import Derived

__all__ = ["Policy", "Rules", "Settings", "Vehicle", "Wait", "registry", "rules_of", "settings_of"]

if TYPE_CHECKING:
    from hmrsim.traffic.admission import Admission
    from hmrsim.world.model import World


class Settings(BaseModel):
    """The settings of traffic under every policy: unknown keys, NaN and infinity are errors.

    Attributes:
        policy: The policy's name; None where it is the default of the world.
        patience: Seconds that a robot waits before its goal is aborted; None for no limit.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    policy: str | None = None
    patience: Annotated[float, Field(strict=True, gt=0, le=1e9)] | None = 60.0


@dataclass(frozen=True)
class Policy:
    """One way to control traffic.

    Attributes:
        name: As in world files, and that of its module.
        settings: The model of its settings.
        rule: Makes the rules of one world; None where robots pass through each other.
    """

    name: str
    settings: type[Settings]
    rule: Callable[[Admission, Any], Rules] | None


@cache
def registry() -> dict[str, Policy]:
    """Return all policies by name."""
    return discover(sys.modules[__name__], "POLICY", Policy)


_policy_of: Final = Derived(lambda world: registry()[world.policy], "traffic", "robots", "robot_types")


def _settings(world: World) -> Settings:
    return _policy_of(world).settings.model_validate(world.traffic.model_dump())


settings_of: Final = Derived(_settings, "traffic", "robots", "robot_types")
"""Returns the settings of a world's policy, which must have been checked."""


def rules_of(admission: Admission) -> Rules | None:
    """Return the rules of a world's policy at work; None where robots pass through each other."""
    rule = _policy_of(admission.world).rule
    return None if rule is None else rule(admission, settings_of(admission.world))

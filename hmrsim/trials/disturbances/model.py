"""What a disturbance is: as YAML has it, and in Python."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from hmrsim.faults import Anchor

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding

Kind = Literal[
    "controller_killed",
    "controller_stalled",
    "second_controller",
    "reply_lost",
    "request_repeated",
    "simulation_reset",
]

_OF_KINDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "restart_after": "controller_killed",
        "duration": "controller_stalled",
        "count": "reply_lost and request_repeated",
    }
)
"""To which kinds a setting belongs."""

_MAX = 1e9


class Disturbance(BaseModel):
    """A disturbance of a controller or of its wire; it happens once.

    Attributes:
        disturbance: What happens.
        when: The event after which it happens.
        restart_after: Of a controller that is killed: after how many simulated seconds it is started again; None for
            never.
        duration: Of one that is stalled: for how many simulated seconds.
        count: How many answers get lost, or requests come twice; 1 if left out.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    disturbance: Kind = Field(description="What happens.")
    when: Anchor = Field(description="The event after which it happens.")
    restart_after: Annotated[float, Field(strict=True, ge=0, le=_MAX, json_schema_extra={"unit": "s"})] | None = Field(
        default=None, description="After how long a killed controller is started again; left out for never."
    )
    duration: Annotated[float, Field(strict=True, gt=0, le=_MAX, json_schema_extra={"unit": "s"})] | None = Field(
        default=None, description="How long a controller is stalled."
    )
    count: Annotated[int, Field(strict=True, ge=1, le=10_000)] | None = Field(
        default=None, description="How many answers get lost, or requests come twice; 1 if left out."
    )

    @model_validator(mode="after")
    def _settings_of_its_kind(self) -> Self:
        for name, kinds in _OF_KINDS.items():
            if getattr(self, name) is not None and self.disturbance not in kinds.split(" and "):
                raise ValueError(f"{name} belongs to {kinds}, not to {self.disturbance}; leave it out")
        if self.disturbance == "controller_stalled" and self.duration is None:
            raise ValueError("controller_stalled needs a duration, in simulated seconds")
        return self

    def flaws(self) -> Iterator[Finding]:
        """Yield what is wrong with it whatever the world is: kinds and fields of events that there are not."""
        for finding in self.when.flaws():
            yield replace(finding, path=("when", *finding.path))

    def describe(self) -> str:
        """Return it in words, such as ``the controller is killed: 0.5 s after pickup of eve is executing``."""
        return f"{self.what}: {self.when.describe()}"

    @property
    def what(self) -> str:
        """What happens, in words, such as ``the controller is killed``."""
        number = self.count or 1
        match self.disturbance:
            case "controller_killed" if self.restart_after is None:
                what = "the controller is killed"
            case "controller_killed":
                what = f"the controller is killed, and started again after {self.restart_after:g} s"
            case "controller_stalled":
                what = f"the controller is stalled for {self.duration:g} s"
            case "second_controller":
                what = "a second controller is started"
            case "reply_lost":
                what = "the next answer is lost" if number == 1 else f"the next {number} answers are lost"
            case "request_repeated":
                what = "the next request comes twice" if number == 1 else f"the next {number} requests come twice"
            case _:
                what = "the simulation is reset"
        return what

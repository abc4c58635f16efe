"""The model of an experiment's file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from hmrsim.trials import model
from hmrsim.trials.model import Controller, Count, Identifier, Level, Part, Seconds


class Range(Part):
    """A factor that takes any number between two; only a Latin hypercube draws from it.

    Attributes:
        low: The least.
        high: The greatest.
        whole: Whether it takes whole numbers only.
    """

    low: float
    high: float
    whole: bool = False

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high:
            raise ValueError(f"low {self.low:g} is not less than high {self.high:g}")
        return self


class Design(Part):
    """Which combinations of levels are run; one of the fields.

    Attributes:
        latin_hypercube: So many scenarios, in which each factor takes each part of its range as often.
        list: The scenarios themselves: rows of a table, or its file, whose columns are factors.
    """

    latin_hypercube: Count | None = None
    list: str | tuple[dict[str, Level], ...] | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if len(self.model_fields_set) != 1:
            raise ValueError("expected full, one_at_a_time, {latin_hypercube: 60} or {list: trials.csv}")
        return self


class Treatment(Controller):
    """What is compared: a controller, and maybe changes of the world that belong to it.

    Attributes:
        overlay: Laid over the world for this treatment alone, after all others.
    """

    overlay: dict[str, Any] = Field({})


class Variant(Part):
    """Changes that are chosen on the command line; all keys but *set* are those of an overlay.

    Attributes:
        set: Parameters of all controllers, in place of those of the same names.
    """

    model_config = ConfigDict(extra="allow")

    set: dict[str, Level] = Field({})


class Until(Part):
    """When enough replications were run.

    Attributes:
        measure: The measure whose mean has to be known.
        relative_error: Half the width of its confidence interval, as a share of the mean.
        error: The same of a measure of yes and no, as a share of 1.
        decided: Whether to go on until each treatment is known to be better or worse than the first one, or equivalent.
        confidence: Of the interval, or of all verdicts together.
    """

    measure: Identifier
    relative_error: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = None
    error: Annotated[float, Field(strict=True, gt=0, lt=1)] | None = None
    decided: bool = False
    confidence: Annotated[float, Field(strict=True, gt=0, lt=1)] = 0.95

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.relative_error is not None) + (self.error is not None) + self.decided != 1:
            raise ValueError("expected one of relative_error, error and decided: true")
        return self


def _replications(value: Any) -> Any:
    return {"min": value, "max": value} if isinstance(value, int) else value


class Replications(Part):
    """How often each scenario is run with each treatment, each time under another seed.

    Attributes:
        min: At least.
        max: At most.
        until: When that is enough; None for always *max*.
    """

    min: Count = 1
    max: Count = 1
    until: Until | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.min > self.max:
            raise ValueError(f"min {self.min} is more than max {self.max}")
        return self


class Limits(model.Limits):
    """The limits of a run.

    Attributes:
        simulated: Seconds of simulated time after which the run ends as ``timeout``.
        wall: Wall seconds in which the run waits: in which it computes nothing, and could not.
    """

    simulated: Seconds = 3600.0
    wall: Seconds = 300.0


class Ending(Part):
    """When a run ends, judged by the simulator; all of what is said must hold.

    The names in *item*, *robot*, *at* and *where* may be values that the controller has reported by `end_run`, such as
    ``${reported.executor}``; until it has reported them, nothing holds.

    Attributes:
        item: An item is *at* a place; *carried* says whether a robot holds it.
        robot: A robot is *at* a place.
        at: The name of a place, dock or waypoint.
        carried: Whether the item is held; None for either.
        event: An event of this kind comes, with the fields in *where*.
        where: Fields of the event and their values.
        reported: A controller has reported this word by `end_run`.
        orders: ``served``: so many orders were delivered as *count* says, or all that will come.
        count: How many orders.
        controller: The controller has ended: ``succeeded`` or ``failed``.
    """

    item: str | None = None
    robot: str | None = None
    at: str | None = None
    carried: bool | None = None
    event: str | None = None
    where: dict[str, Any] = Field({})
    reported: str | None = None
    orders: Literal["served"] | None = None
    count: Count | None = None
    controller: Literal["succeeded", "failed"] | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        said = [name for name in ("item", "robot", "event", "reported", "orders", "controller") if getattr(self, name)]
        if len(said) != 1:
            raise ValueError("expected one of item, robot, event, reported, orders and controller")
        if said[0] in {"item", "robot"} and self.at is None:
            raise ValueError(f"{said[0]} needs a place: at")
        return self


class Measure(Part):
    """What is measured at the end of a run.

    Attributes:
        value: An expression such as ``end.at`` or ``energy / orders.delivered``.
        better: Which values are better, for comparisons.
        margin: Differences of the means up to this count as none; None to find no equivalence.
        relative: Whether *margin* is a share of the first treatment's mean.
    """

    value: str
    better: Literal["smaller", "larger"] = "smaller"
    margin: Annotated[float, Field(strict=True, ge=0)] | None = None
    relative: bool = False


def _measure(value: Any) -> Any:
    return {"value": value} if isinstance(value, str) else value


class Keep(Part):
    """Which files of runs are kept.

    Attributes:
        traces: Of which runs: ``none``, ``failed`` or ``all``.
        coverage: Whether to count what happens to the nodes of trees, in a file for each treatment.
    """

    traces: Literal["none", "failed", "all"] = "none"
    coverage: Annotated[bool, Field(strict=True)] = False


def _kind(value: Any) -> str:
    """Return which of two kinds a value is meant as, so that it has the errors of that kind alone."""
    return "mapping" if isinstance(value, (dict, Part)) else "other"


Levels = Annotated[Annotated[tuple[Level, ...], Tag("other")] | Annotated[Range, Tag("mapping")], Discriminator(_kind)]
AnyDesign = Annotated[
    Annotated[Literal["full", "one_at_a_time"], Tag("other")] | Annotated[Design, Tag("mapping")], Discriminator(_kind)
]


def _one_or_several(value: Any) -> Any:
    return (value,) if isinstance(value, dict) else value


class ExperimentFile(Part):
    """An experiment: scenarios, treatments, replications, endings, measures."""

    name: Identifier
    world: str = Field(description="A world file, from the folder of this file, or the name of a shipped world.")
    tables: dict[Identifier, Any] = Field(default={}, description="Named tables in YAML, JSON or CSV, or written out.")
    levels: str | dict[str, Any] | None = Field(default=None, description="A table of this name, as in `tables`.")
    factors: dict[Identifier, Levels] = Field(default={}, description="What is varied, by name.")
    design: AnyDesign = "full"
    treatments: dict[Identifier, Treatment] = Field(min_length=1)
    replications: Annotated[Replications, BeforeValidator(_replications)] = Replications()
    seed: Annotated[int, Field(strict=True)] = 0
    overlay: dict[str, Any] = Field(default={}, description="Laid over the world, with the factors' levels as names.")
    variants: dict[Identifier, Variant] = Field(
        default={}, description="Further overlays, by name, and parameters of the controllers under `set`."
    )
    limits: Limits = Limits()
    ends: dict[Identifier, Annotated[tuple[Ending, ...], BeforeValidator(_one_or_several)]] = Field(
        default={}, description="The first that holds ends a run; one that holds for several conditions has a list."
    )
    successes: tuple[Identifier, ...] = Field(
        default=("success", "succeeded"), description="The endings that count as a success."
    )
    measures: dict[Identifier, Annotated[Measure, BeforeValidator(_measure)]] = Field({})
    keep: Keep = Keep()

"""The model of an experiment's file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from hmrsim.trials import model
from hmrsim.trials.model import Controller, Count, Identifier, Level, Part, Seconds


class Range(Part):
    """A factor with any number in a range; only a Latin hypercube draws from it.

    Attributes:
        low: The minimum.
        high: The maximum.
        whole: Whether it has whole numbers only.
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
    """The combinations of levels to run, by one of the fields.

    Attributes:
        latin_hypercube: The number of scenarios, in which each factor takes each part of its range equally often.
        list: The scenarios: the rows of a table, or its file, whose columns are factors.
    """

    latin_hypercube: Count | None = None
    list: str | tuple[dict[str, Level], ...] | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if len(self.model_fields_set) != 1:
            raise ValueError("expected full, one_at_a_time, {latin_hypercube: 60} or {list: trials.csv}")
        return self


class Treatment(Controller):
    """A treatment to compare: a controller, perhaps with changes of the world.

    Attributes:
        overlay: The overlay of the world for this treatment, applied after all others.
    """

    overlay: dict[str, Any] = Field({})


class Variant(Part):
    """Changes to choose on the command line; all keys except *set* are those of an overlay.

    Attributes:
        set: Parameters of all controllers, which replace those with the same names.
    """

    model_config = ConfigDict(extra="allow")

    set: dict[str, Level] = Field({})


class Until(Part):
    """The condition that ends the replications.

    Attributes:
        measure: The measure whose mean has to be known.
        relative_error: The half-width of its confidence interval, as a share of the mean.
        error: The half-width for a measure of yes and no, as a share of 1.
        decided: Whether to continue until each treatment is known to be better or worse than the first one, or
            equivalent.
        confidence: The confidence of the interval, or of all verdicts together.
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
    """The number of runs of each scenario with each treatment, each with another seed.

    Attributes:
        min: The minimum.
        max: The maximum.
        until: The condition to stop before *max*; None for none.
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
    """A condition that ends a run, judged by the simulator; all its fields must hold.

    The names in *item*, *robot*, *at* and *where* may be values that the controller has reported by `end_run`, such as
    ``${reported.executor}``; the condition does not hold before it has reported them.

    Attributes:
        item: The item that has to be *at* a place.
        robot: The robot that has to be *at* a place.
        at: The name of a place, dock or waypoint.
        carried: Whether a robot has to carry the item; None for either.
        event: The kind of an event that has to happen, with the fields in *where*.
        where: Fields of the event and their values.
        reported: The word that a controller has to report by `end_run`.
        orders: ``served`` if *count* orders, or all that will arrive, have to be delivered.
        count: The number of orders.
        controller: The ending that the controller has to have: ``succeeded`` or ``failed``.
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
        given = [name for name in ("item", "robot", "event", "reported", "orders", "controller") if getattr(self, name)]
        if len(given) != 1:
            raise ValueError("expected one of item, robot, event, reported, orders and controller")
        if given[0] in {"item", "robot"} and self.at is None:
            raise ValueError(f"{given[0]} needs a place: at")
        return self


class Measure(Part):
    """A measure of a run at its end.

    Attributes:
        value: An expression such as ``end.at`` or ``energy / orders.delivered``.
        better: The values that are better, for comparisons.
        margin: Differences of the means up to this count as equivalent; None if no means are equivalent.
        relative: Whether *margin* is a share of the first treatment's mean.
    """

    value: str
    better: Literal["smaller", "larger"] = "smaller"
    margin: Annotated[float, Field(strict=True, ge=0)] | None = None
    relative: bool = False


def _measure(value: Any) -> Any:
    return {"value": value} if isinstance(value, str) else value


class Keep(Part):
    """The files of runs to keep.

    Attributes:
        traces: The runs whose traces are kept: ``none``, ``failed`` or ``all``.
        coverage: Whether to write the coverage of trees, in a file for each treatment.
    """

    traces: Literal["none", "failed", "all"] = "none"
    coverage: Annotated[bool, Field(strict=True)] = False


def _kind(value: Any) -> str:
    """Return the tag of the type that a value is validated as, so that it gets the errors of that type alone."""
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

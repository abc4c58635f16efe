"""The contents of an experiment's report. Missing values are None."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, Field

if TYPE_CHECKING:
    from hmrsim.experiments.statistics.intervals import Interval


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True)


class Estimate(_Model):
    """A mean, a share or a difference, with the bounds of its interval."""

    estimate: float | None
    low: float | None
    high: float | None
    n: int = Field(description="The number of values; runs that are the same count once.")


class Experiment(_Model):
    """The experiment that the results belong to."""

    name: str
    path: str = Field(description="The file of the experiment, where it was run.")
    text: str = Field(description="What was in that file.")
    hash: str
    seed: int | None
    world: str
    world_hash: str
    variant: tuple[str, ...]
    factors: tuple[str, ...]
    scenarios: int
    replications: dict[str, Any]
    hmrsim: str
    python: str
    host: str


class Measure(_Model):
    """A measure of the experiment; success always is one."""

    value: str = Field(description="Its expression; empty for success.")
    better: str
    margin: float | None
    relative: bool


class Column(_Model):
    """The values of a measure in the runs of a treatment."""

    mean: Estimate
    missing: int = Field(description="Runs without a value.")
    failed: int = Field(description="Values of runs without success.")
    stddev: float | None
    least: float | None
    median: float | None
    p95: float | None
    most: float | None


class Treatment(_Model):
    """The runs of a treatment."""

    name: str
    runs: int
    success: Estimate
    endings: dict[str, int]
    measures: dict[str, Column]


class Verdict(_Model):
    """The verdict on a measure: the difference between a treatment and the first one."""

    verdict: str
    decided_after: int | None = Field(description="Pairs.")
    difference: Estimate = Field(description="With bounds that hold however often one looks.")
    differing: int = Field(description="Pairs whose two values are not equal.")
    alpha: float = Field(description="The probability that it is false.")
    margin: float | None = Field(description="Differences up to this count as none; a share if relative.")
    relative: bool


class Change(_Model):
    """The number of pairs that ended one way with the first treatment and another way with the other."""

    first: str
    other: str
    pairs: int


class Pair(_Model):
    """Two runs under one seed that ended differently."""

    scenario: int
    levels: dict[str, Any]
    replication: int
    seed: int
    first: int = Field(description="The number of the run with the first treatment.")
    first_ending: str
    other: int
    other_ending: str


class Comparison(_Model):
    """A treatment, compared with the first one in pairs of the same scenario and replication."""

    first: str
    treatment: str
    pairs: int
    alone: tuple[int, int] = Field(description="Runs of either that have no counterpart.")
    measures: dict[str, Verdict]
    changes: tuple[Change, ...]
    differing: int = Field(description="Pairs that ended differently.")
    runs: tuple[Pair, ...] = Field(description="The first of these.")
    notes: tuple[str, ...]


class Level(_Model):
    """The effect of one level of a factor."""

    factor: str
    level: str
    mean: Estimate
    effect: float = Field(description="The mean, less that of all runs.")


class Interaction(_Model):
    """The two levels of two factors that do most together, beyond what each does by itself."""

    factors: tuple[str, str]
    levels: tuple[str, str]
    mean: Estimate
    expected: float = Field(description="The mean of all runs and both main effects, together.")


class Effects(_Model):
    """The effects of factors on a measure."""

    mean: float
    levels: tuple[Level, ...]
    interactions: tuple[Interaction, ...] = Field(description="The largest first.")
    notes: tuple[str, ...]


class Histogram(_Model):
    """The number of values of a measure between two edges, for each treatment."""

    edges: tuple[float, ...]
    counts: dict[str, tuple[int, ...]]


class Point(_Model):
    """The mean of all runs up to a replication, with its interval."""

    replications: int
    mean: Estimate


class Cause(_Model):
    """Why runs did not succeed, and how many."""

    ending: str
    cause: str
    runs: int
    first: int = Field(description="The number of the first one.")


class Failure(_Model):
    """A run that did not succeed."""

    number: int
    treatment: str
    scenario: int
    levels: dict[str, Any]
    replication: int
    seed: int
    ending: str
    cause: str


class Ending(_Model):
    """An ending of runs, and whether it counts as a success."""

    name: str
    runs: int
    success: bool


class Failures(_Model):
    """The runs that did not succeed."""

    total: int
    causes: tuple[Cause, ...] = Field(description="The most frequent first.")
    runs: tuple[Failure, ...] = Field(description="The first of them.")


class Summary(_Model):
    """The summary of an experiment's results."""

    experiment: Experiment
    runs: int
    least: int = Field(description="Runs that the experiment has at least, once it is complete.")
    most: int
    successes: int
    notes: tuple[str, ...]
    measures: dict[str, Measure]
    endings: tuple[Ending, ...] = Field(description="The most frequent first.")
    treatments: tuple[Treatment, ...]
    comparisons: tuple[Comparison, ...]
    effects: dict[str, Effects] = Field(description="By measure, also of success.")
    distributions: dict[str, Histogram] = Field(description="By measure.")
    running: dict[str, dict[str, tuple[Point, ...]]] = Field(description="By measure, also of success, and treatment.")
    failures: Failures


def estimate_of(interval: Interval) -> Estimate:
    """Return an interval as a value of the report."""
    return Estimate(estimate=interval.estimate, low=interval.low, high=interval.high, n=interval.n)

"""The model of a file of properties."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final, Self

from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag

from hmrsim.diagnostics import Finding, Path, meant, problems_of, shown
from hmrsim.properties.model import operators as by_operator
from hmrsim.properties.model import patterns as by_pattern
from hmrsim.properties.model.built_in import BuiltIn
from hmrsim.properties.model.formulas import Formula
from hmrsim.properties.model.part import Identifier, Part

if TYPE_CHECKING:
    from hmrsim.errors import Problem

OPERATORS: Final = ("always", "never", "eventually", "sometimes", "whenever", "reports", "formula")

KINDS: Final[Mapping[str, type[Part]]] = MappingProxyType(
    {
        "always": by_operator.Always,
        "never": by_operator.Never,
        "eventually": by_operator.Eventually,
        "sometimes": by_operator.Sometimes,
        "whenever": by_operator.Whenever,
        "reports": by_operator.Reports,
        "formula": Formula,
        "visit": by_pattern.Visit,
        "sequenced_visit": by_pattern.SequencedVisit,
        "ordered_visit": by_pattern.OrderedVisit,
        "strict_ordered_visit": by_pattern.StrictOrderedVisit,
        "fair_visit": by_pattern.FairVisit,
        "patrolling": by_pattern.Patrolling,
        "sequenced_patrolling": by_pattern.SequencedPatrolling,
        "ordered_patrolling": by_pattern.OrderedPatrolling,
        "strict_ordered_patrolling": by_pattern.StrictOrderedPatrolling,
        "fair_patrolling": by_pattern.FairPatrolling,
        "past_avoidance": by_pattern.PastAvoidance,
        "global_avoidance": by_pattern.GlobalAvoidance,
        "future_avoidance": by_pattern.FutureAvoidance,
        "upper_restricted_avoidance": by_pattern.UpperRestrictedAvoidance,
        "exact_restricted_avoidance": by_pattern.ExactRestrictedAvoidance,
        "lower_restricted_avoidance": by_pattern.LowerRestrictedAvoidance,
        "wait": by_pattern.Wait,
        "instantaneous_reaction": by_pattern.InstantaneousReaction,
        "delayed_reaction": by_pattern.DelayedReaction,
        "prompt_reaction": by_pattern.PromptReaction,
        "bound_reaction": by_pattern.BoundReaction,
        "bound_delay": by_pattern.BoundDelay,
    }
)
"""Properties by the key that tells what each is."""


def kind_of(value: Any) -> str | None:
    """Return the key that tells what a property is; None if it is none."""
    if isinstance(value, BaseModel):
        return next((key for key, kind in KINDS.items() if type(value) is kind), None)
    return next((key for key in KINDS if key in value), None) if isinstance(value, Mapping) else None


def _tag(value: Any) -> str | None:
    """Return the tag of a property's model, which is no key of it, so that paths of errors are not mistaken."""
    key = kind_of(value)
    return None if key is None else f"<{key}>"


def _known(value: Any) -> Any:
    if kind_of(value) is not None:
        return value
    if not isinstance(value, Mapping):
        raise ValueError(f"expected a property such as {{never: {{robot: eve, at: lab}}}}, got {shown(value)}")  # noqa: TRY004 - of a file, not of a program
    alike = next((f"; did you mean {alike!r}?" for key in value if (alike := meant(str(key), KINDS))), "")
    said = f"; one has a key of {', '.join(OPERATORS)} or the name of a pattern, such as ordered_visit"
    raise ValueError(f"is no property{alike or said}")


Property = Annotated[
    Annotated[
        Annotated[by_operator.Always, Tag("<always>")]
        | Annotated[by_operator.Never, Tag("<never>")]
        | Annotated[by_operator.Eventually, Tag("<eventually>")]
        | Annotated[by_operator.Sometimes, Tag("<sometimes>")]
        | Annotated[by_operator.Whenever, Tag("<whenever>")]
        | Annotated[by_operator.Reports, Tag("<reports>")]
        | Annotated[Formula, Tag("<formula>")]
        | Annotated[by_pattern.Visit, Tag("<visit>")]
        | Annotated[by_pattern.SequencedVisit, Tag("<sequenced_visit>")]
        | Annotated[by_pattern.OrderedVisit, Tag("<ordered_visit>")]
        | Annotated[by_pattern.StrictOrderedVisit, Tag("<strict_ordered_visit>")]
        | Annotated[by_pattern.FairVisit, Tag("<fair_visit>")]
        | Annotated[by_pattern.Patrolling, Tag("<patrolling>")]
        | Annotated[by_pattern.SequencedPatrolling, Tag("<sequenced_patrolling>")]
        | Annotated[by_pattern.OrderedPatrolling, Tag("<ordered_patrolling>")]
        | Annotated[by_pattern.StrictOrderedPatrolling, Tag("<strict_ordered_patrolling>")]
        | Annotated[by_pattern.FairPatrolling, Tag("<fair_patrolling>")]
        | Annotated[by_pattern.PastAvoidance, Tag("<past_avoidance>")]
        | Annotated[by_pattern.GlobalAvoidance, Tag("<global_avoidance>")]
        | Annotated[by_pattern.FutureAvoidance, Tag("<future_avoidance>")]
        | Annotated[by_pattern.UpperRestrictedAvoidance, Tag("<upper_restricted_avoidance>")]
        | Annotated[by_pattern.ExactRestrictedAvoidance, Tag("<exact_restricted_avoidance>")]
        | Annotated[by_pattern.LowerRestrictedAvoidance, Tag("<lower_restricted_avoidance>")]
        | Annotated[by_pattern.Wait, Tag("<wait>")]
        | Annotated[by_pattern.InstantaneousReaction, Tag("<instantaneous_reaction>")]
        | Annotated[by_pattern.DelayedReaction, Tag("<delayed_reaction>")]
        | Annotated[by_pattern.PromptReaction, Tag("<prompt_reaction>")]
        | Annotated[by_pattern.BoundReaction, Tag("<bound_reaction>")]
        | Annotated[by_pattern.BoundDelay, Tag("<bound_delay>")],
        Discriminator(_tag),
    ],
    BeforeValidator(_known),
]
"""A property of runs."""


class Properties(Part):
    """Properties of runs, by name, and those that are built in."""

    properties: dict[Identifier, Property] = Field(default={}, description="By name.")
    built_in: BuiltIn = BuiltIn()
    _file: str = "properties"
    _line: Callable[[Path], int | None] = lambda _path: None

    def located(self, file: str, line: Callable[[Path], int | None]) -> Self:
        """Return the same properties, with their file and a function that returns the line of a path in it."""
        copied = self.model_copy()
        copied._file, copied._line = file, line  # noqa: SLF001 - its own
        return copied

    def problems(self, findings: Iterable[Finding]) -> list[Problem]:
        """Return findings about these properties with their file and lines, in the order of the file."""
        return problems_of(findings, self._file, self._line)

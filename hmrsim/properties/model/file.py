"""The model of a file of properties, with the settings of those that are built in."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, WithJsonSchema

from hmrsim.diagnostics import Finding, Path, problems_of
from hmrsim.properties.model.part import Count, Identifier, Part, Seconds
from hmrsim.properties.model.property import Property

if TYPE_CHECKING:
    from hmrsim.errors import Problem


def _default(value: Any, info: ValidationInfo) -> Any:
    """Return the default where a file says ``true``."""
    return _DEFAULTS[info.field_name or ""] if value is True else value


_DEFAULTS: Final = {"no_deadlock": 60.0, "nobody_stranded": 120.0, "no_vain_goals": 5}

_ON_OR_OFF: Final = {"type": "boolean"}
_Limit = Annotated[
    Seconds | Literal[False],
    BeforeValidator(_default),
    WithJsonSchema({"anyOf": [{"type": "number", "exclusiveMinimum": 0, "maximum": 1e9}, _ON_OR_OFF]}),
]
_Times = Annotated[
    Count | Literal[False],
    BeforeValidator(_default),
    WithJsonSchema({"anyOf": [{"type": "integer", "minimum": 1, "maximum": 1_000_000}, _ON_OR_OFF]}),
]


class Recovery(Part):
    """The time in which a controller has to recover.

    Attributes:
        within: How long a single fault may last that has to be borne, and how long several faults have to be over.
    """

    within: Seconds


class BuiltIn(Part):
    """The properties that are built in, with their limits; ``false`` switches one off.

    Attributes:
        goals_end: Each accepted goal gets exactly one terminal status by the end of the run.
        no_deadlock: Robots do not wait for each other in a circle for longer than so many simulated seconds.
        nobody_stranded: No robot has an empty battery for longer than so many seconds without being charged.
        orders_in_time: No order is late or lost.
        controller_lives: The controller does not crash, hang, or run out of memory.
        no_vain_goals: The same goal to the same robot is not rejected or aborted so many times in a row.
        mission_ends: The controller ends before the limit of simulated time.
        recovers: The mission does not fail after transient faults; off by default.
    """

    goals_end: bool = True
    no_deadlock: _Limit = _DEFAULTS["no_deadlock"]
    nobody_stranded: _Limit = _DEFAULTS["nobody_stranded"]
    orders_in_time: bool = True
    controller_lives: bool = True
    no_vain_goals: _Times = 5
    mission_ends: bool = True
    recovers: Recovery | Literal[False] = False


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

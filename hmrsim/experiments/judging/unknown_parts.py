"""Measures that ask for what no run will have, found in a simulation that has not begun."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

from pydantic import BaseModel

from hmrsim.experiments.judging.endings import Judge
from hmrsim.experiments.judging.measures import NAMES, Names
from hmrsim.report.sink import LiveReport
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.overlays.expressions import OverlayFlaw, UnknownPart, evaluate, names_in, parts_in

if TYPE_CHECKING:
    from hmrsim.experiments.file.model import ExperimentFile
    from hmrsim.world.model import World


class Unknown(NamedTuple):
    """A part of a measure that is not there.

    Attributes:
        measure: The measure's name.
        text: What is not there, and what would do.
        certain: Whether it can't come to be in a run, as a robot can that is spawned.
    """

    measure: str
    text: str
    certain: bool


def unknown_parts(file: ExperimentFile, world: World) -> Iterator[Unknown]:
    """Yield what the measures of an experiment ask for although it is not there, in a world of it."""
    parts = [(name, part) for name, measure in file.measures.items() for part in _parts(measure.value)]
    if not parts:
        return
    settings = RunSettings()
    report = LiveReport(world, settings)
    simulator = Simulator(world, settings, watchers=lambda made: [report.sink(made)])
    names = Names(Judge({}), simulator, lambda: _outline(report.report(simulator)), [*file.ends])
    for name, part in parts:
        try:
            evaluate(part, names)
        except UnknownPart as error:
            yield Unknown(name, str(error), not names_in(part) & {"robots", "items"})
        except OverlayFlaw:
            # What is not there yet, such as a robot's first order, may come.
            continue


def _parts(expression: str) -> list[str]:
    with suppress(OverlayFlaw):
        return [part for part in parts_in(expression) if names_in(part) <= {*NAMES}]
    return []


class _Anything(Mapping[str, Any]):
    """A table whose keys are not known before a run, such as the kinds of its events."""

    def __getitem__(self, key: str) -> Any:
        return self

    def __contains__(self, key: object) -> bool:
        return True

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0


def _outline(value: Any) -> Any:
    """Return a report as tables, of which those whose keys depend on the run have any key."""
    if isinstance(value, BaseModel):
        return {name: _outline(getattr(value, name)) for name in type(value).model_fields}
    if isinstance(value, Mapping):
        return _Anything()
    if isinstance(value, (list, tuple)):
        return [_outline(each) for each in value]
    return value

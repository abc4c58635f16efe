"""The measures of a run: expressions over the state of the simulator at the end."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from pydantic import BaseModel

from hmrsim.experiments.endings import Judge
from hmrsim.report.delays import PARTS
from hmrsim.report.figures import quantile
from hmrsim.report.sink import LiveReport
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trials.trial import BUILT_IN
from hmrsim.world.overlays.expressions import OverlayFlaw, UnknownPart, evaluate, names_in, parts_in

if TYPE_CHECKING:
    from hmrsim.experiments.model import ExperimentFile
    from hmrsim.world.model import World

Value = float | str | None

REPORT: Final = "report"
"""The name under which expressions find the run's report, as `hmrsim report --json` has it."""

_DELAY: Final = re.compile(r"orders\.delay")
"""Begins the parts of expressions that need the report."""

NAMES: Final = ("end", "ends", "energy", "recoveries", "goals", "orders", "robots", "items", "reported", REPORT)
"""What expressions may ask for."""


def measures_of(
    file: ExperimentFile, judge: Judge, simulator: Simulator, report: Callable[[], Mapping[str, Any]]
) -> tuple[dict[str, Value], list[str]]:
    """Return the measures of a run that has ended, and why some have no value; *report* makes the run's report."""
    names = Names(judge, simulator, report, [*file.ends])
    found: dict[str, Value] = {}
    flaws: list[str] = []
    for name, measure in file.measures.items():
        try:
            value = evaluate(measure.value, names)
        except ValueError as error:
            value = None
            flaws.append(f"{name}: {error}")
        found[name] = _plain(value)
    return found, flaws


def needs_report(file: ExperimentFile) -> bool:
    """Return whether a measure asks for the report, which takes time to make."""
    values = [measure.value for measure in file.measures.values()]
    return any(REPORT in names_in(value) or any(map(_DELAY.match, _parts(value))) for value in values)


def _plain(value: Any) -> Value:
    if isinstance(value, bool):
        return float(value)
    if isinstance(value, (int, float)):
        return float(value) if math.isfinite(value) else None
    return value if isinstance(value, str) else None


class Names(Mapping[str, Any]):
    """The values that expressions may ask for, each made when it is asked for; *labels* are those of endings."""

    def __init__(
        self, judge: Judge, simulator: Simulator, report: Callable[[], Mapping[str, Any]], labels: list[str]
    ) -> None:
        self._made: dict[str, Callable[[], Any]] = {
            "end": lambda: {"label": judge.label, "at": judge.at},
            "ends": lambda: {**dict.fromkeys(labels, 0), **dict.fromkeys(BUILT_IN, 0), judge.label: 1},
            "energy": lambda: math.fsum(_energy(simulator)),
            "recoveries": lambda: sum(robot.recoveries for robot in simulator.robots.values()),
            "goals": lambda: judge.counts,
            "orders": lambda: _Orders(simulator, report),
            "robots": lambda: {name: _robot(simulator, name) for name in simulator.robots},
            "items": lambda: {
                name: {"x": item.position[0], "y": item.position[1]} for name, item in simulator.items.items()
            },
            "reported": lambda: _Reported(judge.reported),
            REPORT: report,
        }
        self._get = cache(lambda name: self._made[name]())

    def __getitem__(self, name: str) -> Any:
        """Return the value of a name."""
        return self._get(name)

    def __contains__(self, name: object) -> bool:
        """Return whether expressions may ask for a name."""
        return name in self._made

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names that expressions may use."""
        return iter(self._made)

    def __len__(self) -> int:
        """Return how many names there are."""
        return len(self._made)


class _Reported(dict[str, Any]):
    """The values that controllers have reported, None for all other names."""

    def __contains__(self, name: object) -> bool:
        return True

    def __missing__(self, name: str) -> None:
        return None


def _energy(simulator: Simulator) -> Iterator[float]:
    for robot in simulator.robots.values():
        if robot.energy is not None:
            yield robot.energy.battery.used(simulator.now)


def _robot(simulator: Simulator, name: str) -> dict[str, Any]:
    robot = simulator.robots[name]
    x, y = robot.pose().point
    battery = robot.energy.battery if robot.energy else None
    return {
        "x": x,
        "y": y,
        "recoveries": robot.recoveries,
        "disabled": bool(robot.disabled_reasons),
        "battery": battery.share(simulator.now) if battery else None,
        "energy": battery.used(simulator.now) if battery else 0.0,
    }


class _Orders(dict[str, Any]):
    """The orders of a run; the parts of their lead time come from the report, which is made when they are asked for."""

    def __init__(self, simulator: Simulator, report: Callable[[], Mapping[str, Any]]) -> None:
        super().__init__(_orders(simulator), delay=None)
        self._report = report

    def __getitem__(self, key: str) -> Any:
        if key != "delay":
            return super().__getitem__(key)
        demand = self._report().get("demand") or {}
        return demand.get("delay") or dict.fromkeys(PARTS)


def _orders(simulator: Simulator) -> dict[str, Any]:
    demand = simulator.demand
    totals = demand.totals
    leads = sorted(demand.lead_times)
    return {
        "placed": totals.placed,
        "delivered": totals.delivered,
        "late": totals.late,
        "lost": totals.lost,
        "open": len(demand.open),
        "lead_time": {
            "mean": math.fsum(leads) / len(leads) if leads else None,
            "p50": quantile(leads, 0.5),
            "p95": quantile(leads, 0.95),
            "max": leads[-1] if leads else None,
        },
    }


class Unknown(NamedTuple):
    """A part of a measure that is not there.

    Attributes:
        text: What is not there, and what would do.
        certain: Whether it can't come to be in a run, as a robot can that is spawned.
    """

    measure: str
    text: str
    certain: bool


def unknown_parts(file: ExperimentFile, endings: Iterable[str], world: World) -> Iterator[Unknown]:
    """Yield the parts that measures of an experiment use and that runs with these endings in this world lack."""
    parts = [(name, part) for name, measure in file.measures.items() for part in _parts(measure.value)]
    if not parts:
        return
    settings = RunSettings()
    report = LiveReport(world, settings)
    simulator = Simulator(world, settings, watchers=lambda made: [report.sink(made)])
    names = Names(Judge({}), simulator, lambda: _outline(report.report(simulator)), [*endings])
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

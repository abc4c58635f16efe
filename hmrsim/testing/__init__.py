"""Unit tests of controllers: a simulation within the test's own process, and what happened in it.

::

    from hmrsim.testing import simulation

    def test_the_medicine_arrives():
        with simulation("hospital", tree="my_robots.trees:mission") as run:
            run.to_the_end()
            run.check_succeeded()
            assert "ward_a" == run.where("medicine")

There is no network, no thread and no waiting: time moves in lockstep, a mission takes milliseconds, and every run is
the same. With pytest the fixture `simulation` is there without an import.

An export is loaded when it is first used, as pytest loads this package in any case.
"""

from __future__ import annotations

import importlib
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hmrsim.testing.checking import check, schedules
    from hmrsim.testing.record import Goal, Happening
    from hmrsim.testing.run import Run, simulation

__all__ = ["Goal", "Happening", "Run", "check", "schedules", "simulation"]

_HOMES = MappingProxyType(
    {
        "Goal": "record",
        "Happening": "record",
        "Run": "run",
        "check": "checking",
        "schedules": "checking",
        "simulation": "run",
    }
)


def __getattr__(name: str) -> object:
    """Return an export; raise AttributeError if there is none of this name."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value

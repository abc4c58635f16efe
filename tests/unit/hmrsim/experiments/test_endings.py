"""Where an ending of an experiment begins to hold."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hmrsim.experiments.endings import NEAR, _near, _orders_are_served


def with_orders(delivered: int, *, served: bool) -> Any:
    """Return what stands for a simulator that has delivered so many orders."""
    return SimpleNamespace(demand=SimpleNamespace(totals=SimpleNamespace(delivered=delivered), served=served))


@pytest.mark.parametrize(("delivered", "holds"), [(2, False), (3, True), (4, True)])
def test_so_many_orders_are_served_with_the_last_of_them(delivered: int, holds: bool) -> None:  # noqa: FBT001
    """And not one later."""
    assert holds is _orders_are_served(3, with_orders(delivered, served=False), None)


def test_all_orders_are_served_when_the_demand_says_so() -> None:
    """However many there were."""
    assert [True, False] == [_orders_are_served(None, with_orders(0, served=each), None) for each in (True, False)]


@pytest.mark.parametrize("units", ["m", "px"])
def test_what_is_as_far_away_as_is_near_is_near(units: str) -> None:
    """A robot that stops there has come."""
    world: Any = SimpleNamespace(units=units, point=lambda _name: (0.0, 0.0))
    simulator: Any = SimpleNamespace(world=world)
    reach = NEAR[units]

    assert [True, False] == [_near(simulator, (x, 0.0), "home") for x in (reach, reach * 1.001)]

"""The endings of runs that an experiment defines."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hmrsim.experiments.endings import NEAR, Judge, _near, _orders_are_served
from hmrsim.experiments.model import Ending
from hmrsim.protocol.topics import Topic


def with_orders(delivered: int, *, served: bool) -> Any:
    """Return a stand-in for a simulator that has delivered a number of orders."""
    return SimpleNamespace(demand=SimpleNamespace(totals=SimpleNamespace(delivered=delivered), served=served))


@pytest.mark.parametrize(("delivered", "holds"), [(2, False), (3, True), (4, True)])
def test_orders_are_served_with_the_last_one(delivered: int, holds: bool) -> None:  # noqa: FBT001
    assert holds is _orders_are_served(3, with_orders(delivered, served=False), None)


def test_all_orders_are_served_when_the_demand_says_so() -> None:
    assert [True, False] == [_orders_are_served(None, with_orders(0, served=each), None) for each in (True, False)]


@pytest.mark.parametrize("units", ["m", "px"])
def test_robot_at_the_limit_of_near_has_arrived(units: str) -> None:
    world: Any = SimpleNamespace(units=units, point=lambda _name: (0.0, 0.0))
    simulator: Any = SimpleNamespace(world=world)
    reach = NEAR[units]

    assert [True, False] == [_near(simulator, (x, 0.0), "home") for x in (reach, reach * 1.001)]


@pytest.mark.parametrize(
    ("ending", "topics"),
    [
        ({"robot": "eve", "at": "home"}, {Topic.EVENTS}),
        ({"reported": "tired"}, set()),
        ({"controller": "failed"}, set()),
    ],
)
def test_events_are_made_only_if_one_may_end_the_run(ending: dict[str, str], topics: set[Topic]) -> None:
    judge = Judge({"over": [Ending.model_validate(ending)]})

    assert topics == judge.topics

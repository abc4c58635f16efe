"""Whether a robot is near a point."""

from __future__ import annotations

import pytest

from tests.simulation import simulate


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((2.0, 8.0), True),
        ((2.0, 8.9), True),
        ((2.9, 8.0), True),
        ((2.0, 9.0), False),
        ((2.9, 8.9), False),
        ((8.0, 2.0), False),
        ((2.0, 2.0), False),
    ],
)
def test_a_robot_within_a_metre_is_inside_a_circle(point, expected):
    run = simulate({"robots": {"eve": {"at": [2.0, 8.0]}}})

    assert expected is run.simulator.robots["eve"].motion.is_within(1.0, point)

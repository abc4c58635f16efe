"""Large numbers of seeded runs show whether a change matters.

Asked in https://github.com/ros-navigation/navigation2/issues/1205, which requests a significant comparison and recorded
seeds.
"""

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation

DOORS = {"doors.kitchen.opening_time": {"triangular": {"low": 1, "mode": 2, "high": 8}}}
SEEDS = range(40)


def duration(seed: int, speed: float) -> float:
    """Return how long mocha takes to bring a coffee to table 1, under one seed."""
    changes = {**DOORS, "robot_types.waiter.base.speed": speed}
    with simulation("cafe", changes=changes, settings=RunSettings(seed=seed)) as run:
        mocha = run.commander("mocha")
        mocha.navigate_to("counter")
        mocha.pickup("coffee")
        mocha.navigate_to("table_1")
        return run.now


def test_a_faster_robot_is_significantly_better() -> None:
    """Under one seed, both robots meet the same random door, so few runs are enough."""
    statistics = pytest.importorskip("hmrsim.experiments.statistics", reason="needs the extra experiments")
    slow = [duration(seed, 0.8) for seed in SEEDS]
    fast = [duration(seed, 1.0) for seed in SEEDS]

    found = statistics.compare(slow, fast, statistics.Criterion(larger_is_better=False))

    assert found.verdict == "better"
    assert found.difference.high < 0


def test_a_seed_repeats_a_run() -> None:
    """The same seed gives the same duration, and another seed gives another."""
    assert duration(7, 1.0) == duration(7, 1.0) != duration(8, 1.0)

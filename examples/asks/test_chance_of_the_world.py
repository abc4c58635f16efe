"""Randomness belongs to the world, and a reset with a seed repeats it.

Asked in https://github.com/sea-bass/pyrobosim/issues/231 and https://github.com/sea-bass/pyrobosim/issues/380.
"""

from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation
from hmrsim_zenoh import GoalFailed

CLUMSY = {"faults.+": {"type": "claw_misses", "robot": "mocha", "probability": 0.5}}


def tries(seed: int) -> int:
    """Return how often the claw misses under a seed."""
    with simulation("cafe", changes=CLUMSY, settings=RunSettings(seed=seed)) as run:
        mocha = run.commander("mocha")
        mocha.navigate_to("counter")
        while not run.carrier("coffee"):
            try:
                mocha.pickup("coffee")
            except GoalFailed:
                mocha.wait(1)
        return len(run.goals("mocha", action="pickup", status="ABORTED"))


def test_a_seed_determines_the_random_numbers() -> None:
    """The same seed gives the same number of misses, and not all seeds give the same."""
    counts = [tries(seed) for seed in range(10)]

    assert counts == [tries(seed) for seed in range(10)]
    assert len(set(counts)) > 1

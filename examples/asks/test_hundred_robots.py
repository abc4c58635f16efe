"""A hundred robots work on one core, far faster than real time.

Asked in https://github.com/open-rmf/rmf/issues/712, which requests a light 2D simulation, because 3D simulations lag
with that many robots.
"""

from hmrsim.testing import simulation


def test_ten_minutes_of_a_warehouse() -> None:
    """A hundred robots run their scripts for ten simulated minutes, and no goal is aborted."""
    with simulation("warehouse") as run:
        run.client.sleep(600)

        assert len(run.simulator.robots) == 100
        assert len(run.goals(status="SUCCEEDED")) > 200
        assert run.goals(status="ABORTED") == []

"""A hundred robots work on one core, far faster than in real time.

Asked in https://github.com/open-rmf/rmf/issues/712: for a light simulation in 2-D, as those in 3-D lag from there on.
"""

from hmrsim.testing import simulation


def test_an_hour_of_a_warehouse() -> None:
    """A hundred robots with scripts: all goals end, and all of that within a second or two."""
    with simulation("warehouse") as run:
        run.client.sleep(600)

        assert len(run.simulator.robots) == 100
        assert len(run.goals(status="SUCCEEDED")) > 200
        assert run.goals(status="ABORTED") == []

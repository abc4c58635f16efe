"""A mission that ends at the instant at which it begins leaves no robot busy.

Asked in https://github.com/equinor/flotilla/issues/1387, where such a mission leaves its robot busy forever.
"""

from hmrsim.testing import simulation


def test_the_robot_is_free_after_a_hundred_such_missions() -> None:
    """The robot is already in the kitchen; each goal gets one terminal status."""
    with simulation("cafe") as run:
        chai = run.commander("chai")
        for _ in range(100):
            chai.navigate_to("kitchen")

        assert run.now == 0.0
        assert len(run.goals("chai", status="SUCCEEDED")) == 100
        chai.navigate_to("counter")
        assert run.where("chai") == "counter"

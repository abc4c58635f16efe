"""Doors open in the order in which a robot reaches them, and only for robots that may pass.

Asked in https://github.com/open-rmf/rmf/issues/478, which requests a test of custom doors and lifts without Gazebo.
"""

import pytest

from hmrsim.testing import simulation
from hmrsim_zenoh import GoalFailed

AIRLOCK = {
    "name": "airlock",
    "waypoints": {"outside": [0, 0], "lock": [4, 0], "inside": [8, 0]},
    "lanes": [["outside", "lock"], ["lock", "inside"]],
    "doors": {
        "outer": {"at": [[2, -1], [2, 1]], "type": "sliding", "opening_time": 2, "opens_for": ["nurse"]},
        "inner": {"at": [[6, -1], [6, 1]], "type": "sliding", "opening_time": 2, "opens_for": ["nurse"]},
    },
    "robot_types": {"nurse": {}, "porter": {}},
    "robots": {"wall_e": {"type": "nurse", "at": "outside"}, "eve": {"type": "porter", "at": "outside"}},
}


def test_doors_open_one_after_the_other() -> None:
    """The inner door opens after the outer one."""
    with simulation(AIRLOCK) as run:
        run.commander("wall_e").navigate_to("inside")

        assert [event.fields["door"] for event in run.happened("door_opened")] == ["outer", "inner"]


def test_a_robot_that_may_not_pass_has_no_route() -> None:
    """The goal fails before the robot drives, and no door opens."""
    with simulation(AIRLOCK) as run:
        with pytest.raises(GoalFailed, match=r"\(208\)"):
            run.commander("eve").navigate_to("inside")

        assert run.happened("door_opened") == []

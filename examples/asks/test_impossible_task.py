"""An impossible task fails at once with a reason, and goes to a robot that can do it.

Asked in https://github.com/open-rmf/rmf_demos/issues/341 and https://github.com/open-rmf/rmf_ros2/issues/16, where
tasks are assigned to robots that can't get there.
"""

import pytest

from hmrsim.testing import simulation
from hmrsim_zenoh import Commander, GoalFailed


def able(robots: list[Commander], place: str) -> list[str]:
    """Return the robots that have a path to a place."""
    found = []
    for robot in robots:
        try:
            robot.compute_path_to(place)
        except GoalFailed:
            continue
        found.append(robot.robot)
    return found


def test_a_controller_finds_out_which_robots_can_get_there() -> None:
    """All three reach the terrace; none reaches a place behind a closed lane."""
    closed = {"faults.+": {"type": "lane_closed", "lane": ["corridor_west", "corridor_east"], "at": 0}}
    for changes, expected in (({}, ["mocha", "latte", "chai"]), (closed, [])):
        with simulation("cafe", changes=changes) as run:
            run.client.sleep(1)

            assert able([run.commander(name) for name in ("mocha", "latte", "chai")], "terrace") == expected


def test_an_impossible_goal_fails_with_a_reason() -> None:
    """The goal fails at once, and the robot does not drive."""
    closed = {"faults.+": {"type": "lane_closed", "lane": ["corridor_west", "corridor_east"], "at": 0}}
    with simulation("cafe", changes=closed) as run:
        run.client.sleep(1)
        with pytest.raises(GoalFailed, match=r"lane_closed.*\(208\)"):
            run.commander("mocha").navigate_to("table_3")

        assert run.now == 1.0

"""Several robots of different kinds in one world, each with its own namespace and interface.

Asked in https://github.com/ros-navigation/navigation2/pull/4992: Nav2's loopback simulation has one robot, and what
lies above the controller is to be tried.
"""

import json

from hmrsim.testing import simulation


def test_each_robot_has_its_own_actions_and_topics() -> None:
    """Some have no claw, and so no pickup."""
    with simulation("hospital") as run:
        robots = {robot["name"]: robot for robot in run.client.info()["robots"]}

        assert len(robots) == 8
        assert "pickup" in robots["wall_e"]["actions"]
        assert "pickup" not in robots["auto"]["actions"]
        for name in robots:
            odometry = json.loads(run.client.get(f"hmrsim/{name}/odom"))
            assert odometry["child_frame_id"] == f"{name}/base_link"

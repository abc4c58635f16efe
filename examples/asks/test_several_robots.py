"""One world has several robots of different types, each with its own namespace and interface.

Asked in https://github.com/ros-navigation/navigation2/pull/4992: Nav2's loopback simulator has one robot, and the
layers above the controller need a test.
"""

import json

from hmrsim.testing import simulation


def test_each_robot_has_its_own_actions_and_topics() -> None:
    """Robots without a claw have no pickup action."""
    with simulation("hospital") as run:
        robots = {robot["name"]: robot for robot in run.client.info()["robots"]}

        assert len(robots) == 8
        assert "pickup" in robots["wall_e"]["actions"]
        assert "pickup" not in robots["auto"]["actions"]
        for name in robots:
            odometry = json.loads(run.client.get(f"hmrsim/{name}/odom"))
            assert odometry["child_frame_id"] == f"{name}/base_link"

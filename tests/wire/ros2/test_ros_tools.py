"""ROS tools on the wire: nav2_simple_commander and py_trees_ros."""

from __future__ import annotations

from concurrent.futures import TimeoutError as NotYet

import pytest

from hmrsim.interfaces.geometry_msgs import PoseWithCovarianceStamped
from hmrsim_zenoh.ros2.codec.types import message_type
from tests.patience import PATIENCE
from tests.wire.ros2.client import CANCELED, SUCCEEDED, get_state, goal_to

ACTIVE = {"id": 3, "label": "active"}


class BasicNavigator:
    """Makes the requests of nav2_simple_commander's BasicNavigator, in its order and with its waits."""

    def __init__(self, ros, namespace):
        self._ros, self._namespace = ros, namespace
        self._pose = ros.subscribe(
            f"/{namespace}/amcl_pose", message_type(PoseWithCovarianceStamped, ros.distro), latched=True
        )
        self._drive = ros.action(f"/{namespace}/navigate_to_pose")
        self.backup = ros.action(f"/{namespace}/backup", "back_up")

    def wait_until_nav2_active(self):
        """Wait for localization, for the initial pose, and for the navigator; return states and pose."""
        localization = self._state_of("amcl")
        pose = self._pose.next()
        return localization, pose, self._state_of("bt_navigator")

    def _state_of(self, node):
        service = self._ros.service(f"/{self._namespace}/{node}/get_state", get_state(self._ros.distro))
        return service.wait().call(b"\0\1\0\0\0")["current_state"]

    def go_to_pose(self, x, y):
        """Send the goal, and request its result at once."""
        self.goal = self._drive.wait().send(goal_to(x, y))
        self._result = self.goal.begin_result()
        return self.goal.accepted

    def is_task_complete(self):
        """Wait a tenth of a second for the result."""
        try:
            self._result.result(0.1)
        except NotYet:
            return False
        return True

    @property
    def feedback(self):
        return self._drive.feedback_of(self.goal.id)[-1:]

    @property
    def status(self):
        return self._result.result(0)["status"]


@pytest.fixture(params=["jazzy", "kilted", "lyrical", "rolling"])
def navigator(request, serve, ros):
    """Return Nav2's client of one robot, for each distribution; a lane takes half a second."""
    return BasicNavigator(ros(serve(real_time_factor=8.0), request.param), "wall_e")


def test_nav2_is_active(navigator):
    """The robot's pose is known although it does not move."""
    localization, pose, navigation = navigator.wait_until_nav2_active()

    assert (ACTIVE, ACTIVE) == (localization, navigation)
    assert ("map", 1.0, 2.0) == (
        pose["header"]["frame_id"],
        pose["pose"]["pose"]["position"]["x"],
        pose["pose"]["pose"]["position"]["y"],
    )


def test_nav2s_client_drives_and_gets_feedback(navigator):
    assert navigator.go_to_pose(9, 2)
    looks = 0
    while not navigator.is_task_complete():
        looks += 1
    assert 0 < looks
    assert SUCCEEDED == navigator.status
    assert 0 < len(navigator.feedback)


def test_nav2s_client_stops_the_robot_on_its_route(navigator):
    navigator.go_to_pose(9, 2)
    navigator.goal.client.wait_for_feedback(navigator.goal.id)
    code, ended = navigator.goal.cancel()
    while not navigator.is_task_complete():
        pass

    assert (0, [navigator.goal.id]) == (code, ended)
    assert CANCELED == navigator.status


def test_nav2s_client_backs_up(navigator):
    """Nav2's name is not that of the type."""
    status, _ = navigator.backup.wait().do({"target": {"x": -0.5}, "speed": 0.5})

    assert SUCCEEDED == status


def test_behaviour_tree_of_ros_drives(serve, ros):
    """py_trees_ros waits for the server, sends, and checks for result and feedback at each tick."""
    drive = ros(serve(real_time_factor=8.0)).action("/wall_e/navigate_to_pose").wait()
    goal = drive.send(goal_to(9, 2))
    result = goal.begin_result()
    remaining = [round(drive.wait_for_feedback(goal.id)["distance_remaining"], 3)]
    result.result(PATIENCE)
    remaining += [round(one["distance_remaining"], 3) for one in drive.feedback_of(goal.id)]

    assert goal.accepted
    assert SUCCEEDED == result.result(PATIENCE)["status"]
    assert 0 < remaining[0] < 8
    assert sorted(remaining, reverse=True) == remaining


def test_behaviour_tree_of_ros_is_interrupted(serve, ros):
    """It cancels by id and time of acceptance, and sends the next goal without waiting."""
    drive = ros(serve(real_time_factor=1.0)).action("/wall_e/navigate_to_pose").wait()
    first = drive.send(goal_to(9, 2))
    code, ended = drive.cancel(first.id, (0, 0))
    second = drive.send(goal_to(1, 2))

    assert (0, [first.id], True) == (code, ended, second.accepted)
    assert (CANCELED, SUCCEEDED) == (first.result()[0], second.result()[0])

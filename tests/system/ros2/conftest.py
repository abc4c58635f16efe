"""A served world and ROS nodes, as in the tests of the wire."""

from tests.wire.ros2.conftest import fast, live, ros, serve  # noqa: F401

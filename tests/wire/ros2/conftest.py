"""The small world, served to ROS and JSON from the test's process, and ROS nodes that use it."""

from __future__ import annotations

import contextlib

import pytest

from hmrsim_zenoh.ros2.wires import RmwZenoh
from tests.served_world import served_world
from tests.wire.ros2.client import RosClient


@pytest.fixture
def serve():
    """Return the function that serves the small world and returns the options of a JSON client."""
    with contextlib.ExitStack() as stack:
        yield lambda **settings: stack.enter_context(served_world(**{"wires": (RmwZenoh(),)} | settings))


@pytest.fixture
def fast(serve):
    """Return the options of a client of the small world, where goals take no wall time."""
    return serve(real_time_factor=0)


@pytest.fixture
def live(serve):
    """Return the options of a client of the small world, in real time."""
    return serve(real_time_factor=1.0)


@pytest.fixture
def ros():
    """Return the function that makes a ROS node, of a distribution."""
    with contextlib.ExitStack() as stack:
        yield lambda options, distro="jazzy", **how: stack.enter_context(RosClient(options.connect[0], distro, **how))

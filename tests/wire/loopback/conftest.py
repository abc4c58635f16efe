"""A small world that is served within the process."""

from __future__ import annotations

import pytest

from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.world.model import World
from hmrsim_zenoh import Client
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

WORLD = {
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [["a", "b"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "a", "planner": "external"}},
}


def goal_to(x, y):
    return NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": x, "y": y}}}})


@pytest.fixture
def world():
    return World.model_validate(WORLD)


@pytest.fixture
def host(world):
    with LoopbackHost(world) as host:
        yield host


@pytest.fixture
def client(host):
    with Client(session=host.open_session()) as client:
        yield client

"""A small world, served within the process."""

from __future__ import annotations

import pytest
import yaml

from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.world_checks import load_world
from hmrsim_zenoh import Client
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost

WORLD = {
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [["a", "b"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "a", "planner": "external"}},
}


def goal_to(x, y):
    """Return a goal at a place."""
    return NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": x, "y": y}}}})


@pytest.fixture
def loaded(tmp_path):
    """Return the world."""
    path = tmp_path / "world.yaml"
    path.write_text(yaml.safe_dump(WORLD))
    return load_world(path)


@pytest.fixture
def host(loaded):
    """Serve the world."""
    with LoopbackHost(loaded) as host:
        yield host


@pytest.fixture
def client(host):
    """Return a client."""
    with Client(session=host.open_session()) as client:
        yield client

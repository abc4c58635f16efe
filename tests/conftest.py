"""What many tests share: markers, how hypothesis runs, simulations of a small world."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from tests import profiles
from tests.simulation import Run, simulate

# Processes that tests start keep what they compile, or each of them would compile it anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# A shell has what it starts with `&` ignore Ctrl-C; children would inherit that, and could not be tried with it.
signal.signal(signal.SIGINT, signal.default_int_handler)

profiles.load()

KINDS = ("unit", "wire", "system", "browser")
FOLDERS = {
    "browser": "browser",
    "system": "system",
    **dict.fromkeys(("recording", "ros2", "view", "wire", "zenoh"), "wire"),
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test by the folder that it is in: what it needs."""
    for item in items:
        folder = item.path.relative_to(Path(__file__).parent).parts[0]
        kind = FOLDERS.get(folder, "unit")
        if not any(map(item.get_closest_marker, KINDS)):
            item.add_marker(kind)


@pytest.fixture(autouse=True)
def _own_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the settings of the environment away."""
    for name in list(os.environ):
        if name.startswith("HMRSIM_"):
            monkeypatch.delenv(name)


@pytest.fixture
def run() -> Run:
    """Return a simulation of the small world in which everything is listened to."""
    return simulate()


@pytest.fixture
def make_run() -> object:
    """Return the function that makes simulations, for other worlds and settings."""
    return simulate

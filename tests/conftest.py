"""What many tests share: markers, how hypothesis runs, simulations of a small world."""

from __future__ import annotations

import os
import signal

import pytest

from tests import profiles
from tests.paths import TESTS
from tests.simulation import Run, simulate

# Processes that tests start keep what they compile, or each of them would compile it anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# A shell has what it starts with `&` ignore Ctrl-C; children would inherit that, and could not be tried with it.
signal.signal(signal.SIGINT, signal.default_int_handler)

profiles.load()

KINDS = ("unit", "wire", "system", "browser")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test with what it needs, by the folder that it is in."""
    for item in items:
        folder = item.path.relative_to(TESTS).parts[0]
        item.add_marker(folder if folder in KINDS else "system")


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

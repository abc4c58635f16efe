"""What many tests share: simulations of a small world, and how hypothesis runs."""

from __future__ import annotations

import os

import pytest
from hypothesis import HealthCheck, settings

from tests.simulation import Run, simulate

# Processes that tests start keep what they compile, or each of them would compile it anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Examples are counted, not timed: a busy machine must not fail a test.
settings.register_profile("hmrsim", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("hmrsim")


@pytest.fixture(autouse=True)
def _own_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep the settings of whoever runs the tests away."""
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

"""Shared fixtures and hooks: markers, hypothesis profiles, and simulations of a small world."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator

import pytest
from hypothesis import is_hypothesis_test

from tests import profiles
from tests.paths import TESTS
from tests.simulation import Run, simulate

# Processes that tests start share compiled bytecode instead of compiling it again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# A process that a shell starts with `&` ignores Ctrl-C, and its children would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

profiles.load()

KINDS = ("system", "browser", "wire", "unit")
"""Folders of tests in the order in which they run; with the longest first, parallel workers finish together."""

UNCOVERED = ("system", "browser")
"""Kinds that mostly run in subprocesses, which coverage does not see, so that measuring only costs time."""


@pytest.hookimpl(wrapper=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """Return one worker more than there are processors, since many tests wait for subprocesses."""
    return (yield) + 1


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test with the kind of its folder, and run the slowest kinds first."""
    kinds = {item: _kind(item) for item in items}
    for item, kind in kinds.items():
        item.add_marker(kind)
        # Tests that repeat the same lines many times take four times as long under coverage.
        if kind in UNCOVERED or is_hypothesis_test(getattr(item, "function", None)):
            item.add_marker("uncovered")
    items.sort(key=lambda item: KINDS.index(kinds[item]))


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Run uncovered tests without tracers; pytest-cov's no_cover leaves one of the two that a worker has."""
    if item.get_closest_marker("uncovered") is None:
        return (yield)
    tracer, of_threads = sys.gettrace(), threading.gettrace()
    sys.settrace(None)
    threading.settrace(None)
    try:
        return (yield)
    finally:
        sys.settrace(tracer)
        threading.settrace(of_threads)


def _kind(item: pytest.Item) -> str:
    if not item.path.is_relative_to(TESTS):
        return "unit"  # an example, which runs in the test process
    folder = item.path.relative_to(TESTS).parts[0]
    return folder if folder in KINDS else "system"


@pytest.fixture(autouse=True)
def _own_settings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Unset all HMRSIM_ variables of the environment."""
    for name in list(os.environ):
        if name.startswith("HMRSIM_"):
            monkeypatch.delenv(name)


@pytest.fixture
def collect() -> Generator[Callable[..., list[object]], None, None]:
    """Return what collects the garbage of this test, not of the process, and returns its living objects of a type."""

    def living(kind: type | None = None) -> list[object]:
        gc.collect()
        return [each for each in gc.get_objects() if type(each) is kind]

    gc.freeze()
    yield living
    gc.unfreeze()


@pytest.fixture
def run() -> Run:
    """Return a simulation of the small world with subscribers of all topics."""
    return simulate()


@pytest.fixture
def make_run() -> object:
    """Return the function that makes simulations, for other worlds and settings."""
    return simulate

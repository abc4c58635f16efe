"""What many tests share: markers, how hypothesis runs, simulations of a small world."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Generator

import pytest
from hypothesis import is_hypothesis_test

from tests import profiles
from tests.paths import TESTS
from tests.simulation import Run, simulate

# Processes that tests start keep what they compile, or each of them would compile it anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# A shell has what it starts with `&` ignore Ctrl-C; children would inherit that, and could not be tried with it.
signal.signal(signal.SIGINT, signal.default_int_handler)

profiles.load()

KINDS = ("system", "browser", "wire", "unit")
"""Folders of tests, in the order in which they run: workers that share the files are done together if the longest come
first."""

UNCOVERED = ("system", "browser")
"""Kinds whose work is mostly done in processes that coverage does not see: measuring them only costs time."""


@pytest.hookimpl(wrapper=True)
def pytest_xdist_auto_num_workers() -> Generator[None, int, int]:
    """Return one worker more than xdist counts processors, as many tests wait for processes that they have started."""
    return (yield) + 1


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test with what it needs, by the folder that it is in, and run what takes longest first."""
    kinds = {item: _kind(item) for item in items}
    for item, kind in kinds.items():
        item.add_marker(kind)
        # What repeats the same lines many times takes four times as long when they are counted.
        if kind in UNCOVERED or is_hypothesis_test(getattr(item, "function", None)):
            item.add_marker("uncovered")
    items.sort(key=lambda item: KINDS.index(kinds[item]))


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Run what is not to be covered without tracers; pytest-cov's no_cover leaves one of the two that a worker has."""
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
        return "unit"  # an example, which runs in the test's own process
    folder = item.path.relative_to(TESTS).parts[0]
    return folder if folder in KINDS else "system"


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

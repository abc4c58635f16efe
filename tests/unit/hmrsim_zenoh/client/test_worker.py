"""The thread of deferred calls."""

from __future__ import annotations

import threading

import pytest

from hmrsim_zenoh.client.worker import Worker


@pytest.fixture
def blocked():
    """Return a worker that is in a call until the event is set, and the event."""
    worker, begun, release = Worker("test", most=3), threading.Event(), threading.Event()

    def block():
        begun.set()
        release.wait()

    worker.after(0.0, block)
    begun.wait()
    yield worker, release
    release.set()
    worker.close()


def test_calls_are_made_in_the_order_of_their_times(blocked):
    worker, release = blocked
    called = []
    for delay, name in ((0.02, "late"), (0.0, "first"), (0.0, "second")):
        worker.after(delay, lambda name=name: called.append(name))
    release.set()
    worker.settle()

    assert ["first", "second", "late"] == called


def test_the_first_of_too_many_calls_are_dropped(blocked):
    worker, release = blocked
    called = []
    for number in range(5):
        worker.after(0.0, lambda number=number: called.append(number))
    release.set()
    worker.settle()

    assert [2, 3, 4] == called


def test_an_error_is_logged_and_the_next_call_is_made(blocked, caplog):
    worker, release = blocked
    called = []
    worker.after(0.0, lambda: 1 / 0)
    worker.after(0.0, lambda: called.append(True))
    release.set()
    worker.settle()

    assert [True] == called
    assert "ZeroDivisionError" in caplog.text


def test_a_closed_worker_calls_nothing_further():
    worker, called = Worker("test", at_once=False), []
    worker.close()
    worker.after(0.0, lambda: called.append(True))
    worker.settle()

    assert [] == called

"""The event schedule: abandoned events, and events that bypass it."""

from __future__ import annotations

import math
from collections import deque
from functools import partial
from typing import TYPE_CHECKING

import pytest

from hmrsim.engine import environment
from hmrsim.engine.environment import Environment
from hmrsim.errors import EndlessInstant

if TYPE_CHECKING:
    import simpy


def test_abandoned_events_are_freed_early():
    """A client that cancels long goals one after another must not fill the memory."""
    env = Environment()
    rung = []
    for number in range(1000):
        env.cancel(env.alarm(1e9 + number, lambda: rung.append("canceled")))
        if number % 100 == 0:
            env.alarm(float(1000 - number), lambda at=1000 - number: rung.append(at))
        env.abandon(env.timeout(1e8))

    assert 250 >= len(env._queue)
    assert 100.0 == env.peek()
    env.horizon = 1e10
    while env.process_events(1000):
        pass
    assert sorted(rung) == rung
    assert 10 == len(rung)
    assert math.inf == env.peek()
    assert env.idle


def _told(env: Environment, *, with_other: bool) -> list[str]:
    """Return what happens at 1 s when an event succeeds there, before another timeout of that instant or alone."""
    told: list[str] = []
    done = env.event()
    done.callbacks.append(lambda _event: told.append("done"))

    def succeed(_event: simpy.Event) -> None:
        env.succeed(done)
        told.append("succeeded")

    env.timeout(1.0).callbacks.append(succeed)
    if with_other:
        env.timeout(1.0).callbacks.append(lambda _event: told.append("other"))
    while env.process_events(10):
        pass
    return told


@pytest.mark.parametrize(
    ("with_other", "order"), [(False, ["done", "succeeded"]), (True, ["succeeded", "other", "done"])]
)
def test_an_event_happens_at_once_unless_another_is_due(with_other, order):
    assert order == _told(Environment(), with_other=with_other)


def test_a_process_that_no_other_awaits_ends_without_an_event():
    env = Environment()

    def work():
        yield env.timeout(1.0)
        return 7

    def late(process):
        yield env.timeout(2.0)
        got.append((yield process))

    got: list[int] = []
    worker = env.process(work())
    env.process(late(worker))
    taken = env.process_events(100)

    assert [7] == got
    assert worker.processed
    # Two begin, and two timeouts pass.
    assert 4 == taken


def test_a_process_that_another_awaits_ends_in_an_event():
    env = Environment()

    def work():
        yield env.timeout(1.0)

    def wait(process):
        yield process
        ended.append(env.now)

    ended: list[float] = []
    env.process(wait(env.process(work())))
    env.process_events(100)

    assert [1.0] == ended


def test_an_endless_instant_is_an_error_that_names_the_repetition(monkeypatch):
    monkeypatch.setattr(environment, "MOST_AT_ONCE", 5_000)
    env = Environment()

    def ping():
        while True:
            yield env.timeout(1e-300)

    def clock():
        while True:
            yield env.timeout(1e-3)

    env.process(clock())
    assert 1_000 == env.process_events(1_000)
    env.process(ping())
    with pytest.raises(
        EndlessInstant, match=r"time stands still at 0.999 s: more than 5,000.*ping \(.*\) \(100 of 100"
    ):
        deque(iter(partial(env.process_events, 1_000), 0), maxlen=0)


def test_many_events_over_many_instants_are_no_error(monkeypatch):
    monkeypatch.setattr(environment, "MOST_AT_ONCE", 5_000)
    env = Environment()
    for number in range(9_000):
        env.timeout(number // 3_000)

    assert [1_000] * 9 == [env.process_events(1_000) for _ in range(9)]

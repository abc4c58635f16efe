"""The schedule: what is abandoned in it."""

from __future__ import annotations

import math

from hmrsim.engine.environment import Environment


def test_abandoned_events_are_not_kept_until_their_time():
    """A client that cancels one long goal after the other does not fill the memory; the others ring in their order."""
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

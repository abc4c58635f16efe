"""The timeout of waits that make no progress."""

from __future__ import annotations

from typing import NamedTuple

from hmrsim.engine.environment import Environment
from hmrsim.traffic.rules import WaitTimeout


class FakeWait(NamedTuple):
    """A wait for which only its begin matters."""

    robot: str
    since: float


def test_a_wait_that_begins_as_another_one_expires_has_its_own_time():
    env, waits, expired = Environment(), [], []

    def expire(wait):
        expired.append((wait.robot, env.now))
        waits.remove(wait)
        if wait.robot == "ann":
            # As a vehicle that gives up makes another one step back at the same instant.
            timeout.stop()
            begin("bob")

    def begin(robot):
        waits.append(FakeWait(robot, env.now))
        timeout.begin(waits[-1])

    timeout = WaitTimeout(env, 60.0, since=lambda wait: wait.since if wait in waits else None, expired=expire)
    begin("ann")
    env.run(until=100.0)
    begin("cid")
    env.run(until=1000.0)

    assert [("ann", 60.0), ("bob", 120.0), ("cid", 160.0)] == expired

"""The presence of the simulator."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.client import link

GRACE = 5.0
COMES, GOES = True, False


class Connection:
    """A connection that knows only whether the simulator is alive; a question about it is never answered.

    Attributes:
        now: The time of the clock, in seconds.
        gone: How often the client has given up.
        later: The deferred calls, with their delays.
        tell: Reports that the simulator is there, or gone.
    """

    def __init__(self):
        self.now = 0.0
        self.gone = 0
        self.later = []
        self.presence = link.Presence(self, self, grace=GRACE, on_gone=self._give_up)

    def _give_up(self):
        self.gone += 1

    def follow(self, on_change):
        """Keep the function for later."""
        self.tell = on_change

    def after(self, delay, call):
        """Keep the call for later."""
        self.later.append((delay, call))


@pytest.fixture
def connection(monkeypatch):
    """Return a connection whose client follows the simulator."""
    one = Connection()
    monkeypatch.setattr(link.time, "monotonic", lambda: one.now)
    one.presence.start()
    return one


def test_the_grace_period_begins_when_the_simulator_goes(connection):
    """The grace period does not begin with the client, which may be old."""
    connection.tell(COMES)
    connection.now = 100.0
    connection.tell(GOES)

    assert [(GRACE, connection.presence._look_again)] == connection.later
    for at, gone in ((100.0, False), (104.9, False), (105.0, True)):
        connection.now = at
        assert gone is connection.presence.gone


def test_a_simulator_that_never_came_is_gone_after_the_grace_period(connection):
    for at, gone in ((0.0, False), (4.9, False), (5.0, True)):
        connection.now = at
        assert gone is connection.presence.gone
    assert not connection.presence.seen


def test_a_simulator_that_is_there_is_not_gone(connection):
    connection.tell(COMES)
    connection.now = 50.0
    connection.tell(GOES)
    connection.tell(COMES)
    connection.now = 100.0

    assert (True, True, False) == (connection.presence.is_there, connection.presence.seen, connection.presence.gone)

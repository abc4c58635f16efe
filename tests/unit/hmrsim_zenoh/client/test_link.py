"""The presence of the simulator, by its liveliness token."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import zenoh

from hmrsim_zenoh.client import link

GRACE = 5.0
COMES, GOES = zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE


class Session:
    """A session that knows nothing but a token; a query for it is never answered.

    Attributes:
        now: The time of the clock, in seconds.
        gone: How often the client has given up.
        later: The deferred calls, with their delays.
    """

    def __init__(self):
        self.now = 0.0
        self.gone = 0
        self.later = []
        self._handler = None
        self.presence = link.Presence(self, "token", self, grace=GRACE, on_gone=self._give_up)

    def _give_up(self):
        self.gone += 1

    def liveliness(self):
        """Return the liveliness of the session."""
        return self

    def declare_subscriber(self, _token, handler, *, history):
        """Keep the subscriber's handler."""
        assert history
        self._handler = handler

    def get(self, _token, _handler, *, timeout):
        """Leave the query without an answer."""
        assert timeout == GRACE

    def after(self, delay, call):
        """Keep the call for later."""
        self.later.append((delay, call))

    def tell(self, kind):
        """Declare or undeclare the token."""
        self._handler(SimpleNamespace(kind=kind))


@pytest.fixture
def session(monkeypatch):
    """Return a session whose client follows the token."""
    one = Session()
    monkeypatch.setattr(link.time, "monotonic", lambda: one.now)
    one.presence.start()
    return one


def test_the_grace_period_begins_when_the_token_goes(session):
    """The grace period does not begin with the client, which may be old."""
    session.tell(COMES)
    session.now = 100.0
    session.tell(GOES)

    assert [(GRACE, session.presence._look_again)] == session.later
    for at, gone in ((100.0, False), (104.9, False), (105.0, True)):
        session.now = at
        assert gone is session.presence.gone


def test_a_token_that_never_came_is_gone_after_the_grace_period(session):
    for at, gone in ((0.0, False), (4.9, False), (5.0, True)):
        session.now = at
        assert gone is session.presence.gone
    assert not session.presence.seen


def test_a_token_that_is_there_is_not_gone(session):
    session.tell(COMES)
    session.now = 50.0
    session.tell(GOES)
    session.tell(COMES)
    session.now = 100.0

    assert (True, True, False) == (session.presence.is_there, session.presence.seen, session.presence.gone)

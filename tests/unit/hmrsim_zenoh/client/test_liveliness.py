"""The simulator's token as a client sees it come and go."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import zenoh

from hmrsim_zenoh.client import liveliness
from hmrsim_zenoh.client.liveliness import Presence

GRACE = 5.0
COMES, GOES = zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE


class Session:
    """A session that knows nothing but a token; a query for it is never answered.

    Attributes:
        now: What the clock shows, in seconds.
        gone: How often the client has given up.
        later: What it has put off, with the delays.
    """

    def __init__(self):
        self.now = 0.0
        self.gone = 0
        self.later = []
        self._handler = None
        self.presence = Presence(self, "token", self, grace=GRACE, on_gone=self._give_up)

    def _give_up(self):
        self.gone += 1

    def liveliness(self):
        """Return what the token is declared on."""
        return self

    def declare_subscriber(self, _token, handler, *, history):
        """Take note of who wants to hear of it."""
        assert history
        self._handler = handler

    def get(self, _token, _handler, *, timeout):
        """Answer nothing."""
        assert timeout == GRACE

    def after(self, delay, call):
        """Take note of what is to be done later."""
        self.later.append((delay, call))

    def tell(self, kind):
        """Let the token come or go."""
        self._handler(SimpleNamespace(kind=kind))


@pytest.fixture
def session(monkeypatch):
    """Return a session whose client has begun to look for the token."""
    one = Session()
    monkeypatch.setattr(liveliness.time, "monotonic", lambda: one.now)
    one.presence.start()
    return one


def test_the_grace_period_begins_when_the_token_goes(session):
    """Not when the client began, which may have been long ago."""
    session.tell(COMES)
    session.now = 100.0
    session.tell(GOES)

    assert [(GRACE, session.presence._look_again)] == session.later
    for at, gone in ((100.0, False), (104.9, False), (105.0, True)):
        session.now = at
        assert gone is session.presence.gone


def test_a_token_that_never_came_is_gone_after_the_grace_period(session):
    """Counted from the start."""
    for at, gone in ((0.0, False), (4.9, False), (5.0, True)):
        session.now = at
        assert gone is session.presence.gone
    assert not session.presence.seen


def test_a_token_that_is_there_is_not_gone(session):
    """However long it has been there, or was gone before."""
    session.tell(COMES)
    session.now = 50.0
    session.tell(GOES)
    session.tell(COMES)
    session.now = 100.0

    assert (True, True, False) == (session.presence.is_there, session.presence.seen, session.presence.gone)

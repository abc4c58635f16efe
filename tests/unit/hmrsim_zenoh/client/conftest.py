"""A client on a fake connection, whose other end is the test."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.client import link
from hmrsim_zenoh.client.client import Client
from tests.fake_connection import FakeConnection


@pytest.fixture
def connection(monkeypatch):
    """Return a connection; its `wall` is the time of the clients' wall clock, in seconds."""
    one = FakeConnection()
    one.wall = 0.0
    monkeypatch.setattr(link.time, "monotonic", lambda: one.wall)
    return one


@pytest.fixture
def client(connection):
    """Return a client that gives a goal 2 s to be accepted, and takes no part in lockstep."""
    with Client(session=connection, clock="realtime", acknowledge_timeout=2.0, grace=5.0) as client:
        yield client


@pytest.fixture
def lockstep_client(connection):
    """Return a client that takes part in lockstep."""
    with Client(session=connection, clock="lockstep") as client:
        yield client

"""A page's server with a simulator behind it."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.wire.session import open_client
from tests.listened import Listened
from tests.served_world import served_world
from tests.wire.view.pages import opened, viewed


@pytest.fixture(scope="module")
def simulator():
    """Return the options of a client of the small world."""
    with served_world() as options:
        yield options


@pytest.fixture
def server(simulator):
    with viewed(simulator) as server:
        yield server


@pytest.fixture
def page(server):
    with opened(server.url) as page:
        yield page


@pytest.fixture
def open_page(server):
    """Return the function that opens further pages."""
    return lambda: opened(server.url)


@pytest.fixture
def session(simulator):
    with open_client(simulator) as session:
        yield session


@pytest.fixture
def wait_for_listener(session):
    """Return the function that waits until a key has a subscriber, or has none."""
    listened = Listened(session)
    return listened.wait

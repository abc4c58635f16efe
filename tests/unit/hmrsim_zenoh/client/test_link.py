"""The presence of the simulator."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.errors import SimulatorGone, SimulatorNotFound

COMES, GOES = True, False


@pytest.fixture
def tell(connection, client):
    """Return the function that reports that the simulator comes or goes; at first it is not there."""
    connection.vanish()
    client._link.follow()
    return connection.followers[0]


def test_the_grace_period_begins_when_the_simulator_goes(connection, client, tell):
    """The grace period does not begin with the client, which may be old."""
    tell(COMES)
    connection.wall = 100.0
    tell(GOES)

    assert [5.0] == [delay for delay, _ in connection.later]
    for connection.wall, gone in ((100.0, False), (104.9, False), (105.0, True)):
        assert gone is isinstance(client.absence, SimulatorGone)


def test_a_simulator_that_never_came_is_not_found_after_the_grace_period(connection, client, tell):  # noqa: ARG001
    for connection.wall, gone in ((0.0, False), (4.9, False), (5.0, True)):
        assert gone is isinstance(client.absence, SimulatorNotFound)


def test_a_simulator_that_is_back_is_not_gone(connection, client, tell):
    tell(COMES)
    connection.wall = 50.0
    tell(GOES)
    tell(COMES)
    connection.wall = 100.0

    assert (True, None) == (client.alive, client.absence)

"""The pending result requests of ROS clients."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import GetResult
from hmrsim_zenoh.ros2.requests.requests import MAX_ANONYMOUS, MAX_PER_CLIENT, PendingResults


class Pending:
    """A request of a client, whose id may be empty."""

    def __init__(self, client):
        self.client = client


def add(results, client, goals, each):
    """Request each goal's result several times; return how often an earlier request was dropped."""
    made_room = 0
    for goal in range(goals):
        for _ in range(each):
            pending = Pending(client)
            made_room += len(results.add(pending, GetResult("eve", "wait", f"{goal:032x}", pending)))
    return made_room


@pytest.mark.parametrize(
    ("client", "goals", "each", "made_room"),
    [
        ("", 3, MAX_ANONYMOUS, 0),
        ("", 1, MAX_ANONYMOUS + 2, 2),
        ("ab", 1, MAX_PER_CLIENT + 2, 2),
        ("ab", 2, MAX_PER_CLIENT // 2 + 1, 2),
    ],
    ids=["several goals", "one goal", "one client", "one client with several goals"],
)
def test_requests_are_limited_for_each_client_or_goal(client, goals, each, made_room):
    """Requests of clients without an id are limited for each goal."""
    assert made_room == add(PendingResults(), client, goals, each)


def test_a_client_that_goes_takes_its_requests_along():
    """There is one command for each goal, with all requests of that client."""
    results = PendingResults()
    add(results, "ab", 2, 3)
    add(results, "cd", 1, 1)

    assert [3, 3] == [len(stop.reply_tos) for stop in results.gone("ab")]
    assert [] == results.gone("ab")
    assert [1] == [len(stop.reply_tos) for stop in results.gone("cd")]

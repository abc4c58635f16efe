"""Requests of ROS clients for results that have not been answered."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import GetResult
from hmrsim_zenoh.ros2.requests.requests import MAX_ANONYMOUS, MAX_PER_CLIENT, PendingResults


class Pending:
    """A request of a client; of one without an id if that is empty."""

    def __init__(self, client):
        self.client = client


def add(results, client, goals, each):
    """Ask so often for the result of each of some goals; return how often an earlier request made room."""
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
    """Those of clients without an id for each goal, as they can't be told apart."""
    assert made_room == add(PendingResults(), client, goals, each)


def test_a_client_that_goes_takes_its_requests_along():
    """One command for each goal, with all its requests; those of others stay."""
    results = PendingResults()
    add(results, "ab", 2, 3)
    add(results, "cd", 1, 1)

    assert [3, 3] == [len(stop.reply_tos) for stop in results.gone("ab")]
    assert [] == results.gone("ab")
    assert [1] == [len(stop.reply_tos) for stop in results.gone("cd")]

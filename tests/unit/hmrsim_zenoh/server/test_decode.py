"""The keys of queries are parsed and declared once."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from hmrsim.actions import registry as actions
from hmrsim.protocol.commands import Read
from hmrsim.services import registry as services
from hmrsim_zenoh.server.decode import Requests
from hmrsim_zenoh.wire.keys import Keys


@dataclass
class Query:
    """A query without a payload."""

    key_expr: str
    payload: None = None
    dropped: bool = False
    errors: list[bytes] = field(default_factory=list)

    def drop(self) -> None:
        self.dropped = True

    def reply_err(self, payload: bytes, *, encoding: str) -> None:
        assert encoding == "application/json"
        self.errors.append(payload)


class Publisher:
    """Notes the keys that are declared."""

    def __init__(self) -> None:
        self.declared: list[str] = []

    def declare(self, key: str) -> None:
        self.declared.append(key)

    def timestamp(self) -> None:
        """Return no timestamp."""


@pytest.fixture
def publisher() -> Publisher:
    """Return the publisher of the requests."""
    return Publisher()


@pytest.fixture
def requests(publisher: Publisher) -> Requests:
    """Return the requests to a simulator of one robot."""
    return Requests(
        Keys(),
        actions=actions(),
        serves={"wall_e": ["wait"]},
        fixed={},
        services=services(),
        max_payload=1000,
        publisher=publisher,
    )


def test_the_key_of_a_robots_action_is_declared_for_its_first_query(requests, publisher):
    key = "hmrsim/wall_e/wait/_action/status"

    found = [requests.decode(Query(key)) for _ in range(3)]

    assert [key] == publisher.declared
    assert [["wall_e", "wait"]] * 3 == [[read.robot, read.action] for [read] in found if isinstance(read, Read)]


@pytest.mark.parametrize("robot", ["eve", "_planner"])
def test_keys_of_others_are_not_declared(requests, publisher, robot):
    """Anybody may query them, with a new name each time."""
    requests.decode(Query(f"hmrsim/{robot}/wait/_action/status"))

    assert publisher.declared == []


def test_each_query_on_an_unknown_key_is_refused(requests, publisher):
    queries = [Query("hmrsim/wall_e/no_topic") for _ in range(2)]
    for query in queries:
        requests.decode(query)

    assert [1, 1] == [len(query.errors) for query in queries]
    assert publisher.declared == []


def test_the_wakeup_is_no_command(requests):
    query = Query(Keys().wakeup_key())

    assert requests.decode(query) == []
    assert query.dropped

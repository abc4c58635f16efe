"""A client without a network: each goal is accepted, fed and ended by the test itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
from py_trees.blackboard import Blackboard

from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.connection import ReadInfo
from tests.fake_connection import FakeConnection

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hmrsim.interfaces.message import Message

INFO = {
    "robots": [
        {"name": "wall_e", "actions": ["navigate_to_pose", "pickup", "place", "wait"]},
        {"name": "eve", "actions": ["navigate_to_pose"]},
    ],
    "aliases": {"navigate_to_pose/wall_e": "wall_e/navigate_to_pose"},
}


class FakeSession(FakeConnection):
    """Declares what a controller publishes, without subscribers."""

    matching_status = SimpleNamespace(matching=False)

    def declare_queryable(self, *_args: object, **_options: object) -> FakeSession:
        """Return what can be undeclared."""
        return self

    declare_publisher = declare_matching_listener = declare_queryable

    def undeclare(self) -> None:
        """Undeclare nothing: the publisher is a stand-in."""


class FakeClient(Client):
    """A client of two robots, whose goals wait for the test, and whose time moves by itself.

    Attributes:
        goals: The goals that it has sent, in order.
        refuses: The error with which sending a goal fails; None if it doesn't.
    """

    def __init__(self) -> None:
        session: Any = FakeSession()
        session.script[ReadInfo] = [INFO]
        session.ordered = True
        session.clock(0.0)
        super().__init__(session=session, clock="realtime")
        self.goals = session.goals
        self.refuses: Exception | None = None

    @property
    def lockstep(self) -> None:
        if self.refuses is not None:
            raise self.refuses


class FakeTopics:
    """The topics of a robot, with messages that the test sets.

    Attributes:
        messages: The latest of each topic.
        asks: Whether messages are asked for.
        watched: The topics that are watched, each with its robot.
        stops: Whether time stops for conditions, as in lockstep.
    """

    def __init__(self) -> None:
        self.messages: dict[str, Message] = {}
        self.asks = True
        self.watched: list[tuple[str, str]] = []
        self.stops = False

    def watch(self, robot: str, topic: str, _wake: Callable[[], None] | None = None) -> None:
        self.watched.append((robot, topic))

    def stop_time(self, _robot: str, _topic: str) -> bool:
        return self.stops

    def latest(self, _robot: str, topic: str) -> Message:
        return self.messages[topic]

    ask = latest


@pytest.fixture
def client() -> FakeClient:
    """Return a client whose goals wait for the test."""
    return FakeClient()


@pytest.fixture(autouse=True)
def _clean_blackboard() -> Iterator[None]:
    """Leave no keys to the next test: py_trees' blackboard belongs to the process."""
    yield
    Blackboard.clear()

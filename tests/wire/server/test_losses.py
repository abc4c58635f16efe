"""Injected losses of answers over Zenoh, and injected repetitions of requests."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hmrsim.settings.run import RunSettings
from hmrsim.world import World
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.session import SessionOptions, open_client
from tests.simulation import SMALL_WORLD

GOAL = b'{"goal": {"time": {"sec": 60}}}'


@pytest.fixture
def host():
    """Serve the small world as fast as possible, without losses at first."""
    loaded = SimpleNamespace(world=World.model_validate(SMALL_WORLD), hash="", warnings=(), path=None)
    settings = RunSettings(clock="lockstep")
    with Host(loaded, SessionOptions(listen=("tcp/127.0.0.1:0",)), settings) as host:
        host.losses.watch()
        host.start()
        yield host


@pytest.fixture
def ask(host):
    """Return a function that returns the replies to a request: payloads, and None for an error."""
    session = open_client(SessionOptions(connect=host.endpoints))

    def ask(topic, payload=None):
        """Return a function that returns the replies to a request: payloads, and None for an error."""
        replies = session.get(f"hmrsim/{topic}", payload=payload)
        return [reply.ok and reply.ok.payload.to_bytes() for reply in replies]

    yield ask
    session.close()


def test_one_answer_is_lost_but_no_reading(host, ask):
    host.losses.lose_answers(1)
    reading, lost, there = ask("_world/info"), ask("_world/get_entities", b"{}"), ask("_world/get_entities", b"{}")

    assert (1, 0, 1) == (len(reading), len(lost), len(there))


def test_a_repeated_request_is_two_goals_with_one_answer(host, ask):
    host.losses.repeat_requests(1)
    replies = ask("eve/wait/_action/send_goal", GOAL)
    status = ask("eve/wait/_action/status")[0]

    assert 1 == len(replies)
    assert 2 == status.count(b'"goal_id"')


def test_an_invalid_request_that_is_repeated_is_answered_once(host, ask):
    host.losses.repeat_requests(1)

    assert [None] == ask("eve/wait/_action/send_goal", b"{")
    assert 1 == len(ask("_world/info"))

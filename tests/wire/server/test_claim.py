"""Simulators that start at the same instant."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from queue import Empty, SimpleQueue
from threading import Barrier

import pytest

from hmrsim_zenoh.errors import PrefixTaken
from hmrsim_zenoh.server.tokens import Claim
from hmrsim_zenoh.wire.keys import Keys
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client, open_server
from tests.patience import PATIENCE


@pytest.fixture
def sessions():
    """Return three sessions that meet at a router."""
    with ExitStack() as stack:
        router, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
        stack.enter_context(router)
        yield [stack.enter_context(open_client(SessionOptions(connect=endpoints))) for _ in range(3)]


def compete(session, start):
    """Claim the prefix at the same time as others; return the token of the winner."""
    start.wait()
    try:
        return Claim(session, Keys())
    except PrefixTaken:
        return None


def test_one_of_several_simulators_stays(sessions):
    """Later ones are refused until it has ended."""
    for _ in range(10):
        with ThreadPoolExecutor() as pool:
            tokens = list(pool.map(compete, sessions, [Barrier(len(sessions))] * len(sessions)))
        (winner,) = (number for number, token in enumerate(tokens) if token)
        with pytest.raises(PrefixTaken, match="another simulator serves prefix 'hmrsim'"):
            Claim(sessions[winner - 1], Keys())
        tokens[winner].undeclare()
        # The router answers when it knows what a session has undeclared before.
        for session in sessions:
            list(session.liveliness().get(Keys().claim("*", "*")))


def test_simulators_of_other_prefixes_do_not_compete(sessions):
    assert all(Claim(session, Keys(f"lab/{number}")) for number, session in enumerate(sessions))


def test_when_two_serving_simulators_meet_the_greater_id_ends():
    with ExitStack() as stack:
        first, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
        second, more = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
        sessions = {str(session.info.zid()): stack.enter_context(session) for session in (first, second)}
        lost: SimpleQueue[str] = SimpleQueue()
        for zid, session in sessions.items():
            Claim(session, Keys()).watch(lambda _taken, zid=zid: lost.put(zid))
        # The link that is made late.
        with open_server(SessionOptions(listen=("tcp/127.0.0.1:0",), connect=(*endpoints, *more)))[0]:
            assert max(sessions) == lost.get(timeout=PATIENCE)
            sessions.pop(max(sessions)).close()
            with pytest.raises(Empty):
                lost.get(timeout=3.0)

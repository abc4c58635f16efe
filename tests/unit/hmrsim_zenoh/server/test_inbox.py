"""The threads that read the channel of queries."""

from __future__ import annotations

import threading
from queue import Empty, SimpleQueue
from types import SimpleNamespace
from typing import Any

import pytest
import zenoh

from hmrsim_zenoh.server.inbox import ChannelInbox, Reader

PATIENCE = 10.0


class Channel:
    """A channel of queries; it notes in which thread each was read."""

    def __init__(self) -> None:
        self.readers: list[threading.Thread] = []
        self._queries: SimpleQueue[Any] = SimpleQueue()

    def send(self, query: object) -> None:
        self._queries.put(query)

    def recv(self) -> object:
        return self._read(self._queries.get(timeout=PATIENCE))

    def try_recv(self) -> object:
        try:
            return self._read(self._queries.get_nowait())
        except Empty:
            return None

    def _read(self, query: object) -> object:
        if query is None:
            # It stays closed.
            self._queries.put(None)
            raise zenoh.ZError("the channel is closed")
        self.readers.append(threading.current_thread())
        return query


@pytest.fixture
def channel() -> Channel:
    """Return the channel of the inbox."""
    return Channel()


@pytest.fixture
def refused() -> list[object]:
    """Return the queries that were refused."""
    return []


@pytest.fixture
def inbox(channel, refused):
    """Return an inbox whose commands are the queries themselves; one comes when it is being closed."""

    def undeclare() -> None:
        channel.send("late")
        channel.send(None)

    queryable = SimpleNamespace(handler=channel, undeclare=undeclare)
    session: Any = SimpleNamespace(declare_queryable=lambda *_args, **_options: queryable)
    inbox = ChannelInbox()
    inbox.open(session, "a/**", Reader(lambda query: [query], refused.append), wakeup_key="a/b")
    yield inbox
    inbox.close()
    inbox.leave()


def test_the_simulations_thread_reads_the_queries_that_come_while_it_computes(inbox, channel):
    """Another thread reads the one that ends a wait with a timeout."""
    inbox.wait(0.0)
    channel.send("first")
    inbox.wait(PATIENCE)
    first = inbox.poll()
    channel.send("second")

    assert ("first", "second") == (first, inbox.poll())
    assert [False, True] == [reader is threading.current_thread() for reader in channel.readers]


def test_queries_keep_their_order_between_the_threads(inbox, channel):
    numbers = list(range(200))
    sender = threading.Thread(target=lambda: [channel.send(number) for number in numbers])
    sender.start()
    taken: list[object] = []
    while len(taken) < len(numbers):
        inbox.wait(PATIENCE)
        while (command := inbox.poll()) is not None:
            taken.append(command)
    sender.join()

    assert numbers == taken


def test_a_query_that_comes_at_the_end_of_a_wait_is_refused(inbox, refused):
    inbox.wait(0.0)
    inbox.close()

    assert refused == ["late"]
    assert inbox.poll() is None


def test_a_query_that_comes_at_the_end_of_a_computation_can_be_taken(inbox, refused):
    inbox.close()

    assert inbox.poll() == "late"
    assert refused == []


@pytest.fixture
def further(inbox, channel, refused):
    """Return the channel of a further key expression."""
    channels = [channel, Channel()]
    queryable = SimpleNamespace(handler=channels[1], undeclare=lambda: channels[1].send(None))
    inbox._session = SimpleNamespace(declare_queryable=lambda *_args, **_options: queryable)
    inbox.serve("c/**", Reader(lambda query: [query], refused.append), complete=False)
    return channels[1]


def test_the_simulations_thread_reads_further_channels_while_it_computes(inbox, further):
    inbox.wait(0.0)
    further.send("first")
    inbox.wait(PATIENCE)
    first = inbox.poll()
    further.send("second")

    assert ("first", "second") == (first, inbox.poll())
    assert [False, True] == [reader is threading.current_thread() for reader in further.readers]


def test_queries_of_a_further_channel_are_refused_after_the_end_and_taken_before(inbox, further, refused):
    further.send("before")
    inbox.close()
    further.send("after")
    inbox.leave()

    assert ["before", "late"] == [inbox.poll(), inbox.poll()]
    assert refused == ["after"]

"""The frames between a page and the server, and the outbox of one page."""

from __future__ import annotations

import json

import pytest

from hmrsim_zenoh.view import frames
from hmrsim_zenoh.view.frames import Outbox, embedded


def test_a_payload_is_embedded_as_it_came():
    text = frames.embedded('a/"b"', b'{"z": 1.0, "a": 1e400000}')

    assert '["a/\\"b\\"",{"z": 1.0, "a": 1e400000}]' == f"[{text}"


@pytest.mark.parametrize("payload", [b"", b"{", b"NaN", b"[Infinity]", b"\xff", b'{"a": 1} {', b"[" * 100_000])
def test_what_no_browser_reads_is_not_embedded(payload):
    """A payload of another publisher must not break the frame that it is in."""
    assert frames.embedded("a", payload) is None


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "Invalid JSON"),
        ("[]", "should be an object"),
        ('{"op": "dance", "id": 1}', "dance"),
        ('{"op": "get", "id": 1}', "get.key: Field required"),
        ('{"op": "get", "id": -1, "key": "a"}', "get.id: "),
        ('{"op": "get", "id": 1, "key": ""}', "get.key: "),
        ('{"op": "get", "id": 1, "key": "a", "timeout": 1e9}', "get.timeout: "),
        ('{"op": "get", "id": 1, "key": "a", "payload": [1]}', "get.payload: "),
        ('{"op": "subscribe", "id": 1, "key": "a", "every": NaN}', "every"),
        ('{"op": "subscribe", "id": 1, "key": "a", "often": true}', "subscribe.often: "),
    ],
)
def test_what_makes_no_sense_is_refused(text, why):
    with pytest.raises(ValueError, match=why):
        frames.read(text)


@pytest.mark.parametrize(("every", "pause"), [(0, 0.05), (1.5, 1.5), (1e300, 60.0)])
def test_frames_come_neither_too_often_nor_never(every, pause):
    request = frames.read(f'{{"op": "subscribe", "id": 1, "key": "a", "every": {every}}}')

    assert pause == request.pause


def entry(key: str, value: object) -> tuple[str, str]:
    """Return a sample as a feed has it."""
    return key, str(embedded(key, json.dumps(value).encode()))


@pytest.fixture
def outbox():
    """An outbox with a subscription 1 to all samples, and 2 to the latest; 100 characters may wait."""
    made = Outbox(100)
    made.open(1, latest=False)
    made.open(2, latest=True)
    return made


def taken(outbox: Outbox) -> list[dict]:
    return [json.loads(frame) for frame in outbox.drain()]


def test_nothing_is_sent_of_nothing(outbox):
    assert [] == outbox.drain()


def test_samples_of_all_subscriptions_share_a_frame(outbox):
    outbox.add(1, [entry("a", 1), entry("a", 2)], lost=False)
    outbox.add(2, [entry("b", 3)], lost=False)

    assert [{"op": "samples", "samples": [[1, "a", 1], [1, "a", 2], [2, "b", 3]]}] == taken(outbox)


def test_what_was_taken_is_not_sent_again(outbox):
    outbox.add(1, [entry("a", 1)], lost=False)
    outbox.add(2, [entry("a", 1)], lost=False)
    outbox.drain()

    assert [] == outbox.drain()


def test_of_the_latest_only_the_newest_waits(outbox):
    for value in range(1000):
        outbox.add(2, [entry("a", value)], lost=False)

    assert [{"op": "samples", "samples": [[2, "a", 999]]}] == taken(outbox)


def test_too_many_samples_are_dropped_and_reported(outbox):
    """A slow page loses all pending samples of the subscription, and gets one notice, not one each time."""
    for value in range(1000):
        outbox.add(1, [entry("a", value)], lost=False)

    assert [{"op": "lost", "id": 1}] == taken(outbox)
    assert [] == taken(outbox)


def test_samples_come_again_after_some_were_lost(outbox):
    outbox.add(1, [entry("a", "x" * 200)], lost=False)
    outbox.drain()
    outbox.add(1, [entry("a", 1)], lost=False)

    assert [{"op": "samples", "samples": [[1, "a", 1]]}] == taken(outbox)


def test_other_subscriptions_lose_nothing(outbox):
    outbox.add(2, [entry("b", 1)], lost=False)
    outbox.add(1, [entry("a", "x" * 200)], lost=False)

    assert [{"op": "samples", "samples": [[2, "b", 1]]}, {"op": "lost", "id": 1}] == taken(outbox)


def test_what_is_small_is_not_lost_for_what_is_large(outbox):
    """The largest subscription loses its samples, regardless of the order."""
    outbox.add(1, [entry("a", "x" * 85)], lost=False)
    outbox.add(2, [entry("b", "y" * 10)], lost=False)

    assert [{"op": "samples", "samples": [[2, "b", "y" * 10]]}, {"op": "lost", "id": 1}] == taken(outbox)


def test_what_zenoh_dropped_is_lost_too(outbox):
    """A feed that dropped samples reports it, and the page gets a notice."""
    outbox.add(1, [entry("a", 1)], lost=True)

    assert [{"op": "lost", "id": 1}] == taken(outbox)


def test_the_latest_can_not_be_lost(outbox):
    """A subscription to the latest samples needs no notice of older ones."""
    outbox.add(2, [entry("a", 1)], lost=True)

    assert [{"op": "samples", "samples": [[2, "a", 1]]}] == taken(outbox)


def test_what_waits_of_an_ended_subscription_is_dropped(outbox):
    outbox.add(1, [entry("a", "x" * 80)], lost=False)
    outbox.close(1)
    outbox.add(2, [entry("b", "y" * 80)], lost=False)

    assert [{"op": "samples", "samples": [[2, "b", "y" * 80]]}] == taken(outbox)


def test_answers_are_never_dropped(outbox):
    outbox.add(1, [entry("a", 1)], lost=False)
    for number in range(200):
        outbox.put(f'{{"op": "reply", "id": {number}}}')

    assert [*(["reply"] * 200), "samples"] == [frame["op"] for frame in taken(outbox)]


def test_a_page_that_never_reads_is_crowded():
    """With a hundred frames waiting, no further request should be served."""
    outbox = Outbox(1000)
    for _ in range(99):
        outbox.put("{}")
    before = outbox.crowded
    outbox.put("{}")

    assert (False, True) == (before, outbox.crowded)


def test_a_page_that_reads_no_answers_is_full(outbox):
    """The outbox is full after its limit, until the frames are sent."""
    outbox.put("x" * 100)
    before = outbox.full
    outbox.put("x")
    crowded = outbox.crowded
    taken_sizes = [len(frame) for frame in outbox.drain()]

    assert (False, True, [100, 1], False) == (before, crowded, taken_sizes, outbox.full)


def test_less_room_is_left_when_other_pages_come(outbox):
    outbox.add(1, [entry("a", "x" * 60)], lost=False)
    outbox.limit(50)
    outbox.add(2, [entry("b", "y")], lost=False)

    assert [{"op": "samples", "samples": [[2, "b", "y"]]}, {"op": "lost", "id": 1}] == taken(outbox)

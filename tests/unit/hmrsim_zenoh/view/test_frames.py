"""The frames between a page and the server."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.view import frames


def test_a_payload_is_embedded_as_it_came():
    """No number, space or order of fields is changed."""
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
    """The error gives the place and the reason."""
    with pytest.raises(ValueError, match=why):
        frames.read(text)


@pytest.mark.parametrize(("every", "pause"), [(0, 0.05), (1.5, 1.5), (1e300, 60.0)])
def test_frames_come_neither_too_often_nor_never(every, pause):
    """A subscription's pause has bounds."""
    request = frames.read(f'{{"op": "subscribe", "id": 1, "key": "a", "every": {every}}}')

    assert pause == request.pause

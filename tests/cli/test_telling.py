"""What happens, in a few words."""

from __future__ import annotations

import pytest

from hmrsim.cli.telling import words_for

EVENTS = [
    ({"kind": "waiting", "robot": "eve", "for": ["ann", "bob"]}, "waits for ann and bob"),
    ({"kind": "waiting", "robot": "eve", "why": "a-b is closed: visitors"}, "waits: a-b is closed: visitors"),
    ({"kind": "waiting", "robot": "eve", "for": []}, "waits for its turn"),
    ({"kind": "rerouted", "robot": "eve"}, "takes another way"),
    ({"kind": "made_room", "robot": "eve", "by": "ann"}, "makes room for ann"),
    ({"kind": "deadlock", "robots": ["ann", "bob"], "lanes": []}, "deadlock of ann, bob"),
    ({"kind": "dock_queued", "robot": "eve", "dock": "bay", "position": 2}, "queues for bay, as number 2"),
    ({"kind": "battery_low", "robot": "eve", "percentage": 0.2, "charge": 20.0}, "battery low, 20%"),
    ({"kind": "motion", "robot": "eve"}, ""),
]


@pytest.mark.parametrize(("event", "words"), EVENTS, ids=[words or event["kind"] for event, words in EVENTS])
def test_an_event_is_told_in_few_words(event, words):
    """Or not at all."""
    assert words == words_for(event)

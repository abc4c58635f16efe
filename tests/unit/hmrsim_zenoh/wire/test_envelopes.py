"""Requests as they are read."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import pytest
from pydantic import ValidationError

from hmrsim.actions import registry
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh.wire.envelopes import (
    GetResultRequest,
    SendGoalRequest,
    UnreadableError,
    around,
    plain,
    read,
    unreadable,
)

MANY = 1_000
JUNK = [None, True, 1, -1, 1.5, 2**70, float("inf"), "x", [], [1], [{}], {}, {"a": 1}]


@pytest.mark.parametrize(
    ("reader", "text"),
    [
        (around(SendGoalRequest, Wait.Goal), '{"goal_id":"a%031x","goal":{"time":{"sec":1}}}'),
        (plain(SendGoalRequest[dict[str, Any]]), '{"goal_id":"b%031x","goal":{}}'),
        (plain(GetResultRequest), '{"goal_id":"c%031x"}'),
    ],
)
def test_ids_that_were_read_are_not_kept(reader, text):
    """Each comes once; a cache of them would fill for many minutes."""
    before = 0
    for number in range(2 * MANY):
        if number == MANY:
            before = sys.getallocatedblocks()
        read(reader, (text % number).encode())

    assert sys.getallocatedblocks() - before < MANY / 10


@pytest.mark.parametrize("name", sorted(registry()))
def test_a_goal_has_the_same_errors_in_plain_values_as_in_json(name):
    """Whatever a field has in place of its value; the commands of an advance are read from plain values."""
    kind = registry()[name].goal
    reader = around(SendGoalRequest, kind)

    for damaged in damages(json.loads(kind.model_construct().model_dump_json())):
        text = json.dumps({"goal": damaged}).encode()
        by_json = error_of(partial(read, reader, text))
        assert by_json == error_of(partial(reader.validate_python, json.loads(text)))


def error_of(reading: Callable[[], object]) -> bytes | None:
    try:
        reading()
    except UnreadableError as error:
        return error.to_json()
    except ValidationError as error:
        return unreadable(error).to_json()
    return None


def damages(value: Any) -> Iterator[Any]:
    """Yield a message with junk in place of each of its values, one at a time."""
    yield from JUNK
    for field, inner in value.items() if isinstance(value, dict) else ():
        for each in damages(inner):
            yield {**value, field: each}

"""Requests as they are read."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh.wire.envelopes import GetResultRequest, SendGoalRequest, around, plain, read

MANY = 1_000


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

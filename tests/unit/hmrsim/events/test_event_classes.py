"""How classes of events are made."""

from __future__ import annotations

import gc

import pytest

from hmrsim.events import Event


@pytest.mark.parametrize("allocations", range(1, 8))
def test_a_class_is_made_while_garbage_is_collected(allocations):
    """A collection in the middle of it takes nothing away, whenever it comes."""
    before = gc.get_threshold()
    gc.set_threshold(allocations, 1, 1)
    try:

        class EventStamped(Event, kind="of_this_test", severity="info", subject=("robot",), text="is there"):
            """Something."""

            robot: str

    finally:
        gc.set_threshold(*before)

    assert "wall_e" == EventStamped(robot="wall_e").robot

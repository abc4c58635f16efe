"""A circle of waits that includes a dock's queue, where a goal was replaced while its robot made room."""

from __future__ import annotations

from hmrsim.world_checks import load_world
from tests.torture.missions import within


def test_a_robot_in_a_docks_queue_is_not_asked_to_go_first():
    """A random mission found this case."""
    seen = within(load_world("zoo/charger_queue"), 5_000_363)

    assert "deadlock" in seen.trace
    assert "internal_error" not in seen.trace

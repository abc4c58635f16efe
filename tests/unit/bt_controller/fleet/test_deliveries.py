"""The hospital's tasks are those of its map."""

from __future__ import annotations

from bt_controller.examples.deliveries import TASKS
from hmrsim.world_checks import load_world


def test_the_map_has_what_is_to_be_brought_and_where():
    """Items, places and robots have the same names in both."""
    world = load_world("hospital_fleet").world
    places = {task.source for task in TASKS} | {task.target for task in TASKS}

    assert [] == [task.item for task in TASKS if task.item not in world.items]
    assert [] == [place for place in places if place not in world.places]


def test_no_item_is_asked_for_twice():
    """There is one of each."""
    assert len(TASKS) == len({task.item for task in TASKS})

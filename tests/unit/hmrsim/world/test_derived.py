"""What follows from a world alone."""

from __future__ import annotations

import gc

from hmrsim.world.derived import Derived
from hmrsim.world.model import World


def world(name):
    """Return a small world."""
    return World(name=name, waypoints={"a": (0.0, 0.0)})


def test_it_is_computed_once_for_each_world():
    """Two equal worlds are computed separately."""
    asked = []
    derived = Derived(lambda world: asked.append(world.name) or len(asked))
    one, other = world("one"), world("one")

    assert [1, 1, 2, 1] == [derived(each) for each in (one, one, other, one)]


def test_it_is_forgotten_with_its_world():
    """The value is dropped with its world, whose address may be reused."""
    derived = Derived(lambda world: world.name)
    names = []
    for number in range(50):
        names.append(derived(world(str(number))))
        gc.collect()

    assert [str(number) for number in range(50)] == names
    assert {} == derived._known


def test_a_copy_with_the_same_parts_has_the_same_value():
    """A copy keeps the value even after the original world is gone."""
    asked = []
    derived = Derived(lambda world: asked.append(world.name) or [*world.waypoints], "waypoints")
    first = world("first")
    copy, other = first.model_copy(update={"name": "copy"}), first.model_copy(update={"waypoints": {"b": (1.0, 0.0)}})
    values = [derived(each) for each in (first, copy, other)]

    assert ([["a"], ["a"], ["b"]], ["first", "first"]) == (values, asked)
    del first
    gc.collect()
    assert (["a"], ["first", "first", "copy"]) == (derived(copy), asked)

"""What worlds with the same map share: it is found once, and nothing of a run gets into it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import pytest

from hmrsim.navigation.graph import WaypointGraph
from hmrsim.navigation.road_map import road_map_of
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD

if TYPE_CHECKING:
    from collections.abc import Mapping


def world(**changes: Any) -> World:
    """Return the small world with other parts."""
    return World.model_validate({**SMALL_WORLD, **changes})


@pytest.mark.parametrize("changes", [{}, {"robots": {}, "remap": {}}, {"items": {}}, {"seed": 5}, {"name": "other"}])
def test_worlds_with_the_same_map_share_their_ground(changes: Mapping[str, Any]):
    """Whether they are the same object or not, and whatever else there is in them."""
    assert road_map_of(world()) is road_map_of(world(**changes))


def test_doors_that_differ_in_time_share_their_ground():
    """Where they are is of the map; when they open is not."""
    door = {"at": [[3, 1], [3, 3]]}

    assert road_map_of(world(doors={"gate": door})) is road_map_of(world(doors={"gate": {**door, "opening_time": 7.0}}))


@pytest.mark.parametrize(
    "changes",
    [
        {"bounds": [0, 0, 20, 11]},
        {"waypoints": {**SMALL_WORLD["waypoints"], "home": [1, 2.5]}},
        {"lanes": SMALL_WORLD["lanes"][:2]},
        {"walls": SMALL_WORLD["walls"][:1]},
        {"doors": {"gate": {"at": [[3, 1], [3, 3]]}}},
        {"lifts": {"lift": {"stops": ["far", "shelf"]}}},
        {"waypoints": {**SMALL_WORLD["waypoints"], "zero": [0.0, 2]}},
        {"waypoints": {**SMALL_WORLD["waypoints"], "zero": [-0.0, 2]}},
    ],
)
def test_worlds_with_other_maps_do_not(changes: Mapping[str, Any]):
    """Each part of the map counts, the sign of a zero too, as it shows in a trace."""
    others = ({}, {"waypoints": {**SMALL_WORLD["waypoints"], "zero": [0.0, 2]}})

    road_maps = [road_map_of(world(**other)) for other in others if repr(other) != repr(changes)]

    assert all(road_map_of(world(**changes)) is not other for other in road_maps)


def test_what_a_run_changes_is_its_own():
    """Closed lanes, closed doors and ways to avoid are those of one graph."""
    one, other = WaypointGraph(world()), WaypointGraph(world())
    one.closed = frozenset({("home", "door"), ("door", "home")})
    one.doors.set(((3, 1), (3, 3)), is_open=False)
    one.avoid([0], 2.0)

    assert other.closed == frozenset()
    assert (False, True) == (one.clear_now((2, 2), (4, 2)), other.clear_now((2, 2), (4, 2)))
    assert one.seconds(1.0)[0] == 2 * other.seconds(1.0)[0]
    assert other.plan((1, 2), (5, 2), 1.0).length == 4.0


def test_a_zero_keeps_its_sign_whoever_planned_before():
    """A goal at -0.0 ends there, also when one at 0.0 was asked for by another run."""
    ends = [WaypointGraph(world()).plan((2.0, 2.0), (0.0, y), 1.0).legs[-1].end[1] for y in (0.0, -0.0, 0.0)]

    assert [1.0, -1.0, 1.0] == [math.copysign(1.0, y) for y in ends]

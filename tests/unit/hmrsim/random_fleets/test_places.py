"""The points where robots can stand, and what is near to the ways between them."""

from __future__ import annotations

import pytest

from hmrsim.random_fleets.places import Places
from hmrsim.world.model import World

TWO_LANES = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [5, 0.5], "d": [5, 8]},
    "robot_types": {"cart": {"base": {"radius": 0.3}}},
    "robots": {"ann": {"type": "cart", "at": "a"}, "bob": {"type": "cart", "at": "c"}},
}
"""The second lane leads away from the first one, from where two robots touch."""


@pytest.mark.parametrize("order", [1, -1], ids=["the first lane", "the last lane"])
def test_a_robot_in_the_middle_of_a_lane_is_near_to_all_moves_on_a_lane_that_touches_it(order):
    """Both robots occupy their whole lanes, in either order."""
    lanes = [["a", "b"], ["c", "d"]][::order]
    places = Places(World.model_validate({**TWO_LANES, "lanes": lanes}), [(2.0, 0.0), (5.0, 6.0)])
    start, middle = places.number((2.0, 0.0)), places.number((5.0, 6.0))

    (away,) = [move for move in places.moves[start] if move.end == 0]
    assert 0.5 == dict(away.near)[middle]

"""The check for docks that no robot can reach."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.geometry import SAME_PLACE, Obstacles, distance, foot
from hmrsim.world.model import World
from hmrsim.world_checks.facilities import _Ways

points = st.tuples(st.integers(0, 9), st.integers(0, 9)).map(list)
lines = st.lists(points, min_size=2, max_size=2, unique_by=tuple)
squares = st.tuples(points, st.integers(1, 4)).map(
    lambda square: {
        "solid": [[square[0][0] + dx * square[1], square[0][1] + dy * square[1]] for dx, dy in ((0, 0), (1, 0), (1, 1))]
    }
)


@st.composite
def worlds(draw):
    """Draw worlds of some lanes that may hang together, with walls and solids between."""
    at = draw(st.lists(points, min_size=2, max_size=7, unique_by=tuple))
    ends = st.tuples(st.sampled_from(range(len(at))), st.sampled_from(range(len(at)))).filter(
        lambda two: two[0] < two[1]
    )
    lanes = draw(st.lists(ends, min_size=1, max_size=5, unique=True))
    return World.model_validate(
        {
            "waypoints": {f"w{i}": point for i, point in enumerate(at)},
            "lanes": [[f"w{a}", f"w{b}"] for a, b in lanes],
            "walls": [*draw(st.lists(lines, max_size=4)), *draw(st.lists(squares, max_size=2))],
        }
    )


@given(worlds(), st.tuples(st.floats(-1, 11), st.floats(-1, 11)) | points.map(lambda point: tuple(map(float, point))))
def test_parts_near_a_point_are_those_that_it_is_on_or_sees(world, point):
    """The parts near a point are the same as those found by checking each lane and each wall."""
    ways = _Ways(world)
    solids = [wall.solid for wall in world.walls if not isinstance(wall, tuple)]
    obstacles = Obstacles([wall for wall in world.walls if isinstance(wall, tuple)], solids)
    feet = [
        (ways._part[lane.from_], foot(point, world.points[lane.from_], world.points[lane.to])) for lane in world.lanes
    ]
    on_lane = {part for part, at in feet if distance(at, point) <= SAME_PLACE}
    seen = {part for part, at in feet if not obstacles.block(point, at)}

    assert (on_lane or seen) == ways._near(point)

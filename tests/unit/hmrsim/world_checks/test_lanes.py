"""The check for lanes on which robots pass through each other."""

from __future__ import annotations

import pytest

from hmrsim.cli import main
from hmrsim.world import World
from hmrsim.world_checks.lanes import check_crossings

CROSS = {
    "waypoints": {"west": [0, 0], "east": [20, 0], "north": [10, 10], "south": [10, -10], "side": [0, 0.75]},
    "lanes": [["west", "east"], ["north", "south"], ["side", "north"]],
    "robots": {"ann": {"at": "west"}, "bob": {"at": "north"}},
}


def wide(radius):
    """Return the two robots with footprints."""
    return {name: {**robot, "base": {"radius": radius}} for name, robot in CROSS["robots"].items()}


def warnings(**fields):
    """Return the warnings of the world with these fields."""
    return [
        (finding.severity, finding.path, finding.message)
        for finding in check_crossings(World.model_validate({**CROSS, **fields}))
    ]


def test_lanes_that_cross_without_a_waypoint():
    """Under `free` robots pass through each other at a crossing, but lanes that share a waypoint don't count."""
    text = (
        "'west'-'east' crosses lanes.1 'north'-'south' without a waypoint: under 'free' robots pass through each other"
        " there; 'reserve', 'priority' and 'planned' keep them apart"
    )
    assert [("warning", ("lanes", 0), text)] == warnings()


def test_lanes_nearer_than_robots_are_wide():
    """The first one is reported, with the distance that two robots need, and the others are counted."""
    lanes = [CROSS["lanes"][0], CROSS["lanes"][2], CROSS["lanes"][1]]
    text = (
        "'west'-'east' is 0.75 from lanes.1 'side'-'north' and 1 more, and two robots need 0.8: under 'free' robots"
        " pass through each other there; 'reserve', 'priority' and 'planned' keep them apart"
    )
    assert [("warning", ("lanes", 0), text)] == warnings(lanes=lanes, robots=wide(0.4), traffic={"policy": "free"})
    narrow = warnings(lanes=lanes, robots=wide(0.3), traffic={"policy": "free"})
    assert [("lanes", 0)] == [path for _, path, _ in narrow]


@pytest.mark.parametrize(
    "fields",
    [
        {"traffic": {"policy": "reserve"}},
        {"robots": wide(0.4)},
        {"robots": {"ann": {"at": "west"}}},
        {"robots": {"ann": {"at": "west"}, "bob": {"at": "north", "base": {"flies": True}}}},
    ],
    ids=["kept apart", "kept apart by default", "one robot", "one that drives"],
)
def test_nothing_where_no_two_robots_pass_through_each_other(fields):
    """There is no warning under other policies or for a single robot."""
    assert [] == warnings(**fields)


def test_it_is_reported_with_its_line(tmp_path, capsys):
    """The warning has its line, besides one for lanes that are not connected."""
    path = tmp_path / "cross.yaml"
    path.write_text(
        "waypoints: {a: [0, 0], b: [2, 2], c: [0, 2], d: [2, 0]}\n"
        "lanes:\n"
        "  - [a, b]\n"
        "  - [c, d]\n"
        "robots: {ann: {at: a}, bob: {at: c}}\n"
    )
    code = main(["map", "validate", str(path)])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert lines[1].startswith(f"{path}:3: warning: lanes.0: 'a'-'b' crosses lanes.1 'c'-'d' without a waypoint")
    assert "0 errors, 2 warnings" == lines[-1]

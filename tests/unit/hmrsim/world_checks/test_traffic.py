"""The traffic policy and its settings, capacities, start positions, and lanes too near to each other."""

from __future__ import annotations

import pytest

from hmrsim.cli import main
from hmrsim.documents.valid_parts import Lost
from hmrsim.world import World
from hmrsim.world_checks.lanes import check_crossings
from hmrsim.world_checks.robots import check_traffic

WAYPOINTS = {"a": (0.0, 0.0), "b": (1.0, 0.0)}


@pytest.mark.parametrize(
    ("fields", "path"),
    [
        ({"lanes": [{"from": "a", "to": "b"}, {"from": "b", "to": "a", "capacity": 2}]}, ("lanes", 1, "capacity")),
        ({"waypoints": {**WAYPOINTS, "c": {"at": (2.0, 0.0), "capacity": 2}}}, ("waypoints", "c", "capacity")),
    ],
)
def test_a_capacity_without_effect_is_reported_once(fields, path):
    world = World.model_validate({"waypoints": WAYPOINTS, **fields})

    (found,) = check_traffic(world)
    assert (path, "warning") == (found.path, found.severity)
    assert (
        "has no effect: robots pass through each other, as fewer than two have a radius and no policy is set; add"
        " traffic: {policy: planned}, or remove the capacity"
    ) == found.message


@pytest.mark.parametrize("policy", ["free", "priority"])
def test_a_capacity_under_a_chosen_policy_has_no_warning(policy):
    lanes = [{"from": "a", "to": "b", "capacity": 2}]
    world = World.model_validate({"waypoints": WAYPOINTS, "lanes": lanes, "traffic": {"policy": policy}})

    assert [] == [*check_traffic(world)]


WIDE = {"base": {"radius": 0.3}}


def errors(**fields):
    robots = {"ann": {"at": "a", **WIDE}, "bob": {"at": "b", **WIDE}}
    world = World.model_validate({"waypoints": WAYPOINTS, "lanes": [["a", "b"]], "robots": robots, **fields})
    return [finding.message for finding in check_traffic(world) if finding.severity == "error"]


def test_robots_that_overlap_at_the_start_are_an_error():
    text = (
        "starts 0.5 from 'ann'; under 'planned' keep 0.6 away (the default; traffic: {policy: free} lets robots pass"
        " through each other)"
    )
    assert [text] == errors(waypoints={"a": (0.0, 0.0), "b": (0.5, 0.0)})


def test_a_world_can_set_options_of_the_default_policy():
    assert [] == errors(traffic={"patience": 30.0, "most_states": 1000})


def test_a_setting_that_the_default_policy_lacks_is_an_error():
    text = "unknown key 'lane_capacity'; there are policy, patience (the policy is 'free' by default; set another one)"
    assert [text] == errors(traffic={"lane_capacity": 2}, robots={"ann": {"at": "a", **WIDE}, "bob": {"at": "b"}})


def test_an_uncertain_default_policy_has_no_errors():
    """Errors of robots may change the default."""
    robots = {"ann": {"at": "a", **WIDE}}
    world = World.model_validate({"waypoints": WAYPOINTS, "robots": robots, "traffic": {"lane_capacity": 2}})

    assert [] == [*check_traffic(world, Lost({"robots": frozenset({"bob"})}))]


CROSS = {
    "waypoints": {"west": [0, 0], "east": [20, 0], "north": [10, 10], "south": [10, -10], "side": [0, 0.75]},
    "lanes": [["west", "east"], ["north", "south"], ["side", "north"]],
    "robots": {"ann": {"at": "west"}, "bob": {"at": "north"}},
}


def wide(radius):
    return {name: {**robot, "base": {"radius": radius}} for name, robot in CROSS["robots"].items()}


def warnings(**fields):
    return [
        (finding.severity, finding.path, finding.message)
        for finding in check_crossings(World.model_validate({**CROSS, **fields}))
    ]


def test_lanes_that_cross_without_a_waypoint_are_reported():
    text = (
        "'west'-'east' crosses lanes.1 'north'-'south' without a waypoint: under 'free' robots pass through each other"
        " there; 'reserve', 'priority' and 'planned' keep them apart"
    )
    assert [("warning", ("lanes", 0), text)] == warnings()


def test_lanes_too_near_to_each_other_are_reported():
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
def test_no_warning_if_no_two_robots_pass_through_each_other(fields):
    assert [] == warnings(**fields)


def test_the_warning_has_its_line(tmp_path, capsys):
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

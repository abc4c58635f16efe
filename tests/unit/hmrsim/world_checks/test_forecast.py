"""The forecast of traffic problems in a world."""

from __future__ import annotations

from itertools import pairwise

import pytest

from hmrsim.cli import main
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import SendGoal
from hmrsim.world import World
from hmrsim.world_checks.checks import check
from hmrsim.world_checks.forecast import forecast
from tests.shipped import shipped
from tests.simulation import simulate

H = {
    "waypoints": {
        "a": [0, 5],
        "b": [0, -5],
        "west": [0, 0],
        "m": [10, 0],
        "n": [20, 0],
        "east": [30, 0],
        "c": [30, 5],
        "d": [30, -5],
    },
    "lanes": [["a", "west"], ["b", "west"], ["west", "m"], ["m", "n"], ["n", "east"], ["east", "c"], ["east", "d"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "c"}},
}
"""A corridor with passing places at both ends."""

ROW = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0]},
    "lanes": [["a", "b"], ["b", "c"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "c"}},
}

AROUND = {**H, "waypoints": {**H["waypoints"], "far": [15, -40]}, "lanes": [*H["lanes"], ["b", "far"], ["far", "d"]]}
DOCK = {"charger": {"at": "m", "type": "charger"}}
FULL = {name: {"at": name} for name in "abc"}


def warnings(world, policy="reserve", **fields):
    """Return the warnings of a world with these fields under a policy; the world must be valid otherwise."""
    model = World.model_validate({**world, "traffic": {"policy": policy}, **fields})
    assert [] == [finding for finding in check(model) if finding.severity == "error"]
    return [(finding.path, finding.message) for finding in forecast(model)]


def paths(*arguments, **fields):
    return [path for path, _ in warnings(*arguments, **fields)]


def go(robot, x, y, goal_id):
    pose = PoseStamped(pose=Pose(position=Point(x=float(x), y=float(y))))
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=pose), goal_id)


def ends(world, policy):
    """Return how the goals of two robots end that enter the corridor from both ends."""
    run = simulate({**world, "traffic": {"policy": policy}})
    log = run((0.0, go("ann", 30, -5, "a" * 32)), (0.0, go("bob", 0, -5, "b" * 32)))
    return [log.changes(letter * 32)[-1][1] for letter in "ab"]


class TestCorridors:
    def test_under_reserve_both_lose_their_goals(self):
        text = (
            "m - n is a single track without a way around: two robots that meet in it block each other for good, and"
            " lose their goals; make room for two at every other waypoint (capacity: 2), or have one of them go back"
            " (policy 'priority')"
        )
        assert [(("lanes", 3), text)] == warnings(H)
        assert ["ABORTED", "ABORTED"] == ends(H, "reserve")

    def test_under_priority_one_goes_back(self):
        assert [] == warnings(H, "priority")
        assert ["SUCCEEDED", "SUCCEEDED"] == ends(H, "priority")

    @pytest.mark.parametrize(
        "world",
        [{**H, "waypoints": {**H["waypoints"], "m": {"at": [10, 0], "capacity": 2}}}, AROUND],
        ids=["room for two", "a way around"],
    )
    def test_the_suggested_remedy_works(self, world):
        assert [] == warnings(world)
        assert ["SUCCEEDED", "SUCCEEDED"] == ends(world, "reserve")

    @pytest.mark.parametrize("robots", [{"ann": {"at": "a"}}, {"ann": {"at": "a"}, "bob": {"at": "e"}}])
    def test_a_single_robot_has_no_warning(self, robots):
        waypoints = {**H["waypoints"], "e": [50, 0], "f": [60, 0]}

        assert [] == paths({**H, "waypoints": waypoints, "lanes": [*H["lanes"], ["e", "f"]], "robots": robots})

    def test_a_corridor_without_passing_places_is_reported_under_priority(self):
        text = (
            "a - b - c is a single track without a way around: two robots that meet in it block each other for good,"
            " and lose their goals; make room for two at every other waypoint (capacity: 2), or add a waypoint beside"
            " it"
        )
        assert [(("lanes", 0), text)] == warnings(ROW, "priority")

    @pytest.mark.parametrize(("count", "named"), [(4, "a - b - c - d"), (5, "a - … - e")])
    def test_a_long_corridor_is_named_by_its_ends(self, count, named):
        names = "abcde"[:count]
        row = {
            "waypoints": {name: [10 * i, 0] for i, name in enumerate(names)},
            "lanes": [[*pair] for pair in pairwise(names)],
            "robots": {"ann": {"at": names[0]}, "bob": {"at": names[-1]}},
        }

        [(_, text)] = warnings(row)
        assert text.startswith(f"{named} is a single track")


class TestDocks:
    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_a_dock_in_the_only_route_is_reported(self, policy):
        waypoints = {**H["waypoints"], "n": {"at": [20, 0], "capacity": 2}}
        text = (
            "is at m, in the only way to a, b, west: no robot gets past one that is docked; move it aside, or make room"
            " for one more (capacity: 2)"
        )
        assert [(("docks", "charger", "at"), text)] == warnings({**H, "waypoints": waypoints}, policy, docks=DOCK)

    def test_a_dock_on_a_lane_is_reported(self):
        waypoints = {**H["waypoints"], "n": {"at": [20, 0], "capacity": 2}}
        docks = {"charger": {"at": [15, 0]}}

        assert [("docks", "charger", "at")] == paths({**H, "waypoints": waypoints}, docks=docks)

    @pytest.mark.parametrize(
        "fields",
        [
            {"docks": {"charger": {"at": "a"}}},
            {"docks": {"charger": {"at": [10, 2]}}},
            {"docks": DOCK, "lanes": AROUND["lanes"], "waypoints": AROUND["waypoints"]},
            {"docks": DOCK, "waypoints": {**H["waypoints"], "m": {"at": [10, 0], "capacity": 2}}},
        ],
        ids=["at an end", "beside the way", "a way around", "room for one more"],
    )
    def test_docks_that_robots_can_pass_have_no_warning(self, fields):
        assert [] == paths(H, "priority", **fields)


class TestRoom:
    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_a_world_without_free_places_is_reported(self, policy):
        text = (
            "are 3 on the lanes around 'a', where 3 have room: none can move; add waypoints, or room at them (capacity)"
        )
        assert (("robots",), text) in warnings(ROW, policy, robots=FULL)

    def test_too_few_places_to_wait_are_reported(self):
        robots = {name: {"at": name} for name in ("a", "b", "c", "d", "m")}
        text = (
            "are 5 on the lanes around 'a', where 4 can stand without being in the only way of others; add waypoints,"
            " or room at them (capacity)"
        )
        assert (("robots",), text) in warnings(H, robots=robots)
        assert [] == paths(H, "priority", robots=robots)

    @pytest.mark.parametrize(
        "fields",
        [
            {"docks": {"pad": {"at": [10, 5], "capacity": 10**9}}},
            {"places": {"desk": {"at": [10, 5]}}},
            {"robots": {**FULL, "c": {"at": [20, 3]}}},
        ],
        ids=["a dock", "a place", "a robot"],
    )
    def test_robots_beside_the_lanes_have_no_warning(self, fields):
        assert ("robots",) not in paths(ROW, **{"robots": FULL, **fields})


@pytest.mark.parametrize("fields", [{"waypoints": {}, "lanes": [], "robots": {}}, {"lanes": []}])
def test_worlds_without_lanes_have_no_warnings(fields):
    assert [] == warnings(H, **fields)


@pytest.mark.parametrize("world", [H, ROW])
def test_under_free_nothing_is_forecast(world):
    assert [] == warnings(world, "free", docks=DOCK if world is H else {})


ZOO = ["charger_queue", "corridor_swap", "crossing", "dead_end", "door", "lift", "token_swap"]


@pytest.mark.parametrize(
    "name", ["hospital", "hospital_fleet", "scenario1", "scenario2", "warehouse", *(f"zoo/{name}" for name in ZOO)]
)
def test_shipped_worlds_have_no_warnings(name):
    assert [] == [*forecast(shipped(name).world)]


def test_a_flag_enables_the_forecast(tmp_path, capsys):
    path = tmp_path / "row.yaml"
    path.write_text(
        "waypoints: {a: [0, 0], b: [1, 0]}\n"
        "lanes:\n"
        "  - [a, b]\n"
        "robots: {ann: {at: a}, bob: {at: b}}\n"
        "traffic: {policy: reserve}\n"
    )
    reported = []
    for options in ([], ["--traffic"]):
        assert 0 == main(["map", "validate", str(path), *options])
        reported.append(capsys.readouterr().out.splitlines())

    assert ["traffic policy: reserve", "0 errors, 0 warnings"] == reported[0]
    places = [": ".join(line.split(": ")[:3]) for line in reported[1][:2]]
    assert [f"{path}:3: warning: lanes.0", f"{path}:4: warning: robots"] == places
    assert "0 errors, 2 warnings" == reported[1][-1]


def test_a_world_with_errors_has_no_forecast(tmp_path, capsys):
    path = tmp_path / "wrong.yaml"
    path.write_text("waypoints: {a: [0, 0]}\nlanes: [[a, b]]\ntraffic: {policy: reserve}\n")

    assert 1 == main(["map", "validate", str(path), "--traffic"])
    assert "1 error, 0 warnings" == capsys.readouterr().out.splitlines()[-1]

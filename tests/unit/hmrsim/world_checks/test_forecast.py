"""What the traffic of a world will come to."""

from __future__ import annotations

from itertools import pairwise

import pytest

from hmrsim.cli import main
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import SendGoal
from hmrsim.world import World
from hmrsim.world_checks import check_world
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
"""A corridor, with room to go aside at both of its ends."""

ROW = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0]},
    "lanes": [["a", "b"], ["b", "c"]],
    "robots": {"ann": {"at": "a"}, "bob": {"at": "c"}},
}

AROUND = {
    **H,
    "waypoints": {**H["waypoints"], "far": [15, -40]},
    "lanes": [*H["lanes"], ["b", "far"], ["far", "d"]],
}
DOCK = {"charger": {"at": "m", "type": "charger"}}
FULL = {name: {"at": name} for name in "abc"}


def warnings(world, policy="reserve", **fields):
    """Return what is foretold of a world with these fields under a policy; nothing else is wrong with it."""
    model = World.model_validate({**world, "traffic": {"policy": policy}, **fields})
    assert [] == [problem for problem in check_world(model) if problem.severity == "error"]
    return [(finding.path, finding.message) for finding in forecast(model)]


def paths(*arguments, **fields):
    """Return where something is foretold."""
    return [path for path, _ in warnings(*arguments, **fields)]


def go(robot, x, y, goal_id):
    """Return the command that sends a robot to a point."""
    pose = PoseStamped(pose=Pose(position=Point(x=float(x), y=float(y))))
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=pose), goal_id)


def ends(world, policy):
    """Return how the goals of two robots end that go through the corridor from both ends."""
    run = simulate({**world, "traffic": {"policy": policy}})
    log = run((0.0, go("ann", 30, -5, "a" * 32)), (0.0, go("bob", 0, -5, "b" * 32)))
    return [log.changes(letter * 32)[-1][1] for letter in "ab"]


class TestCorridors:
    """Two robots that meet in one block each other."""

    def test_under_reserve_both_lose_their_goals(self):
        """The warning is at the first lane of the corridor, and the simulation confirms it."""
        text = (
            "m - n is a single track without a way around: two robots that meet in it block each other for good, and"
            " lose their goals; make room for two at every other waypoint (capacity: 2), or have one of them go back"
            " (policy 'priority')"
        )
        assert [(("lanes", 3), text)] == warnings(H)
        assert ["ABORTED", "ABORTED"] == ends(H, "reserve")

    def test_under_priority_one_goes_back(self):
        """There is no warning, and both robots arrive."""
        assert [] == warnings(H, "priority")
        assert ["SUCCEEDED", "SUCCEEDED"] == ends(H, "priority")

    @pytest.mark.parametrize(
        "world",
        [
            {**H, "waypoints": {**H["waypoints"], "m": {"at": [10, 0], "capacity": 2}}},
            AROUND,
        ],
        ids=["room for two", "a way around"],
    )
    def test_what_would_do_does(self, world):
        """After the suggested remedy there is no warning, and both robots arrive."""
        assert [] == warnings(world)
        assert ["SUCCEEDED", "SUCCEEDED"] == ends(world, "reserve")

    @pytest.mark.parametrize("robots", [{"ann": {"at": "a"}}, {"ann": {"at": "a"}, "bob": {"at": "e"}}])
    def test_a_robot_alone_meets_no_other_one(self, robots):
        """There is no warning for a single robot, or one whose lanes lead nowhere else."""
        waypoints = {**H["waypoints"], "e": [50, 0], "f": [60, 0]}

        assert [] == paths({**H, "waypoints": waypoints, "lanes": [*H["lanes"], ["e", "f"]], "robots": robots})

    def test_where_no_two_can_pass_it_is_told_under_priority_too(self):
        """Without a place to go back to, there is a warning under `priority`, too."""
        text = (
            "a - b - c is a single track without a way around: two robots that meet in it block each other for good,"
            " and lose their goals; make room for two at every other waypoint (capacity: 2), or add a waypoint beside"
            " it"
        )
        assert [(("lanes", 0), text)] == warnings(ROW, "priority")

    @pytest.mark.parametrize(("count", "named"), [(4, "a - b - c - d"), (5, "a - … - e")])
    def test_a_long_one_is_named_by_its_ends(self, count, named):
        """A corridor of up to four waypoints is named by all of them, a longer one by its ends."""
        names = "abcde"[:count]
        row = {
            "waypoints": {name: [10 * i, 0] for i, name in enumerate(names)},
            "lanes": [[*pair] for pair in pairwise(names)],
            "robots": {"ann": {"at": names[0]}, "bob": {"at": names[-1]}},
        }

        [(_, text)] = warnings(row)
        assert text.startswith(f"{named} is a single track")


class TestDocks:
    """A docked robot stands in the way of others."""

    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_a_dock_in_the_only_way(self, policy):
        """No robot can pass a docked robot, which does not yield."""
        waypoints = {**H["waypoints"], "n": {"at": [20, 0], "capacity": 2}}
        text = (
            "is at m, in the only way to a, b, west: no robot gets past one that is docked; move it aside, or make room"
            " for one more (capacity: 2)"
        )
        assert [(("docks", "charger", "at"), text)] == warnings({**H, "waypoints": waypoints}, policy, docks=DOCK)

    def test_a_dock_on_a_lane(self):
        """A dock on a lane blocks it for other robots."""
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
    def test_docks_that_are_in_no_ones_way(self, fields):
        """There is no warning for docks that robots can pass."""
        assert [] == paths(H, "priority", **fields)


class TestRoom:
    """Robots need somewhere to go, and somewhere to wait."""

    @pytest.mark.parametrize("policy", ["reserve", "priority"])
    def test_no_place_is_left(self, policy):
        """There is a warning if no robot can move."""
        text = (
            "are 3 on the lanes around 'a', where 3 have room: none can move; add waypoints, or room at them (capacity)"
        )
        assert (("robots",), text) in warnings(ROW, policy, robots=FULL)

    def test_no_place_to_wait_out_of_the_way(self):
        """There is a warning for one robot more than the four ends of the lanes."""
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
    def test_what_is_beside_the_lanes_has_room_of_its_own(self, fields):
        """Robots beside the lanes are in no robot's way."""
        assert ("robots",) not in paths(ROW, **{"robots": FULL, **fields})


@pytest.mark.parametrize("fields", [{"waypoints": {}, "lanes": [], "robots": {}}, {"lanes": []}])
def test_worlds_without_lanes(fields):
    """A world without lanes has no warnings."""
    assert [] == warnings(H, **fields)


@pytest.mark.parametrize("world", [H, ROW])
def test_under_free_nothing_is_forecast(world):
    """Under `free` robots pass through each other, so that there are no warnings."""
    assert [] == warnings(world, "free", docks=DOCK if world is H else {})


ZOO = ["charger_queue", "corridor_swap", "crossing", "dead_end", "door", "lift", "token_swap"]


@pytest.mark.parametrize(
    "name", ["hospital", "hospital_fleet", "scenario1", "scenario2", "warehouse", *(f"zoo/{name}" for name in ZOO)]
)
def test_shipped_worlds_come_to_no_harm(name):
    """The shipped worlds have no warnings."""
    assert [] == [*forecast(shipped(name).world)]


def test_it_is_reported_with_its_line_if_asked_for(tmp_path, capsys):
    """A flag enables the warnings, each with its line."""
    path = tmp_path / "row.yaml"
    path.write_text(
        "waypoints: {a: [0, 0], b: [1, 0]}\n"
        "lanes:\n"
        "  - [a, b]\n"
        "robots: {ann: {at: a}, bob: {at: b}}\n"
        "traffic: {policy: reserve}\n"
    )
    told = []
    for options in ([], ["--traffic"]):
        assert 0 == main(["map", "validate", str(path), *options])
        told.append(capsys.readouterr().out.splitlines())

    assert ["traffic policy: reserve", "0 errors, 0 warnings"] == told[0]
    places = [": ".join(line.split(": ")[:3]) for line in told[1][:2]]
    assert [f"{path}:3: warning: lanes.0", f"{path}:4: warning: robots"] == places
    assert "0 errors, 2 warnings" == told[1][-1]


def test_a_world_with_errors_is_not_asked(tmp_path, capsys):
    """A world with errors is not checked further."""
    path = tmp_path / "wrong.yaml"
    path.write_text("waypoints: {a: [0, 0]}\nlanes: [[a, b]]\ntraffic: {policy: reserve}\n")

    assert 1 == main(["map", "validate", str(path), "--traffic"])
    assert "1 error, 0 warnings" == capsys.readouterr().out.splitlines()[-1]

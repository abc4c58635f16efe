"""What a new subscriber is shown, and what only subscribers are told."""

from __future__ import annotations

import json

import pytest

from hmrsim.events import registry as events
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.navigation.motion import Trapezoid
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.simulation.snapshot import scene
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD, simulate

A = "a" * 32
B = "b" * 32

WORLD = SMALL_WORLD | {
    "docks": {"charger": {"at": [1, 2], "type": "charger"}},
    "doors": {"gate": {"at": [[7, 1.5], [7, 2.5]]}},
    "robot_types": {
        "nurse": {
            "base": {"speed": 2.0, "radius": 0.3},
            "components": {"claw": {"reach": 0.9}, "battery": {"capacity": 100.0}, "camera": {"range": 4.0}},
        },
        "truck": {"base": {"speed": 1.0, "acceleration": 0.5, "turning_rate": 1.0}},
    },
    "robots": {
        "wall_e": {"type": "nurse", "at": "home"},
        "cart": {"type": "truck", "at": "door"},
    },
}

UNTRACED = {kind for kind, event in events().items() if not event.traced}


def go(x, y, *, robot="wall_e", goal_id=A):
    """Return the command to drive to a point."""
    target = PoseStamped(pose=Pose(position=Point(x=x, y=y)))
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=target), goal_id)


@pytest.fixture
def simulator():
    """A simulator of a world with something of each kind."""
    return Simulator(World.model_validate(WORLD))


def robot(simulator, name="wall_e"):
    """Return what the scene says of a robot."""
    return next(each for each in scene(simulator)["robots"] if each["name"] == name)


class TestScene:
    """All that is there at one instant."""

    def test_a_robot_that_stands_has_no_motion(self, simulator):
        """It has a pose, what it carries, and where it is docked."""
        shown = robot(simulator)

        assert {
            "name": "wall_e",
            "type": "nurse",
            "radius": 0.3,
            "flies": False,
            "speed": 2.0,
            "pose": [1.0, 2.0, 0.0],
            "motion": None,
            "route": [],
            "waits": False,
            "waiting": None,
            "dock": "charger",
            "ailments": {},
            "battery": {"percentage": 1.0, "charging": False},
            "sensors": [{"name": "camera", "range": 4.0, "field_of_view": pytest.approx(1.5707963), "blind": False}],
            "connected": True,
            "holds": [],
            "goals": [],
        } == shown

    def test_a_robot_on_its_way_has_the_piece_that_it_drives_and_the_way_ahead(self, simulator):
        """A subscriber that comes while it is on a lane knows where it is from then on."""
        simulator.submit(go(5, 2))
        simulator.advance(0.5)

        shown = robot(simulator)

        motion = {"from": [1.0, 2.0, 0.0], "to": [5.0, 2.0, 0.0], "duration": 2.0, "lane": ["home", "door"]}
        assert motion | {"began": 0.0} == shown["motion"]
        assert ([2.0, 2.0, 0.0], [[5.0, 2.0]]) == (shown["pose"], shown["route"])
        assert [(A, 2, {"x": 5.0, "y": 2.0})] == [
            (goal["goal_id"], goal["status"], goal["goal"]["pose"]["pose"]["position"]) for goal in shown["goals"]
        ]

    def test_the_last_goal_that_ended_is_shown_with_its_result(self, simulator):
        """A subscriber that comes later sees why it failed; older goals are not shown."""
        simulator.submit(go(5, 2))
        simulator.advance(5.0)
        simulator.submit(go(99, 2)._replace(goal_id="b" * 32))
        simulator.advance(6.0)

        (goal,) = robot(simulator)["goals"]

        assert ("b" * 32, 6, 204) == (goal["goal_id"], goal["status"], goal["result"]["error_code"])

    def test_a_waiting_robot_is_shown_with_what_it_waits_for(self, simulator):
        """It is shown since when it waits, so that a later subscriber sees it, too."""
        simulator.submit(go(9, 2))
        simulator.advance(3.0)

        shown = robot(simulator)

        waiting = {"since": 2.0, "at": [5.0, 2.0], "lane": ["door", "shelf"], "why": "gate is opening", "blockers": []}
        assert (True, waiting) == (
            shown["waits"],
            {key: value for key, value in shown["waiting"].items() if key != "robot"},
        )

    def test_items_move_with_the_robot_that_holds_them(self, simulator):
        """The robot names what it holds, the item by whom it is held."""
        simulator.submit(SendGoal("wall_e", "pickup", Pickup.Goal(target_name="letter"), A))
        simulator.advance(1.0)

        letter = next(item for item in scene(simulator)["items"] if item["name"] == "letter")

        assert {"name": "letter", "weight": 0.0, "at": [1.0, 2.0], "carrier": "wall_e"} == letter
        assert ["letter"] == robot(simulator)["holds"]

    def test_fixtures_have_their_tags(self, simulator):
        """As entities have."""
        shown = scene(simulator)["fixtures"]

        assert [
            ("charger", "dock", ["dock", "charger", "full", "docked:wall_e"]),
            ("gate", "door", ["door", "closed"]),
        ] == [(each["name"], each["kind"], each["tags"]) for each in shown]

    def test_faults_and_the_lanes_that_they_close_are_there(self):
        """Those to come are not."""
        fault = {"type": "lane_closed", "name": "wet", "lane": ["home", "door"], "at": 1}
        simulator = Simulator(World.model_validate(WORLD | {"faults": [fault, fault | {"name": "late", "at": 9}]}))
        simulator.advance(2.0)

        shown = scene(simulator)

        assert ["wet"] == [each["name"] for each in shown["faults"]]
        assert [{"lane": ["door", "home"], "why": "wet"}, {"lane": ["home", "door"], "why": "wet"}] == sorted(
            shown["closed_lanes"], key=lambda each: each["lane"]
        )

    def test_it_is_json(self, simulator):
        """All of it, as it is."""
        simulator.submit(go(5, 2))
        simulator.advance(0.5)

        assert scene(simulator) == json.loads(json.dumps(scene(simulator), allow_nan=False))


class TestWatched:
    """What subscribers are told, and is in no trace."""

    def test_a_goal_and_its_way_are_told_before_it_drives(self):
        """What is asked, where it leads, and the first piece of it, at one instant."""
        log = simulate(WORLD)((0.0, go(9, 2)))

        told = [event.kind for _, event in log.events if isinstance(event, EventStamped) and not event.event.traced]

        assert ["goal", "route", "motion"] == told[:3]
        assert [(0.0, {"robot": "wall_e", "points": [[5.0, 2.0], [9.0, 2.0]]})] == log.happened("route")

    def test_speeding_up_is_told_as_a_profile(self):
        """Distance, speed and acceleration of the stretch, and how much of it was driven before."""
        log = simulate(WORLD)((0.0, go(1, 2, robot="cart")))

        ((_, turned),) = log.happened("motion")
        driven, _ = turned["then"]

        assert ([4.0, 1.0, 0.5, 0.0], Trapezoid(4.0, 1.0, 0.5).duration) == (driven["profile"], driven["duration"])
        assert pytest.approx(3.1415927) == abs(turned["turned"])

    def test_a_turn_that_takes_no_time_is_told(self):
        """A robot that drives west turns to face east at once, as the goal says, where it has no turning rate."""
        log = simulate(WORLD)((0.0, go(9, 2)), (9.0, go(1, 2, goal_id=B)))

        turned = log.happened("motion")[-1][1]

        assert ([1.0, 2.0, pytest.approx(3.1415927)], [1.0, 2.0, 0.0], 0.0) == (
            turned["from"],
            turned["to"],
            turned["duration"],
        )

    def test_no_trace_has_it(self):
        """A trace says what happened; how is made anew by a replay."""
        run = simulate(WORLD, traced=True)
        run((0.0, go(9, 2)), until=9.0)

        kinds = {json.loads(line)["kind"] for line in run.lines()}

        assert {"header", "command", "status", "dock_undocked", "end"} <= kinds
        assert set() == kinds & UNTRACED

    def test_nothing_is_told_without_a_subscriber(self):
        """A subscriber to other events only gets none of them."""
        log = simulate(WORLD, topics=frozenset(Topic) - {Topic.MOTION})((0.0, go(9, 2)))

        assert [] == [kind for kind in sorted(UNTRACED) if log.happened(kind)]

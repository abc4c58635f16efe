"""The scene for new subscribers, and the events for watchers only."""

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
    "robots": {"wall_e": {"type": "nurse", "at": "home"}, "cart": {"type": "truck", "at": "door"}},
}

UNTRACED = {kind for kind, event in events().items() if not event.traced}


def go(x, y, *, robot="wall_e", goal_id=A):
    target = PoseStamped(pose=Pose(position=Point(x=x, y=y)))
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal(pose=target), goal_id)


@pytest.fixture
def simulator():
    """Return a simulator of a world with an entity of each kind."""
    return Simulator(World.model_validate(WORLD))


def robot(simulator, name="wall_e"):
    return next(each for each in scene(simulator)["robots"] if each["name"] == name)


class TestScene:
    def test_a_standing_robot_has_pose_items_and_dock_but_no_motion(self, simulator):
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
            "cause": {
                "robot": "wall_e",
                "kind": "docked",
                "text": "wall_e is docked in 'charger' at home: it has had no goal yet",
                "held_by": [],
                "next": "",
                "help": shown["cause"]["help"],
            },
            "dock": "charger",
            "ailments": {},
            "battery": {"percentage": 1.0, "charging": False},
            "sensors": [{"name": "camera", "range": 4.0, "field_of_view": pytest.approx(1.5707963), "blind": False}],
            "connected": True,
            "holds": [],
            "goals": [],
        } == shown

    def test_a_driving_robot_has_its_current_motion_and_its_route(self, simulator):
        simulator.submit(go(5, 2))
        simulator.advance(0.5)

        shown = robot(simulator)

        motion = {"from": [1.0, 2.0, 0.0], "to": [5.0, 2.0, 0.0], "duration": 2.0, "lane": ["home", "door"]}
        assert motion | {"began": 0.0} == shown["motion"]
        assert ([2.0, 2.0, 0.0], [[5.0, 2.0]]) == (shown["pose"], shown["route"])
        assert [(A, 2, {"x": 5.0, "y": 2.0})] == [
            (goal["goal_id"], goal["status"], goal["goal"]["pose"]["pose"]["position"]) for goal in shown["goals"]
        ]

    def test_the_last_goal_is_in_the_scene_with_its_result(self, simulator):
        simulator.submit(go(5, 2))
        simulator.advance(5.0)
        simulator.submit(go(99, 2)._replace(goal_id="b" * 32))
        simulator.advance(6.0)

        (goal,) = robot(simulator)["goals"]

        assert ("b" * 32, 6, 204) == (goal["goal_id"], goal["status"], goal["result"]["error_code"])

    def test_a_waiting_robot_has_the_cause_and_start_of_its_wait(self, simulator):
        simulator.submit(go(9, 2))
        simulator.advance(3.0)

        shown = robot(simulator)

        waiting = {"since": 2.0, "at": [5.0, 2.0], "lane": ["door", "shelf"], "why": "gate is opening"}
        assert (True, waiting) == (
            shown["waits"],
            {key: value for key, value in shown["waiting"].items() if key != "robot"},
        )

    def test_held_items_and_their_robots_refer_to_each_other(self, simulator):
        simulator.submit(SendGoal("wall_e", "pickup", Pickup.Goal(target_name="letter"), A))
        simulator.advance(1.0)

        letter = next(item for item in scene(simulator)["items"] if item["name"] == "letter")

        assert {"name": "letter", "weight": 0.0, "at": [1.0, 2.0], "carrier": "wall_e"} == letter
        assert ["letter"] == robot(simulator)["holds"]

    def test_fixtures_have_their_tags(self, simulator):
        shown = scene(simulator)["fixtures"]

        assert [
            ("charger", "dock", ["dock", "charger", "full", "docked:wall_e"]),
            ("gate", "door", ["door", "closed"]),
        ] == [(each["name"], each["kind"], each["tags"]) for each in shown]

    def test_active_faults_and_closed_lanes_are_in_the_scene(self):
        fault = {"type": "lane_closed", "name": "wet", "lane": ["home", "door"], "at": 1}
        simulator = Simulator(World.model_validate(WORLD | {"faults": [fault, fault | {"name": "late", "at": 9}]}))
        simulator.advance(2.0)

        shown = scene(simulator)

        assert ["wet"] == [each["name"] for each in shown["faults"]]
        assert [{"lane": ["door", "home"], "why": "wet"}, {"lane": ["home", "door"], "why": "wet"}] == sorted(
            shown["closed_lanes"], key=lambda each: each["lane"]
        )

    def test_the_scene_is_json(self, simulator):
        simulator.submit(go(5, 2))
        simulator.advance(0.5)

        assert scene(simulator) == json.loads(json.dumps(scene(simulator), allow_nan=False))


class TestWatched:
    """Events for watchers, which are in no trace."""

    def test_a_goal_its_route_and_its_first_motion_come_at_one_instant(self):
        log = simulate(WORLD)((0.0, go(9, 2)))

        told = [event.kind for _, event in log.events if isinstance(event, EventStamped) and not event.event.traced]

        assert ["goal", "route", "motion"] == told[:3]
        assert [(0.0, {"robot": "wall_e", "points": [[5.0, 2.0], [9.0, 2.0]]})] == log.happened("route")

    def test_acceleration_is_a_profile(self):
        log = simulate(WORLD)((0.0, go(1, 2, robot="cart")))

        ((_, turned),) = log.happened("motion")
        driven, _ = turned["then"]

        assert ([4.0, 1.0, 0.5, 0.0], Trapezoid(4.0, 1.0, 0.5).duration) == (driven["profile"], driven["duration"])
        assert pytest.approx(3.1415927) == abs(turned["turned"])

    def test_an_instantaneous_turn_is_a_motion(self):
        """The robot has no turning rate."""
        log = simulate(WORLD)((0.0, go(9, 2)), (9.0, go(1, 2, goal_id=B)))

        turned = log.happened("motion")[-1][1]

        assert ([1.0, 2.0, pytest.approx(3.1415927)], [1.0, 2.0, 0.0], 0.0) == (
            turned["from"],
            turned["to"],
            turned["duration"],
        )

    def test_the_trace_has_no_motions(self):
        """A replay computes them again."""
        run = simulate(WORLD, traced=True)
        run((0.0, go(9, 2)), until=9.0)

        kinds = {json.loads(line)["kind"] for line in run.lines()}

        assert {"header", "command", "status", "dock_undocked", "end"} <= kinds
        assert set() == kinds & UNTRACED

    def test_no_motions_are_computed_without_a_subscriber(self):
        log = simulate(WORLD, topics=frozenset(Topic) - {Topic.MOTION})((0.0, go(9, 2)))

        assert [] == [kind for kind in sorted(UNTRACED) if log.happened(kind)]

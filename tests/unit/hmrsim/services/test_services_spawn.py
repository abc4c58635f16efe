"""Spawning, deleting and moving robots and items."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry as actions
from hmrsim.protocol.commands import GetResult, Read, SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import RosterChanged
from hmrsim.protocol.topics import Topic
from tests.simulation import SMALL_WORLD, simulate

OK, NOT_FOUND, FAILED = 1, 2, 4
GOAL, NEXT = "a" * 32, "b" * 32


def send(action, goal, robot="wall_e", goal_id=GOAL):
    """Return the command that sends a goal in plain values."""
    return SendGoal(robot, action, actions()[action].goal.model_validate(goal), goal_id, reply_to=goal_id)


def go(x=9.0, y=2.0, **more):
    """Return the command to drive somewhere."""
    return send("navigate_to_pose", {"pose": {"pose": {"position": {"x": x, "y": y}}}}, **more)


def spawn(run, name="bob", uri="robot_type:nurse", x=3.0, y=2.0, **more):
    """Spawn something; return the answer."""
    pose = more.pop("initial_pose", {"pose": {"position": {"x": x, "y": y}}})
    return run.ask("spawn_entity", {"name": name, "uri": uri, "initial_pose": pose, **more})


def put(run, entity, x, y, **more):
    """Put an entity somewhere else; return what came of it."""
    return run.ask(
        "set_entity_state", {"entity": entity, "state": {"pose": {"position": {"x": x, "y": y}}, **more}}
    ).result


def told(run):
    """Return how often a change of the robots was announced."""
    return sum(isinstance(event, RosterChanged) for _, event in run.log.events)


class TestSpawn:
    """What is put into the world."""

    def test_what_can_be_spawned(self, run):
        """Spawnables are the world's robot types, the built-in types, and copies of the world's items."""
        kinds = run.ask("get_spawnables").spawnables

        assert [
            ("robot_type:nurse", "robot of type nurse, which carries claw"),
            ("robot_type:carrier", "robot of type carrier, which carries nothing"),
            ("robot_type:fetcher", "robot of type fetcher, which carries claw"),
            ("item", "item without weight"),
            ("item:parcel", "item like parcel, of 0.2 kg"),
            ("item:anvil", "item like anvil, of 80 kg"),
            ("item:letter", "item like letter, of 0 kg"),
        ] == [(kind.uri, kind.description) for kind in kinds]

    def test_unknown_sources_are_named(self, run):
        """Unknown sources are reported without failing the request."""
        answer = run.ask("get_spawnables", {"sources": ["https://example.org"]})

        assert (OK, 7) == (answer.result.result, len(answer.spawnables))
        assert "unknown sources are left out: https://example.org" == answer.result.error_message

    def test_a_robot_is_served_at_once(self, run):
        """A spawned robot accepts goals at once, and has the requested pose."""
        facing = {"orientation": {"z": 1.0, "w": 0.0}}
        answer = spawn(run, initial_pose={"pose": {"position": {"x": 3.0, "y": 2.0}, **facing}})
        before = run.simulator.robots["bob"].pose()
        log = run((0.0, go(robot="bob")))

        assert (OK, "bob") == (answer.result.result, answer.entity_name)
        assert (3.0, 2.0, pytest.approx(3.14159265)) == before
        assert (6.0, "SUCCEEDED") == log.changes(GOAL)[-1]

    def test_a_robot_has_odometry(self, run):
        """A spawned robot publishes odometry."""
        spawn(run)
        run.simulator.submit(Read(Topic.ODOM, "bob", reply_to="odom"))

        assert "bob/base_link" == run.log.answer("odom").message.child_frame_id

    def test_subscribers_learn_of_robots(self, run):
        """Spawned robots are announced, but not items, which have no action servers."""
        spawn(run)
        robots = told(run)
        spawn(run, "box", "item")

        assert (1, 1) == (robots, told(run))
        assert [
            (0.0, {"entity": "bob", "type": "nurse", "at": [3.0, 2.0]}),
            (0.0, {"entity": "box", "type": "item", "at": [3.0, 2.0]}),
        ] == run.log.happened("spawned")

    def test_an_item_can_be_picked_up(self, run):
        """A spawned item has the weight of its model."""
        spawn(run, "second", "item:parcel", x=1.2)
        log = run((0.0, send("pickup", {"target_name": "second"})))

        assert "SUCCEEDED" == log.changes(GOAL)[-1][1]
        assert 0.2 == run.simulator.items["second"].weight

    def test_items_may_lie_inside_of_obstacles(self, run):
        """An item can be spawned inside an obstacle, as on a shelf."""
        assert OK == spawn(run, "box", "item", x=7.0, y=5.0).result.result

    @pytest.mark.parametrize(
        ("asked", "code", "why"),
        [
            ({"name": ""}, 102, "the name is empty; give one, or allow_renaming"),
            ({"name": "_bob"}, 102, "'_bob' is not a name"),
            ({"name": "bob smith"}, 102, "'bob smith' is not a name"),
            ({"name": "bób"}, 102, "'bób' is not a name"),
            ({"name": "b" * 101}, 102, "is not a name: expected up to 100 letters"),
            ({"name": "eve"}, 101, "there is an entity 'eve' already"),
            ({"name": "parcel"}, 101, "there is an entity 'parcel' already"),
            ({"uri": ""}, 104, "neither uri nor resource_string is given; there are: robot_type:nurse"),
            ({"uri": "", "resource_string": "<sdf/>"}, 103, "a resource_string can't be spawned"),
            ({"uri": "robot.sdf"}, 103, "nothing to spawn of uri 'robot.sdf'; there are: robot_type:nurse"),
            ({"uri": "robot_type:doctor"}, 2, "nothing to spawn of uri 'robot_type:doctor'"),
            ({"uri": "item:piano"}, 2, "nothing to spawn of uri 'item:piano'"),
            ({"entity_namespace": "ward"}, 105, "entities have no namespace here"),
            ({"x": 30.0}, 109, "(30, 2) is outside the map, which spans (0, 0) to (20, 10)"),
            ({"x": 7.0, "y": 5.0}, 109, "(7, 5) is inside an obstacle"),
            ({"x": 12.0, "y": 5.0}, 109, "(12, 5) is inside an obstacle"),
            ({"uri": "item", "x": -1.0}, 109, "(-1, 2) is outside the map"),
            ({"initial_pose": {"header": {"frame_id": "odom"}}}, 109, "unknown frame_id 'odom'"),
            ({"initial_pose": {"pose": {"orientation": {"w": 0.0}}}}, 109, "the orientation is all zero"),
            ({"initial_pose": {"pose": {"orientation": {"x": 1.0, "w": 0.0}}}}, 109, "the orientation is tilted"),
        ],
    )
    def test_what_can_not_be_spawned(self, run, asked, code, why):
        """An invalid request fails with the package's code and the reason, and changes nothing."""
        answer = spawn(run, **asked)

        assert (code, "") == (answer.result.result, answer.entity_name)
        assert why in answer.result.error_message
        assert (3, 3, 0) == (len(run.simulator.robots), len(run.simulator.items), told(run))

    @pytest.mark.parametrize(
        ("name", "uri", "expected"),
        [
            ("bob", "item", "bob"),
            ("eve", "robot_type:nurse", "eve_1"),
            ("", "robot_type:nurse", "nurse_1"),
            ("", "item", "item_1"),
            ("", "item:parcel", "parcel_1"),
            ("e" * 100, "item", "e" * 100),
        ],
    )
    def test_a_name_can_be_made(self, run, name, uri, expected):
        """A name is generated if that is allowed and needed."""
        assert expected == spawn(run, name, uri, allow_renaming=True).entity_name

    def test_made_names_are_counted(self, run):
        """Generated names are numbered."""
        assert ["nurse_1", "nurse_2"] == [spawn(run, "", x=x, allow_renaming=True).entity_name for x in (3.0, 4.0)]

    def test_long_names_are_cut_to_be_told_apart(self, run):
        """Long names are cut so that numbered ones are valid."""
        names = [spawn(run, "e" * 100, x=x, allow_renaming=True).entity_name for x in (3.0, 4.0)]

        assert ["e" * 100, f"{'e' * 98}_1"] == names

    def test_a_name_that_is_made_is_a_name(self, make_run):
        """A generated name is valid whatever the name of the type or item is."""
        run = make_run({"robot_types": {"2nd nurse!": {}, "¿?": {}}})
        kinds = ((3.0, "2nd nurse!"), (4.0, "¿?"))
        names = [spawn(run, "", f"robot_type:{kind}", x=x, allow_renaming=True).entity_name for x, kind in kinds]

        assert ["ndnurse_1", "entity_1"] == names


class TestDelete:
    """What is taken out of the world."""

    def test_a_robot_is_gone_from_everything(self, run):
        """A deleted robot is unknown to all services."""
        run.ask("delete_entity", {"entity": "wall_e"})
        run((0.0, go()), (0.0, Read(Topic.ODOM, "wall_e", reply_to="odom")))

        assert "unknown_robot" == run.log.answer(GOAL).reason
        assert "no such robot or action: wall_e/" == run.log.answer("odom").message
        assert ["eve", "cart"] == [*run.simulator.robots]
        assert ["eve", "cart", "parcel", "anvil", "letter"] == run.ask("get_entities").entities
        assert (1, [(0.0, {"entity": "wall_e"})]) == (told(run), run.log.happened("deleted"))

    def test_its_goals_are_aborted_first(self, run):
        """The waiting client gets its result, and no event of the goal follows."""
        run((0.0, go()), (0.0, GetResult("wall_e", "navigate_to_pose", GOAL, "result")), until=1.5)
        run.ask("delete_entity", {"entity": "wall_e"})
        run.simulator.run()

        assert (1.5, "ABORTED") == run.log.changes(GOAL)[-1]
        assert (GoalStatus.ABORTED, "the robot was deleted") == (
            run.log.answer("result").status,
            run.log.answer("result").result.error_msg,
        )

    def test_what_it_holds_lies_where_it_was(self, run):
        """Other robots can pick up the item of a deleted robot."""
        run((0.0, send("pickup", {"target_name": "letter"})), (0.0, go(goal_id=NEXT)), until=2.0)
        run.ask("delete_entity", {"entity": "wall_e"})

        letter = run.simulator.items["letter"]
        assert (None, (3.0, 2.0)) == (letter.carrier, letter.point)
        assert [(2.0, {"robot": "wall_e", "item": "letter", "at": [3.0, 2.0]})] == run.log.happened("placed")

    def test_another_of_its_name_is_another(self, run):
        """A new robot of the same name does not know the goals of the first."""
        run((0.0, go()))
        run.ask("delete_entity", {"entity": "wall_e"})
        spawn(run, "wall_e", "robot_type:carrier")
        run.simulator.submit(GetResult("wall_e", "navigate_to_pose", GOAL, "result"))
        run((8.0, go()))

        assert GoalStatus.UNKNOWN is run.log.answer("result").status
        assert "carrier" == run.simulator.robots["wall_e"].type

    def test_nothing_of_it_is_remembered(self, run):
        """Memory does not grow with the number of deleted robots."""
        run((0.0, go()))
        run.ask("delete_entity", {"entity": "wall_e"})

        assert "wall_e" not in run.simulator.dispatcher._ended
        assert [] == [robot for robot, _ in run.simulator.dispatcher.servers._servers]

    def test_an_item(self, run):
        """No robot holds it any more."""
        run((0.0, send("pickup", {"target_name": "letter"})))
        run.ask("delete_entity", {"entity": "letter"})

        assert None is run.simulator.robots["wall_e"].components["claw"].item
        assert "letter" not in run.simulator.items

    @pytest.mark.parametrize(
        ("before", "action", "goal", "code"),
        [
            ((), "pickup", {"target_name": "letter"}, -19),
            (("pickup", {"target_name": "letter"}), "place", {"attached_object_name": "letter"}, -19),
        ],
    )
    def test_an_item_that_is_being_handled(self, before, action, goal, code):
        """A goal fails if its item is deleted."""
        world = SMALL_WORLD | {"robot_types": {"nurse": {"components": {"claw": {"handling_time": 2.0}}}}}
        run = simulate(world)
        if before:
            run((0.0, send(*before, goal_id=NEXT)))
        begin = run.simulator.now
        run((begin, send(action, goal)), until=begin + 1.0)
        run.ask("delete_entity", {"entity": "letter"})
        run.simulator.run()

        assert (begin + 2.0, "ABORTED") == run.log.changes(GOAL)[-1]
        assert code == run.log.result(GOAL).error_code.val


class TestMove:
    """What is put somewhere else."""

    def test_a_robot(self, run):
        """A moved robot is at its new pose at once."""
        result = put(run, "wall_e", 5.0, 3.0, header={"frame_id": "map"})

        assert (OK, (5.0, 3.0, 0.0)) == (result.result, run.simulator.robots["wall_e"].pose())
        assert [(0.0, {"entity": "wall_e", "at": [5.0, 3.0], "yaw": 0.0})] == run.log.happened("teleported")

    def test_a_goal_that_drives_is_aborted_first(self, run):
        """The goal of a moved robot is aborted, so that the robot does not continue from the new place."""
        run((0.0, go()), until=1.5)
        put(run, "wall_e", 5.0, 3.0)
        run.simulator.run()

        assert (1.5, "ABORTED") == run.log.changes(GOAL)[-1]
        assert "moved by set_entity_state" == run.log.result(GOAL).error_msg
        assert (5.0, 3.0) == run.simulator.robots["wall_e"].pose().point

    def test_it_drives_from_there(self, run):
        """The next goal starts at the new pose."""
        put(run, "wall_e", 6.0, 2.0)
        log = run((0.0, go()))

        assert (3.0, "SUCCEEDED") == log.changes(GOAL)[-1]

    def test_what_it_holds_comes_along(self, run):
        """A held item moves with its robot."""
        run((0.0, send("pickup", {"target_name": "letter"})))
        put(run, "wall_e", 5.0, 3.0)

        assert (5.0, 3.0) == run.simulator.items["letter"].position

    def test_an_item(self, run):
        """The robot that held it no longer does."""
        run((0.0, send("pickup", {"target_name": "letter"})))
        put(run, "letter", 5.0, 3.0)

        assert (5.0, 3.0) == run.simulator.items["letter"].position
        assert None is run.simulator.robots["wall_e"].components["claw"].item

    def test_an_item_that_is_moved_away_can_not_be_picked_up(self):
        """Picking up an item fails if it is moved away in the meantime."""
        world = SMALL_WORLD | {"robot_types": {"nurse": {"components": {"claw": {"handling_time": 2.0}}}}}
        run = simulate(world)
        run((0.0, send("pickup", {"target_name": "letter"})), until=1.0)
        put(run, "letter", 9.0, 9.0)
        run.simulator.run()

        assert (2.0, "ABORTED") == run.log.changes(GOAL)[-1]
        assert "'letter' is out of reach" in run.log.result(GOAL).error_code.message

    @pytest.mark.parametrize(
        ("asked", "code", "why"),
        [
            ({"x": 30.0, "y": 2.0}, 101, "(30, 2) is outside the map"),
            ({"x": 7.0, "y": 5.0}, 101, "(7, 5) is inside an obstacle"),
            ({"x": 5.0, "y": 3.0, "header": {"frame_id": "odom"}}, 101, "unknown frame_id 'odom'"),
            ({"x": 5.0, "y": 3.0, "twist": {"linear": {"x": 1.0}}}, 4, "a velocity or an acceleration can't be set"),
            ({"x": 5.0, "y": 3.0, "acceleration": {"linear": {"x": 1.0}}}, 4, "only the pose"),
        ],
    )
    def test_where_it_can_not_be(self, run, asked, code, why):
        """A robot that can't be moved keeps its pose and its goal."""
        run((0.0, go()), until=1.5)
        result = put(run, "wall_e", **asked)

        assert code == result.result
        assert why in result.error_message
        assert ((2.5, 2.0), "EXECUTING") == (
            run.simulator.robots["wall_e"].pose().point,
            run.log.changes(GOAL)[-1][1],
        )

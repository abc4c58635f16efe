"""Services that spawn, delete and move robots and items."""

from __future__ import annotations

import pytest

from hmrsim.protocol.commands import GetResult, Read
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import RosterChanged
from hmrsim.protocol.topics import Topic
from tests.simulation import SMALL_WORLD, A, B, go, send, simulate

OK, NOT_FOUND, FAILED = 1, 2, 4
SLOW_CLAW = SMALL_WORLD | {"robot_types": {"nurse": {"components": {"claw": {"handling_time": 2.0}}}}}


def spawn(run, name="bob", uri="robot_type:nurse", x=3.0, y=2.0, **more):
    pose = more.pop("initial_pose", {"pose": {"position": {"x": x, "y": y}}})
    return run.ask("spawn_entity", {"name": name, "uri": uri, "initial_pose": pose, **more})


def put(run, entity, x, y, **more):
    return run.ask(
        "set_entity_state", {"entity": entity, "state": {"pose": {"position": {"x": x, "y": y}}, **more}}
    ).result


def told(run):
    return sum(isinstance(event, RosterChanged) for _, event in run.log.events)


class TestSpawn:
    def test_spawnables_are_types_and_items(self, run):
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

    def test_unknown_sources_do_not_fail_the_request(self, run):
        answer = run.ask("get_spawnables", {"sources": ["https://example.org"]})

        assert (OK, 7) == (answer.result.result, len(answer.spawnables))
        assert "unknown sources are left out: https://example.org" == answer.result.error_message

    def test_a_robot_is_served_at_once(self, run):
        facing = {"orientation": {"z": 1.0, "w": 0.0}}
        answer = spawn(run, initial_pose={"pose": {"position": {"x": 3.0, "y": 2.0}, **facing}})
        before = run.simulator.robots["bob"].pose()
        log = run((0.0, go(9, 2, robot="bob")))

        assert (OK, "bob") == (answer.result.result, answer.entity_name)
        assert (3.0, 2.0, pytest.approx(3.14159265)) == before
        assert (6.0, "SUCCEEDED") == log.changes(A)[-1]

    def test_a_robot_has_odometry(self, run):
        spawn(run)
        run.simulator.submit(Read(Topic.ODOM, "bob", reply_to="odom"))

        assert "bob/base_link" == run.log.answer("odom").message.child_frame_id

    def test_spawned_robots_are_announced(self, run):
        spawn(run)
        robots = told(run)
        spawn(run, "box", "item")

        assert (1, 1) == (robots, told(run))
        assert [
            (0.0, {"entity": "bob", "type": "nurse", "at": [3.0, 2.0]}),
            (0.0, {"entity": "box", "type": "item", "at": [3.0, 2.0]}),
        ] == run.log.happened("spawned")

    def test_an_item_can_be_picked_up(self, run):
        spawn(run, "second", "item:parcel", x=1.2)
        log = run((0.0, send("pickup", target_name="second")))

        assert "SUCCEEDED" == log.changes(A)[-1][1]
        assert 0.2 == run.simulator.items["second"].weight

    def test_items_can_be_spawned_inside_obstacles(self, run):
        """An item may lie on a shelf."""
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
    def test_invalid_spawns_are_rejected(self, run, asked, code, why):
        answer = spawn(run, **asked)

        assert (code, "") == (answer.result.result, answer.entity_name)
        assert why in answer.result.error_message
        assert (3, 3, 0) == (len(run.simulator.robots), len(run.simulator.items), told(run))

    @pytest.mark.parametrize(
        ("uri", "names"),
        [
            ("item", [("bob", "bob")]),
            ("robot_type:nurse", [("eve", "eve_1")]),
            ("robot_type:nurse", [("", "nurse_1"), ("", "nurse_2")]),
            ("item", [("", "item_1")]),
            ("item:parcel", [("", "parcel_1")]),
            ("item", [("e" * 100, "e" * 100), ("e" * 100, f"{'e' * 98}_1")]),
        ],
    )
    def test_a_name_is_generated_on_request(self, run, uri, names):
        for x, (name, expected) in enumerate(names, 3):
            assert expected == spawn(run, name, uri, x=float(x), allow_renaming=True).entity_name

    def test_generated_names_are_valid(self, make_run):
        run = make_run({"robot_types": {"2nd nurse!": {}, "¿?": {}}})
        kinds = ((3.0, "2nd nurse!"), (4.0, "¿?"))
        names = [spawn(run, "", f"robot_type:{kind}", x=x, allow_renaming=True).entity_name for x, kind in kinds]

        assert ["ndnurse_1", "entity_1"] == names


class TestDelete:
    def test_a_robot_is_gone_from_everything(self, run):
        run.ask("delete_entity", {"entity": "wall_e"})
        run((0.0, go(9, 2)), (0.0, Read(Topic.ODOM, "wall_e", reply_to="odom")))

        assert "unknown_robot" == run.log.answer(A).reason
        assert "no such robot or action: wall_e/" == run.log.answer("odom").message
        assert ["eve", "cart"] == [*run.simulator.robots]
        assert ["eve", "cart", "parcel", "anvil", "letter"] == run.ask("get_entities").entities
        assert (1, [(0.0, {"entity": "wall_e"})]) == (told(run), run.log.happened("deleted"))

    def test_its_goals_are_aborted_first(self, run):
        run((0.0, go(9, 2)), (0.0, GetResult("wall_e", "navigate_to_pose", A, "result")), until=1.5)
        run.ask("delete_entity", {"entity": "wall_e"})
        run.simulator.run()

        assert (1.5, "ABORTED") == run.log.changes(A)[-1]
        assert GoalStatus.ABORTED == run.log.answer("result").status
        assert "the robot was deleted" == run.log.answer("result").result.error_msg

    def test_the_item_of_a_deleted_robot_stays_there(self, run):
        run((0.0, send("pickup", target_name="letter")), (0.0, go(9, 2, goal_id=B)), until=2.0)
        run.ask("delete_entity", {"entity": "wall_e"})

        letter = run.simulator.items["letter"]
        assert (None, (3.0, 2.0)) == (letter.carrier, letter.point)
        assert [(2.0, {"robot": "wall_e", "item": "letter", "at": [3.0, 2.0]})] == run.log.happened("placed")

    def test_a_new_robot_does_not_know_the_goals_of_its_namesake(self, run):
        run((0.0, go(9, 2)))
        run.ask("delete_entity", {"entity": "wall_e"})
        spawn(run, "wall_e", "robot_type:carrier")
        run.simulator.submit(GetResult("wall_e", "navigate_to_pose", A, "result"))
        run((8.0, go(9, 2)))

        assert GoalStatus.UNKNOWN is run.log.answer("result").status
        assert "carrier" == run.simulator.robots["wall_e"].type

    def test_deleted_robots_are_freed(self, run):
        run((0.0, go(9, 2)))
        run.ask("delete_entity", {"entity": "wall_e"})

        assert "wall_e" not in run.simulator.dispatcher._ended
        assert [] == [robot for robot, _ in run.simulator.dispatcher.servers._servers]

    def test_a_deleted_item_is_not_held(self, run):
        run((0.0, send("pickup", target_name="letter")))
        run.ask("delete_entity", {"entity": "letter"})

        assert run.simulator.robots["wall_e"].components["claw"].item is None
        assert "letter" not in run.simulator.items

    @pytest.mark.parametrize(
        ("before", "action", "goal", "code"),
        [
            ((), "pickup", {"target_name": "letter"}, -19),
            (("pickup", {"target_name": "letter"}), "place", {"attached_object_name": "letter"}, -19),
        ],
    )
    def test_handling_a_deleted_item_fails(self, before, action, goal, code):
        run = simulate(SLOW_CLAW)
        if before:
            run((0.0, send(before[0], B, **before[1])))
        begin = run.simulator.now
        run((begin, send(action, **goal)), until=begin + 1.0)
        run.ask("delete_entity", {"entity": "letter"})
        run.simulator.run()

        assert (begin + 2.0, "ABORTED") == run.log.changes(A)[-1]
        assert code == run.log.result(A).error_code.val


class TestMove:
    def test_a_moved_robot_drives_from_its_new_pose(self, run):
        result = put(run, "wall_e", 6.0, 2.0, header={"frame_id": "map"})
        moved = run.simulator.robots["wall_e"].pose()

        assert (OK, (6.0, 2.0, 0.0)) == (result.result, moved)
        assert [(0.0, {"entity": "wall_e", "at": [6.0, 2.0], "yaw": 0.0})] == run.log.happened("teleported")
        assert (3.0, "SUCCEEDED") == run((0.0, go(9, 2))).changes(A)[-1]

    def test_a_goal_that_drives_is_aborted_first(self, run):
        run((0.0, go(9, 2)), until=1.5)
        put(run, "wall_e", 5.0, 3.0)
        run.simulator.run()

        assert (1.5, "ABORTED") == run.log.changes(A)[-1]
        assert "moved by set_entity_state" == run.log.result(A).error_msg
        assert (5.0, 3.0) == run.simulator.robots["wall_e"].pose().point

    @pytest.mark.parametrize(("entity", "item"), [("wall_e", "letter"), ("letter", None)])
    def test_a_held_item_moves_with_its_robot_but_not_the_other_way_around(self, run, entity, item):
        run((0.0, send("pickup", target_name="letter")))
        put(run, entity, 5.0, 3.0)

        held = run.simulator.robots["wall_e"].components["claw"].item
        assert (5.0, 3.0) == run.simulator.items["letter"].position
        assert item == (held and held.name)

    def test_an_item_that_is_moved_away_can_not_be_picked_up(self):
        run = simulate(SLOW_CLAW)
        run((0.0, send("pickup", target_name="letter")), until=1.0)
        put(run, "letter", 9.0, 9.0)
        run.simulator.run()

        assert (2.0, "ABORTED") == run.log.changes(A)[-1]
        assert "'letter' is out of reach" in run.log.result(A).error_code.message

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
    def test_a_robot_that_can_not_be_moved_keeps_its_pose_and_goal(self, run, asked, code, why):
        run((0.0, go(9, 2)), until=1.5)
        result = put(run, "wall_e", **asked)

        assert code == result.result
        assert why in result.error_message
        assert (2.5, 2.0) == run.simulator.robots["wall_e"].pose().point
        assert "EXECUTING" == run.log.changes(A)[-1][1]


def test_several_entities_are_spawned_at_once():
    run = simulate(SMALL_WORLD)
    pose = {"pose": {"position": {"x": 3.0, "y": 2.0}}}
    requests = [
        {"name": "bob", "entity_resource": {"uri": "robot_type:nurse"}, "initial_pose": pose},
        {"name": "box", "entity_resource": {"uri": "unicorn"}},
        {"allow_renaming": True, "entity_resource": {"uri": "item"}, "initial_pose": pose},
    ]
    answer = run.ask("spawn_entities", {"spawn_requests": requests})

    assert ["bob", "", "item_1"] == [one.entity_name for one in answer.results]
    assert [OK, 103, OK] == [one.result.result for one in answer.results]
    assert 150 == answer.result.result
    assert answer.result.error_message.startswith("spawn_requests.1: nothing to spawn of uri 'unicorn'")
    assert {"bob", "item_1"} <= {*run.simulator.robots, *run.simulator.items}


def test_no_requests_spawn_nothing():
    assert OK == simulate(SMALL_WORLD).ask("spawn_entities").result.result

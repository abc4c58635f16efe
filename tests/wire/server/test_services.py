"""The world's services over Zenoh, in plain JSON."""

from __future__ import annotations

import json

import pytest
import zenoh

from tests.wire.server.conftest import Heard

GOAL = "a" * 32
OK = {"result": 1, "error_message": ""}
PAUSED, PLAYING = {"state": {"state": 2}}, {"state": {"state": 1}}


@pytest.fixture
def bob():
    """Return the request that spawns a robot."""
    pose = {"pose": {"position": {"x": 3.0, "y": 2.0}}}
    return {"name": "bob", "uri": "robot_type:fetcher", "initial_pose": pose}


def tokens(tester, robot):
    """Subscribe to a robot's liveliness token; return the samples."""
    heard = Heard()
    handler = zenoh.handlers.Callback(heard.on_sample, indirect=False)
    key = tester.key(f"{robot}/alive")
    tester._subscribers.append(tester.session.liveliness().declare_subscriber(key, handler, history=True))
    return heard


def test_an_answer_has_the_encoding_of_its_type(shared):
    (reply,) = shared.ask("_world/get_simulation_state", {})

    assert ({"state": {"state": 1}, "result": OK}, True) == (reply.body, reply.ok)
    assert "application/json;simulation_interfaces/srv/GetSimulationState_Response" == reply.encoding


def test_a_request_needs_no_payload(shared):
    assert ["wall_e", "eve", "cart", "parcel", "anvil", "letter"] == shared.one("_world/get_entities")["entities"]


@pytest.mark.parametrize(
    ("payload", "field"),
    [
        ({"entity": 1}, "entity"),
        ({"entity": "eve", "colour": "red"}, "colour"),
        ({"entity": "eve", "state": {"pose": {"position": {"x": "far"}}}}, "state.pose.position.x"),
        (b'{"state": {"pose": {"position": {"x": NaN}}}}', "state.pose.position.x"),
        (b"[1", ""),
    ],
)
def test_a_malformed_request_is_an_error_with_the_field(shared, payload, field):
    (reply,) = shared.ask("_world/set_entity_state", payload)

    assert (False, field) == (reply.ok, reply.body["details"][0]["field"])


def test_info_lists_services_and_actions_of_the_world(shared):
    info = shared.one("_world/info")
    types = {service["name"]: service["type"] for service in info["services"]}

    assert "simulation_interfaces/srv/SpawnEntity" == types["_world/spawn_entity"]
    assert ["simulate_steps"] == info["actions"]


def test_steps_are_available_as_an_action_with_feedback(live):
    live.one("_world/set_simulation_state", PAUSED)
    heard = live.hear("_world/simulate_steps/_action/feedback")
    done = live.do("_world/simulate_steps", {"steps": 3})

    assert (4, {"result": OK}) == (done["status"], done["result"])
    assert {"completed_steps": 3, "remaining_steps": 0} == heard.wait(bool)[-1]["feedback"]
    assert [4] == [status for _, status in live.status("_world/simulate_steps")]


def test_a_spawned_robot_is_served_at_once(fast, bob):
    spawned = fast.one("_world/spawn_entity", bob)
    names = [robot["name"] for robot in fast.one("_world/info")["robots"]]
    done = fast.do("bob/navigate_to_pose", {"pose": {"pose": {"position": {"x": 9.0, "y": 2.0}}}})

    assert ({"result": OK, "entity_name": "bob"}, 4) == (spawned, done["status"])
    assert (9.0, 2.0) == fast.where("bob")
    assert ["wall_e", "eve", "cart", "bob"] == names


def test_the_token_of_a_spawned_robot_comes_and_goes(fast, bob):
    heard = tokens(fast, "bob")
    fast.one("_world/spawn_entity", bob)
    heard.wait(lambda bodies: len(bodies) == 1)
    fast.one("_world/delete_entity", {"entity": "bob"})
    heard.wait(lambda bodies: len(bodies) == 2)

    assert [True, False] == [item.ok for item in heard.items]


def test_the_info_message_is_published_again_with_new_robots(fast, bob):
    heard = fast.hear("_world/info")
    fast.one("_world/spawn_entity", bob)
    (info,) = heard.wait(bool)

    assert ["wall_e", "eve", "cart", "bob"] == [robot["name"] for robot in info["robots"]]


def test_a_loaded_world_replaces_the_served_one(live):
    world = {
        "name": "other",
        "waypoints": {"a": [0, 0], "b": [4, 0]},
        "lanes": [["a", "b"]],
        "robots": {"zoe": {"at": "a"}},
        "remap": {"drive/zoe": "zoe/navigate_to_pose"},
    }
    before = live.one("_world/info")["world"]["hash"]
    loaded = live.one("_world/load_world", {"resource_string": json.dumps(world)})
    info, graph = live.one("_world/info"), live.one("_world/route_graph")
    state = live.one("_world/get_simulation_state")["state"]["state"]
    live.one("_world/set_simulation_state", PLAYING)
    done = live.do("drive/zoe", {"pose": {"pose": {"position": {"x": 0.5}}}})

    assert (OK, "other", 0) == (loaded["result"], info["world"]["name"], state)
    assert before != info["world"]["hash"]
    assert ("other", 4) == (graph["name"], done["status"])
    assert "unknown_robot" == live.send("wall_e/wait", {"time": {"sec": 1}})["reason"]


def test_a_renamed_robot_publishes_under_its_new_name(live):
    live.hear("wall_e/wait/_action/status")
    live.do("wall_e/wait", {})
    world = {"robots": {"wall_e": {"at": [0, 0]}}, "remap": {"hold/wall_e": "wall_e/wait"}}
    live.one("_world/load_world", {"resource_string": json.dumps(world)})
    heard = live.hear("hold/wall_e/_action/status")
    live.one("_world/set_simulation_state", PLAYING)
    answer = live.send("wall_e/wait", {})

    assert heard.wait_for_status(answer["goal_id"], 4)

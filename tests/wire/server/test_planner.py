"""An external planner in a plain Zenoh client."""

from __future__ import annotations

import json
import threading

import pytest

from tests.patience import PATIENCE

A = "a" * 32
WORLD = {
    "waypoints": {"home": [1, 2], "shelf": [9, 2]},
    "lanes": [["home", "shelf"]],
    "robots": {"eve": {"at": "home", "planner": "external"}, "wall_e": {"at": "home"}},
}
EVE = "eve/navigate_to_pose"
UNKNOWN, TIMEOUT, NO_VALID_PATH = 200, 207, 208


def path(*points):
    """Return a planner's answer: a path through points."""
    return {"path": {"poses": [{"pose": {"position": {"x": x, "y": y}}} for x, y in points]}}


class Planner:
    """A planner that gives the same answer to all; bytes as they are.

    Args:
        tester: Whose session it uses.
        answer: Its answer, an error to reply with, or None to hold requests until it leaves.
    """

    def __init__(self, tester, answer):
        self.asked = []
        self.heard = threading.Event()
        self._answer = answer
        self._go = threading.Event()
        if answer is not None:
            self._go.set()
        key = tester.key("_planner/compute_path_to_pose")
        self._queryable = tester.session.declare_queryable(key, self._on_query)

    def say(self, answer):
        self._answer = answer
        self._go.set()

    def leave(self):
        self._go.set()
        self._queryable.undeclare()

    def _on_query(self, query):
        self.asked.append((json.loads(query.payload.to_bytes()), str(query.encoding), query.attachment.to_string()))
        self.heard.set()
        assert self._go.wait(PATIENCE)
        if isinstance(self._answer, Exception):
            query.reply_err(str(self._answer).encode())
        elif self._answer is not None:
            raw = self._answer if isinstance(self._answer, bytes) else json.dumps(self._answer).encode()
            query.reply(query.key_expr, raw)
        query.drop()


@pytest.fixture
def world(serve):
    """Return a client of a world with a robot that has an external planner."""
    return serve(WORLD, real_time_factor=0)


def ended(tester, goal):
    """Send a goal; return its final status, code and text."""
    end = tester.do(EVE, goal)
    return end["status"], end["result"]["error_code"], end["result"]["error_msg"]


def test_a_robot_follows_the_path_of_an_external_planner(world, go):
    """The request has ComputePathToPose's fields and the robot."""
    planner = Planner(world, path((1, 2), (1, 6), (4, 6)))
    end = ended(world, go(4, 6))
    ((asked, encoding, robot),) = planner.asked

    assert (4, 0, "") == end
    assert (4.0, 6.0) == world.where("eve")
    assert ("application/json;nav2_msgs/action/ComputePathToPose_Goal", "eve") == (encoding, robot)
    assert ["goal", "planner_id", "start", "use_start"] == sorted(asked)
    assert {"x": 1.0, "y": 2.0, "z": 0.0} == asked["start"]["pose"]["position"]
    assert {"x": 4.0, "y": 6.0, "z": 0.0} == asked["goal"]["pose"]["position"]
    assert asked["use_start"] is True


def test_goals_are_rejected_without_a_planner(world, go):
    before = world.send(EVE, go(4, 6))
    planner = Planner(world, path((4, 6)))
    during = world.send(EVE, go(4, 6))
    planner.leave()
    after = world.send(EVE, go(4, 6))

    assert [False, True, False] == [answer["accepted"] for answer in (before, during, after)]
    assert ["not_ready", "not_ready"] == [answer["reason"] for answer in (before, after)]
    assert 4 == world.do("wall_e/navigate_to_pose", go(9, 2))["status"]


@pytest.mark.parametrize(
    ("answer", "code", "text"),
    [
        (b"no json", UNKNOWN, "the planner's answer can't be read: "),
        ({"path": 3}, UNKNOWN, "the planner's answer can't be read: path: "),
        ({"colour": "red"}, UNKNOWN, "the planner's answer can't be read: colour: "),
        (b"", UNKNOWN, "the planner's answer can't be read: "),
        (b"[" * 2_000_000, UNKNOWN, "the planner's answer has 2000000 bytes; at most 1048576 are taken"),
        (ValueError("out of ideas"), UNKNOWN, "the planner answered with an error: out of ideas"),
        ({}, NO_VALID_PATH, "the planner gave a path without poses"),
        ({"error_code": 206, "error_msg": "a wall"}, 206, "a wall"),
    ],
)
def test_an_answer_without_a_path_aborts_the_goal(world, go, answer, code, text):
    planner = Planner(world, answer)
    status, error_code, error_msg = ended(world, go(4, 6))

    assert 1 == len(planner.asked)
    assert (6, code) == (status, error_code)
    assert error_msg.startswith(text)
    assert (1.0, 2.0) == world.where("eve")


def test_a_planner_that_drops_the_request_aborts_the_goal(world, go):
    planner = Planner(world, None)
    accepted = world.send(EVE, go(4, 6))
    assert planner.heard.wait(PATIENCE)
    planner.leave()
    result = world.result(EVE, accepted["goal_id"])["result"]

    assert (UNKNOWN, "the planner has left or has not answered") == (result["error_code"], result["error_msg"])


def test_a_planner_that_takes_too_long_aborts_the_goal(serve, go):
    """The timeout is in wall seconds, and a late answer is ignored."""
    tester = serve(WORLD, real_time_factor=0, planner_timeout=0.2)
    planner = Planner(tester, None)

    assert (6, TIMEOUT, "the planner has not answered in 0.2 s") == ended(tester, go(4, 6))

    planner.say(path((4, 6)))
    assert (1.0, 2.0) == tester.where("eve")


def test_lockstep_time_is_stopped_until_the_path_has_come(serve, go):
    """The state of time names the participant."""
    tester = serve(WORLD, clock="lockstep")
    planner = Planner(tester, None)
    tester.one("_world/time/join", {"name": "nurse"})
    state = tester.hear("_world/time/state")
    commands = [
        {"robot": "eve", "action": "navigate_to_pose", "goal_id": A, "goal": go(1, 6)},
        {"robot": "wall_e", "action": "navigate_to_pose", "goal": go(9, 2)},
    ]
    request = {"participant": "nurse", "epoch": 0, "until": None, "wake": ["result"], "commands": commands}
    advance = tester.begin("_world/time/advance", request)
    state.wait(lambda bodies: bodies and ["_planner"] == bodies[-1]["waiting_for"])
    stood = tester.one("_world/time/state")["now"]
    planner.say(path((1, 2), (1, 6)))
    granted = advance.one()

    assert 0.0 == stood
    assert (4.0, "event", A) == (granted["now"], granted["reason"], granted["events"][0]["goal_id"])
    assert [] == [name for name in tester.one("_world/time/state")["waiting_for"] if name == "_planner"]

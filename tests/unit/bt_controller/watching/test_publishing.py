"""The state of trees on the network, as any Zenoh client sees it."""

from __future__ import annotations

import json
import threading

import pytest
import zenoh
import zenoh.ext
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_controller.loading.trees import Plan
from bt_controller.running.mission import Mission
from bt_controller.watching.publishing import Publisher
from hmrsim_zenoh.wire.keys import Keys
from tests.wire.server.conftest import Heard, Served

TREE = "wall_e/_tree"


class Step(Behaviour):
    """Has the status and the message that a test gives it."""

    outcome = Status.RUNNING

    def update(self):
        return self.outcome


class Controller:
    """Runs a tree for each of some robots, a tick whenever the test says so."""

    def __init__(self, session, *robots):
        plan = Plan("test", lambda: Step("Root"), takes_robot=False, confirmed=False)
        self.missions = {robot: Mission(robot, plan) for robot in robots}
        self.publisher = Publisher(session, Keys(), list(self.missions.values()))

    def tick(self, robot, now, message="", status=Status.RUNNING):
        """Tick a tree: it says something, and has a status."""
        mission = self.missions[robot]
        mission.root.feedback_message, mission.root.outcome = message, status
        mission.tick(now)
        self.publisher.ticked(mission, now)

    def end(self):
        for mission in self.missions.values():
            mission.interrupt()
        self.publisher.close()


@pytest.fixture
def served():
    """Serve the small world of the tests."""
    served = Served()
    host = served.host(real_time_factor=0)
    host.start()
    yield lambda: served.tester(host)
    served.close()


@pytest.fixture
def tester(served):
    """Return an outsider."""
    return served()


@pytest.fixture
def control(served):
    """Return what begins to control robots; in the end the controllers end."""
    controllers = []

    def begin(*robots):
        own = served()
        controllers.append(Controller(own.session, *robots))
        # Once this is answered the declarations that went before it have come, too.
        own.one("_world/info")
        return controllers[-1]

    yield begin
    for controller in controllers:
        controller.publisher.close()


def told(messages):
    """Return time, status, message and whether the tree has ended, of each message."""
    return [(body["sim_time"], body["status"], body["nodes"][0]["message"], body["ended"]) for body in messages]


def test_a_get_is_answered_with_the_latest(control, tester):
    control("wall_e").tick("wall_e", 1.5, "on its way")
    (reply,) = tester.ask(TREE)

    node = {"depth": 0, "symbol": "-->", "kind": "Step", "name": "Root", "status": "RUNNING", "message": "on its way"}
    state = {"robot": "wall_e", "sim_time": 1.5, "tick": 1, "status": "RUNNING", "ended": False, "nodes": [node]}
    assert (True, "hmrsim/wall_e/_tree", state | {"blackboard": {}}, "application/json") == (
        reply.ok,
        reply.key,
        reply.body,
        reply.encoding,
    )


def test_a_tree_that_was_not_ticked_can_be_got(control, tester):
    control("wall_e")

    assert (None, 0, "INVALID") == tuple(tester.one(TREE)[key] for key in ("sim_time", "tick", "status"))


@pytest.mark.parametrize("key", [TREE, "*/_tree", "nobody/_tree"])
def test_without_a_controller_there_is_no_answer(tester, key):
    """The simulator has no trees; it does not refuse the query, and the query ends at once."""
    assert [] == tester.ask(key)


def test_each_controller_answers_for_its_robots(control, tester):
    control("wall_e", "eve")
    control("cart")

    assert ["hmrsim/cart/_tree"] == [reply.key for reply in tester.ask("cart/_tree")]
    keys = ["hmrsim/cart/_tree", "hmrsim/eve/_tree", "hmrsim/wall_e/_tree"]
    assert keys == sorted(reply.key for reply in tester.ask("*/_tree"))


def test_the_simulators_own_keys_are_answered_once(control, tester):
    control("wall_e")

    assert [(True, "hmrsim/wall_e/odom")] == [(reply.ok, reply.key) for reply in tester.ask("wall_e/odom")]


def test_changes_are_published(control, tester):
    controller = control("wall_e")
    heard = tester.hear(TREE)
    tester.one(TREE)
    controller.tick("wall_e", 1.0, "here")
    controller.tick("wall_e", 2.0, "here")
    controller.tick("wall_e", 3.0, "there")
    controller.tick("wall_e", 4.0, status=Status.SUCCESS)

    assert [
        (1.0, "RUNNING", "here", False),
        (3.0, "RUNNING", "there", False),
        (4.0, "SUCCESS", "", True),
    ] == told(heard.wait(lambda bodies: len(bodies) == 3))


def test_the_end_of_the_controller_is_published(control, tester):
    controller = control("wall_e")
    heard = tester.hear(TREE)
    tester.one(TREE)
    controller.tick("wall_e", 1.0)
    controller.end()

    messages = told(heard.wait(lambda bodies: len(bodies) == 2))
    assert [(1.0, "RUNNING", "", False), (1.0, "INVALID", "", True)] == messages
    assert [] == tester.ask(TREE)


def test_without_subscribers_no_snapshot_is_made(control, tester, monkeypatch):
    """Subscribers of other topics do not count as subscribers of trees."""
    controller = control("wall_e")
    tester.hear("wall_e/odom")
    tester.one("wall_e/odom")
    looked = []
    monkeypatch.setattr(Mission, "snapshot", lambda *_args, **_options: looked.append(1))
    controller.tick("wall_e", 1.0)
    controller.end()

    assert [] == looked


def test_advanced_subscribers_get_the_latest_first(control, tester):
    control("wall_e").tick("wall_e", 1.5, "on its way")
    heard = Heard()
    subscriber = zenoh.ext.declare_advanced_subscriber(
        tester.session,
        tester.key(TREE),
        zenoh.handlers.Callback(heard.on_sample, indirect=False),
        history=zenoh.ext.HistoryConfig(),
    )

    assert [(1.5, "RUNNING", "on its way", False)] == told(heard.wait(lambda bodies: len(bodies) == 1))
    subscriber.undeclare()


def test_what_is_published_is_json(control, tester):
    control("wall_e").tick("wall_e", 1.5, "zur Tür")

    (reply,) = tester.session.get(tester.key(TREE))
    assert "zur Tür" == json.loads(reply.ok.payload.to_string())["nodes"][0]["message"]


def test_it_can_be_closed_while_it_is_asked(tester, control):
    """The threads that answer queries do not hold what the end undeclares."""
    over = threading.Event()

    def ask():
        while not over.is_set():
            # Zenoh may lose a query to a queryable that is just undeclared.
            list(tester.session.get(tester.key(TREE), timeout=0.5))

    asking = threading.Thread(target=ask)
    asking.start()
    try:
        for _ in range(20):
            control("wall_e").end()
    finally:
        over.set()
        asking.join()

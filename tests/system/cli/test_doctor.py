"""``hmrsim doctor``, with a simulator, with ROS's tokens, and with no peer."""

from __future__ import annotations

import json
import os
import time

import pytest

from hmrsim.cli import main
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import Endpoint, Kind, Node
from hmrsim_zenoh.ros2.wires import RmwZenoh
from hmrsim_zenoh.wire.session import SessionOptions, open_client, open_server
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.simulation import SMALL_WORLD

NOBODY = "tcp/127.0.0.1:1"
CLIENT = Endpoint(Kind.CLIENT, "/wall_e/wait/_action/send_goal", "nav2_msgs::action::dds_::Wait_SendGoal_", "RIHS01_00")


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for name in list(os.environ):
        if name.startswith(("ROS_", "RMW_", "ZENOH_")):
            monkeypatch.delenv(name)


@pytest.fixture
def doctor(capsys):
    """Return the function that runs the command and returns exit code, output and errors."""

    def run(options, *words, timeout=PATIENCE):
        code = main(["doctor", "--connect", *options.connect, f"--timeout={timeout}", *words])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


@pytest.fixture
def router():
    """Return a session that is only a router, and its endpoint."""
    session, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
    with session:
        yield session, SessionOptions(connect=endpoints)


def declare(session, domain=0, endpoint=CLIENT):
    """Declare the tokens of a node with one endpoint."""
    node, liveliness, zid = Node("/", "nav"), session.liveliness(), str(session.info.zid())
    texts = (keys.node_token(domain, zid, 0, node), keys.endpoint_token(domain, zid, (0, 1), node, endpoint))
    return [liveliness.declare_token(text) for text in texts]


def test_a_healthy_simulator_is_summarized(doctor):
    with served_world() as options:
        code, out, err = doctor(options)

    lines = out.splitlines()
    # The simulator is in this process, and may say that the machine can't keep up.
    assert (0, []) == (code, [line for line in err.splitlines() if not line.startswith("[WARNING] the machine")])
    assert f"network     {options.connect[0]}: the simulator is the router" == lines[0]
    assert lines[1].endswith(", contract 1, prefix hmrsim, world 'small'")
    assert "robots      wall_e, eve (17 actions each), cart (15 actions); 3 of 3 with a liveliness token" == lines[3]
    assert ["ROS         domain 0: no nodes", "", "nothing is wrong"] == lines[4:]


def test_a_domain_without_a_simulator_gets_advice_on_enabling_ros(doctor):
    with served_world() as options:
        code, out, _ = doctor(options, "--ros-domain-id", "7")

    assert (1, "error: the simulator does not serve ROS 2; start `hmrsim run` with --ros2") == (
        code,
        out.splitlines()[-1],
    )


def test_everything_as_json(doctor, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    with served_world() as options, open_client(options) as session, session.liveliness().declare_token("@ros2_lv/7/x"):
        tokens = declare(session, 7)
        code, out, _ = doctor(options, "--json")
        zid = str(session.info.zid())
        del tokens

    found = json.loads(out)
    node = {
        "name": "/nav",
        "session": zid,
        "simulator": False,
        "endpoints": [
            {
                "kind": "client",
                "name": CLIENT.name,
                "type": "nav2_msgs/action/Wait_SendGoal",
                "hash": "RIHS01_00",
                "qos": "::,10:,:,:,,",
            }
        ],
    }
    assert 1 == code
    assert {
        "domain": 7,
        "domains": {"7": [node]},
        "unreadable": ["@ros2_lv/7/x"],
        "distros": [],
        "incomplete_actions": {},
    } == found["ros2"]
    assert {"ROS_DOMAIN_ID": "7"} == found["environment"]
    assert ["cart", "eve", "wall_e"] == found["simulator"]["robots_alive"]
    assert ["no_ros2", "no_server", "unreadable_tokens"] == [one["kind"] for one in found["problems"]]
    assert found["simulator"]["session"] in found["network"]["routers"]


@pytest.mark.parametrize("text", ["@ros2_lv", "@ros2_lv/0", "@ros2_lv/0/a/0/0/NN/%/%", "@ros2_lv/x/a/0/0/NN/%/%/n"])
def test_a_token_of_unknown_format_is_only_reported(doctor, router, text):
    session, options = router
    with session.liveliness().declare_token(text):
        code, out, _ = doctor(options)

    assert 1 == code
    assert f"warning: 1 liveliness tokens are not in rmw_zenoh's format: '{text}'; update" in out


def test_two_simulators_with_one_prefix_are_reported(doctor):
    with served_world() as options, open_client(options) as session, Client(options) as client:
        key = "hmrsim/_world/info"
        info = client.get(key)
        with (
            session.declare_queryable(key, lambda query: query.reply(key, info)),
            session.declare_queryable("hmrsim/_planner/compute_path_to_pose", lambda query: query.drop()),
        ):
            end = time.monotonic() + PATIENCE
            while not client.info()["planner_present"] and time.monotonic() < end:
                pass
            code, out, _ = doctor(options)

    assert 1 == code
    assert "error: 2 simulators have the same prefix: a request may reach any of them, or all; end one of them" in out
    assert "planner" not in out


def test_actions_of_a_lost_robot_are_not_counted(doctor):
    fault = json.dumps({"type": "messages_lost", "robot": "wall_e"}).encode()
    with served_world(wires=(RmwZenoh(7, ("kilted",)),)) as options, Client(options) as client:
        client.get("hmrsim/_world/inject_fault", payload=fault)
        end, out = time.monotonic() + PATIENCE, ""
        while "35 of 55 action names whole" not in out and time.monotonic() < end:
            _, out, _ = doctor(options, "--ros-domain-id", "7")

    assert "; 35 of 55 action names whole; " in out
    assert "error: wall_e is unreachable: there is no liveliness token" in out


def test_participants_that_hold_the_time_are_named(doctor):
    with served_world(clock="lockstep", participants=("nurses",)) as options:
        code, out, _ = doctor(options)

    assert 1 == code
    assert "lockstep    no participants; time waits for nurses" in out
    assert "error: time stands at 0 s: waiting for nurses to join in lockstep; start a controller" in out


def test_a_robot_without_its_external_planner_is_named(doctor):
    robots = {"eve": {"type": "nurse", "at": "home", "planner": "external"}}
    with served_world({**SMALL_WORLD, "robots": robots, "remap": {}}) as options:
        alone = doctor(options)
        with open_client(options) as session, Client(options) as client:
            planner = session.declare_queryable("hmrsim/_planner/compute_path_to_pose", lambda query: query.drop())
            end = time.monotonic() + PATIENCE
            while not client.info()["planner_present"] and time.monotonic() < end:
                pass
            attended = doctor(options)
            planner.undeclare()

    assert "error: eve needs an external planner, but there is none; start one" in alone[1]
    assert (1, 0) == (alone[0], attended[0])
    assert "planner     an external one is available" in attended[1]


def test_ros_actions_are_counted_and_an_incompatible_client_is_reported(doctor):
    with served_world(wires=(RmwZenoh(7, ("kilted",)),)) as options, open_client(options) as session:
        tokens = declare(session, 7)
        end, out = time.monotonic() + PATIENCE, ""
        while "55 of 55 action names whole; types of kilted\n" not in out and time.monotonic() < end:
            code, out, _ = doctor(options, "--ros-domain-id", "7")
        elsewhere = doctor(options)
        del tokens

    ros = [line for line in out.splitlines() if line.startswith("ROS")]
    assert ros[0].startswith("ROS         domain 7: the simulator, with ")
    assert ros[0].endswith("; 55 of 55 action names whole; types of kilted")
    assert ["ROS         domain 7: 1 node of others: /nav (1 client)"] == ros[1:]
    assert (1, 1) == (code, out.count("error: "))
    assert f"error: /nav is incompatible with {CLIENT.name}: its hash is RIHS01_00 (of an unknown distribution" in out
    assert "error: the simulator is in ROS domain 7, not in 0; `export ROS_DOMAIN_ID=7`" in elsewhere[1]


def test_ros_nodes_without_a_simulator_get_advice(doctor, router):
    session, options = router
    tokens = declare(session)
    code, out, _ = doctor(options)
    del tokens

    assert 1 == code
    assert f"network     {options.connect[0]}: a router\nsimulator   none\n" in out
    assert "ROS         domain 0: 1 node of others: /nav (1 client)\n" in out
    assert "no simulator; start `hmrsim run WORLD --ros2 --connect tcp/" in out


def test_a_router_without_peers_exits_with_3(doctor, router):
    code, out, err = doctor(router[1])

    assert (3, "", 1) == (code, out, err.count("\n"))
    assert "a Zenoh peer answers, but there is no simulator and no ROS node; start `hmrsim run" in err


def test_no_simulator_exits_with_3_and_advice(doctor):
    code, out, err = doctor(SessionOptions(connect=(NOBODY,)), "--timeout", "0.3", "--json")

    found = json.loads(out)
    (problem,) = found.pop("problems")
    assert (3, "nobody_there", "error") == (code, problem["kind"], problem["severity"])
    assert problem["remedy"].startswith("start `hmrsim run WORLD`")
    assert {
        "network": {"endpoints": [NOBODY], "routers": [], "peers": []},
        "prefixes": [],
        "simulator": None,
        "ros2": {"domain": 0, "domains": {}, "unreadable": [], "distros": [], "incomplete_actions": {}},
        "environment": {},
    } == found
    assert err.startswith(f"hmrsim: no answer from {NOBODY}; start `hmrsim run WORLD`")


def test_another_prefix_is_named(doctor):
    with served_world() as options:
        code, out, _ = doctor(options, "--prefix", "lab")

    assert 1 == code
    assert "error: no simulator has the prefix 'lab'; there is 'hmrsim'; use --prefix hmrsim\n" in out


@pytest.mark.parametrize("domain", ["233", "-1", "x", "1.5", "²"])
def test_a_malformed_domain_exits_with_2(doctor, domain):
    code, out, err = doctor(SessionOptions(connect=(NOBODY,)), f"--ros-domain-id={domain}")

    assert (2, "") == (code, out)
    assert "is not a domain id; expected a whole number from 0 to 232" in err

"""Malformed ROS messages neither silence nor crash the simulator, nor fill its memory."""

from __future__ import annotations

import random
import struct
import uuid

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from tests.patience import PATIENCE
from tests.profiles import examples
from tests.simulation import SMALL_WORLD
from tests.system.ros2.processes import simulator
from tests.wire.ros2.client import CDR, NO_ID, SUCCEEDED, RosClient, attachment, get_state, goal_to, ros_action

GID = bytes(range(16))
ACTIONS = (
    "navigate_to_pose",
    "navigate_through_poses",
    "follow_waypoints",
    "wait",
    "spin",
    "back_up",
    "pickup",
    "place",
)
MORE_THAN_ANY = struct.pack("<I", 2**32 - 1)
MAX_GROWTH = 150.0
"""MB that the simulator may grow by under all that these tests do to it; a flood of them all is some GB."""


@pytest.fixture(scope="module")
def running():
    """Return the simulator that all tests share."""
    with simulator(SMALL_WORLD, "--real-time-factor", 50) as running:
        yield running


@pytest.fixture(scope="module")
def ros(running):
    """Return a ROS node, once everything is declared."""
    with RosClient(running.endpoint) as client:
        for action in ACTIONS:
            client.action(f"/wall_e/{action}").wait()
        client.service("/wall_e/amcl/get_state", get_state()).wait()
        yield client


def services(action):
    """Return the services of one of wall_e's actions: name, type and a valid request."""
    type_, name = ros_action(action), f"/wall_e/{action}/_action"
    some_id = {"goal_id": {"uuid": list(uuid.uuid4().bytes)}}
    info = {"goal_info": {**some_id, "stamp": {"sec": 0, "nanosec": 0}}}
    goal = type_.send_goal.request.decode(CDR + bytes(4096))["goal"]
    return [
        (f"{name}/send_goal", type_.send_goal, type_.send_goal.request.encode({**some_id, "goal": goal})),
        (f"{name}/get_result", type_.get_result, type_.get_result.request.encode(some_id)),
        (f"{name}/cancel_goal", type_.cancel_goal, type_.cancel_goal.request.encode(info)),
    ]


SERVICES = [
    *(service for action in ACTIONS for service in services(action)),
    ("/wall_e/amcl/get_state", get_state(), CDR + b"\0"),
]


def ask(ros, key, payload, attached):
    """Send a query like rmw_zenoh, with any contents; return all replies."""
    return list(
        ros.session.get(
            key,
            payload=payload,
            attachment=attached,
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=PATIENCE,
        )
    )


def answer(ros, service, payload, attached):
    """Query one of `SERVICES`; return the only reply and its attachment."""
    name, type_, _ = service
    replies = ask(ros, ros.key(name, type_.dds_name, type_.hash), payload, attached)
    assert 1 == len(replies), (name, payload[:40], attached)
    (reply,) = replies
    assert reply.ok is not None, reply.err.payload.to_bytes()
    sequence, _, length, gid = struct.unpack("<qqB16s", reply.ok.attachment.to_bytes())
    assert 16 == length
    return type_.response.decode(reply.ok.payload.to_bytes()), sequence, gid


def still_serves(ros):
    """Return whether a goal of a correct client still succeeds."""
    drive = ros.action("/wall_e/navigate_to_pose").wait()
    return drive.do(goal_to(1, 2))[0] == SUCCEEDED


@st.composite
def spoiled(draw, good):
    """Return bytes that begin like a valid message."""
    data = bytearray(good)
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(data)))
        change = draw(st.sampled_from(["cut", "put", "set", "huge"]))
        if change == "cut":
            del data[at:]
        elif change == "put":
            data[at:at] = draw(st.binary(max_size=40))
        elif change == "set" and at < len(data):
            data[at] = draw(st.integers(0, 255))
        elif change == "huge":
            data[at : at + 4] = MORE_THAN_ANY
    return bytes(data)


def attachments():
    """Return a strategy for attachments of a request."""
    good = attachment(5, GID)
    return st.one_of(
        st.just(good), st.none(), st.binary(max_size=80), st.binary(min_size=33, max_size=33), spoiled(good)
    )


@examples(400)
@given(data=st.data())
def test_every_request_is_answered_once(ros, data):
    service = data.draw(st.sampled_from(SERVICES))
    payload = data.draw(st.one_of(st.binary(max_size=300), spoiled(service[2])))
    attached = data.draw(attachments())
    _, sequence, gid = answer(ros, service, payload, attached)

    readable = attached is not None and len(attached) == 33 and attached[16] == 16
    assert (sequence, gid) == (struct.unpack("<qqB16s", attached)[::3] if readable else (0, NO_ID))


@pytest.mark.parametrize("size", [2**20 + 1, 5 * 2**20])
def test_requests_of_megabytes_are_answered(ros, size):
    noise = random.Random(size).randbytes(size)
    for service in SERVICES[:6] + SERVICES[-1:]:
        answer(ros, service, service[2] + noise, attachment(1, GID))
        answer(ros, service, noise, noise)


@pytest.mark.parametrize("action", ["pickup", "navigate_through_poses", "follow_waypoints"])
def test_impossible_lengths_allocate_no_memory(running, ros, action):
    service = services(action)[0]
    before = running.resident
    for at in range(20, min(len(service[2]), 400), 4):
        payload = bytearray(service[2])
        payload[at : at + 4] = MORE_THAN_ANY
        answer(ros, service, bytes(payload), attachment(1, GID))

    assert MAX_GROWTH > running.resident - before


def test_a_goal_with_nan_is_rejected(ros):
    drive = ros.action("/wall_e/navigate_to_pose").wait()
    request = bytearray(services("navigate_to_pose")[0][2])
    request[36:44] = struct.pack("<d", float("nan"))
    values = drive.type.send_goal.request.decode(bytes(request))

    assert values["goal"]["pose"]["pose"]["position"]["x"] != values["goal"]["pose"]["pose"]["position"]["x"]
    assert not drive.send_goal.call(bytes(request))["accepted"]


@pytest.mark.parametrize(
    "key",
    [
        "0/**",
        "0/*/*/_action/send_goal/*/*",
        "0",
        "0/wall_e",
        "0/wall_e/navigate_to_pose/_action/send_goal",
        "0/nobody/navigate_to_pose/_action/send_goal/a/b",
        "0/wall_e/fly/_action/send_goal/a/b",
        "0/wall_e/navigate_to_pose/_action/give_up/a/b",
        f"0/{'/'.join('a' * 2000)}",
        "0/%/é/🤖/%F0",
    ],
)
def test_a_query_on_an_unknown_key_gets_no_reply(ros, key):
    """Another node may serve it."""
    assert [] == ask(ros, key, b"", attachment(1, GID))


@pytest.mark.parametrize(
    ("type_", "hash_"), [("a", "b"), ("nav2_msgs::action::dds_::NavigateToPose_SendGoal_", "b"), ("%", "é%F0")]
)
def test_wrong_types_are_answered(ros, type_, hash_):
    """A client without a reply would wait forever."""
    (name, right, payload) = SERVICES[0]
    (reply,) = ask(ros, ros.key(name, type_, hash_), payload, attachment(1, GID))

    assert not right.response.decode(reply.ok.payload.to_bytes())["accepted"]


def test_malformed_tokens_are_ignored(ros):
    endings = ["", "/x", "/0", "/z/0/0/NN", "/z/0/0/SC/%/%/n", "/z/0/0/SC/%/%/n/%x/t/h/q/b/c", "/z/a/b/MP/%/%//%/t/h/q"]
    endings += [f"/z/0/{number}/SC/%/%wall_e/n/%wall_e%wait%_action%send_goal/t/h/:::" for number in range(50)]
    tokens = [ros.session.liveliness().declare_token(f"@ros2_lv/0{ending}") for ending in endings if "//" not in ending]
    for token in tokens:
        token.undeclare()

    assert still_serves(ros)


def test_random_bytes_published_by_others_are_ignored(ros):
    noise = random.Random(1)
    for name, type_, _ in SERVICES:
        ros.session.put(ros.key(name, type_.dds_name, type_.hash), noise.randbytes(200), attachment=noise.randbytes(33))

    assert still_serves(ros)


def test_waiters_for_results_are_bounded(running, ros):
    goal = ros.action("/cart/wait").wait().send({"time": {"sec": 10_000_000}})
    before = running.resident
    with RosClient(running.endpoint, node="crowd") as crowd:
        service = crowd.service("/cart/wait/_action/get_result", ros_action("wait").get_result)
        waiting = [service.begin(CDR + goal.id) for _ in range(5000)]
        assert still_serves(ros)
    goal.cancel()

    assert 5000 == len(waiting)
    assert MAX_GROWTH > running.resident - before
    assert still_serves(ros)


def test_goals_are_served_after_all_attacks(running, ros):
    assert still_serves(ros)
    assert running.process.poll() is None


def test_malformed_requests_are_logged_once_per_client():
    with simulator(SMALL_WORLD) as running:
        with RosClient(running.endpoint) as ros:
            ros.action("/wall_e/navigate_to_pose").wait()
            for gid in (GID, GID[::-1]):
                for sequence in range(20):
                    answer(ros, SERVICES[0], b"\0\1\0\0no goal", attachment(sequence, gid))
            for _ in range(20):
                answer(ros, SERVICES[0], SERVICES[0][2], b"who")
        assert 0 == running.end()
        log = running.log.read_text()
    told = [line for line in log.splitlines() if "[WARNING]" in line and "navigate_to_pose" in line]

    assert "Traceback" not in log
    assert 2 == sum("NavigateToPose_SendGoal_Request" in line for line in told), log
    assert 1 == sum("attach" in line for line in told), log

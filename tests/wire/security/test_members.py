"""Rights of members with certificates, and the errors for denied commands."""

from __future__ import annotations

import json
import threading
from dataclasses import replace

import pytest
import zenoh

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.errors import BadOptions, ConnectionDenied, Denied, PrefixTaken, SimulatorNotFound
from hmrsim_zenoh.security.check import attempts
from hmrsim_zenoh.security.keystore import SESSION
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client, open_server
from tests.cases import case
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.wire.ros2.client import SUCCEEDED, RosClient, goal_to
from tests.wire.security.conftest import GOAL, Ledger, of_node, strangers

WAIT = Wait.Goal(time=Duration(sec=0, nanosec=10_000_000))


def test_a_denied_goal_ends_at_once_and_names_who_may_drive_the_robot(secured):
    with Client(secured.of("nurses")) as client:
        assert client.action_client("wall_e", registry()["wait"]).send_goal(WAIT).result(PATIENCE).error_code == 0
        goal = client.action_client("eve", registry()["wait"]).send_goal(WAIT)

        with pytest.raises(
            Denied, match=r"'nurses' may not ask on 'hmrsim/eve/.*who may: simulator, porters, fleet, op"
        ):
            goal.result(PATIENCE)


def test_a_viewer_reads_but_may_not_call_services_with_effects(secured):
    with Client(secured.of("viewer")) as client:
        assert client.info()["robots"]
        assert client.get("hmrsim/_world/get_entities", payload=b"{}")
        with pytest.raises(Denied, match="denied, as no rule allows it; who may: simulator, operator"):
            client.get("hmrsim/_world/load_world", payload=b"{}")


def test_a_ros_node_drives_as_over_plain_tcp(secured):
    options = secured.of("nurses")
    with RosClient(options.connect[0], **of_node(options)) as ros:
        client = ros.action("/wall_e/navigate_to_pose").wait()
        goal = client.send(goal_to(1.0, 0.0))

        assert goal.accepted
        assert SUCCEEDED == goal.result()[0]
        client.wait_for_status(goal.id, SUCCEEDED)
        client.wait_for_feedback(goal.id)


def test_controllers_of_some_robots_take_part_in_lockstep(secured):
    there = SessionOptions(listen=("tls/127.0.0.1:0",), secure=secured.store.path)
    with served_world(options=there, clock="lockstep") as options:
        mine = replace(options, secure=secured.store.path, role="nurses")
        with Client(mine, clock="lockstep", name="nurses") as client:
            client.sleep(2.0)

            assert client.now == 2.0


def test_goals_in_lockstep_are_for_a_controllers_own_robots(secured):
    """The client's other goals continue, and the simulator executes no command that the member may not give."""
    there = SessionOptions(listen=("tls/127.0.0.1:0",), secure=secured.store.path)
    ledger = Ledger()
    with served_world(options=there, clock="lockstep", sinks=(ledger,)) as options:
        mine = replace(options, secure=secured.store.path, role="nurses")
        with Client(mine, clock="lockstep", name="nurses") as client:
            other = client.action_client("eve", registry()["wait"]).send_goal(WAIT)
            own = client.action_client("wall_e", registry()["wait"]).send_goal(WAIT)

            assert own.result(PATIENCE).error_code == 0
            with pytest.raises(Denied, match=r"'nurses' may not ask on 'hmrsim/eve/.*who may: simulator, por"):
                other.result(PATIENCE)
        for name, command, allowed in (
            ("nurses", {"robot": "eve", "action": "wait", "goal": GOAL["goal"]}, False),
            ("nurses", {"robot": "eve", "action": "wait", "cancel": "00" * 16}, False),
            ("nurses", {"robot": "*", "action": "wait", "goal": GOAL["goal"]}, False),
            ("nurses", {"robot": "", "action": "", "goal": {}}, False),
            ("fleet", {"robot": "_world", "action": "simulate_steps", "goal": {"steps": 1}}, False),
            ("nurses", {"robot": "wall_e", "action": "wait", "goal": GOAL["goal"]}, True),
            ("fleet", {"robot": "eve", "action": "wait", "goal": GOAL["goal"]}, True),
        ):
            ledger.commands.clear()
            with case(f"{name}: {command}"), open_client(replace(mine, role=name)) as session:
                assert [] == _advanced(session, "time/advance", name, command)
                assert [] == _advanced(session, "time/advance/porters", name, command)
                assert [allowed] == _advanced(session, f"time/advance/{name}", name, command)
                assert ["SendGoal"] * allowed == ledger.commands


def _advanced(session, topic, name, command):
    """Join, advance with a command and leave; return for each reply whether the command was accepted."""

    def ask(topic, **request):
        return list(session.get(f"hmrsim/_world/{topic}", payload=json.dumps(request), timeout=PATIENCE))

    (joined,) = ask("time/join", name=name)
    epoch = json.loads(joined.ok.payload.to_bytes())["epoch"]
    replies = ask(topic, participant=name, epoch=epoch, until=0.0, commands=[command])
    ask("time/leave", participant=name)
    granted = [json.loads(reply.ok.payload.to_bytes()) for reply in replies]
    return ["error" not in each["accepted"][0] for each in granted]


def test_a_second_simulator_of_the_prefix_is_refused(secured):
    """It sees the first one's claim whether it listens or not, and a client can't forge one."""
    there = SessionOptions(connect=secured.options.connect, secure=secured.store.path)
    for options in (there, replace(there, listen=("tls/127.0.0.1:0",))):
        with (
            pytest.raises(PrefixTaken, match="another simulator serves prefix 'hmrsim'"),
            served_world(options=options),
        ):
            pass
    with open_client(secured.of("operator")) as session, open_client(replace(there, role="simulator")) as other:
        made_up = session.liveliness().declare_token("hmrsim/@simulator/0/serving")
        claims = list(other.liveliness().get("hmrsim/@simulator/*/*", timeout=PATIENCE))
        made_up.undeclare()

    assert 1 == len(claims)


def test_the_certificate_of_a_client_does_not_make_a_simulator(secured):
    """A member that listens at the simulator's endpoint gets no requests, and clients ignore its answers."""
    store = secured.store
    fake = SessionOptions(listen=("tls/127.0.0.1:0",), secure=store.path, role="operator")
    session, endpoints = open_server(fake)
    asked = []
    with session, open_client(replace(secured.of("viewer"), connect=endpoints)) as client:
        queryable = session.declare_queryable("**", lambda query: asked.append(query.key_expr))
        token = session.liveliness().declare_token("hmrsim/_world/alive")

        assert [] == list(client.get("hmrsim/_world/info", timeout=2.0))
        assert [] == list(client.liveliness().get("hmrsim/_world/alive", timeout=2.0))
        queryable.undeclare()
        token.undeclare()
    assert [] == asked


def test_a_client_that_is_not_let_in_gets_the_reason(secured, tmp_path):
    known, plain = (
        replace(secured.options, timeout=0.5),
        tuple(each.replace("tls", "tcp") for each in secured.options.connect),
    )
    other = secured.store.stranger("viewer", 1.0, tmp_path / "other")
    (tmp_path / "other" / "ca.cert.pem").write_bytes((secured.store.path / "enclaves/viewer/cert.pem").read_bytes())
    for options, text in (
        (known, "a certificate is required; give it with --secure DIR"),
        (replace(known, connect=plain), "TLS is spoken there; give --secure DIR, and the endpoint with tls/"),
        (replace(known, secure=other.folder), "its certificate is not valid for 127.0.0.1 here"),
    ):
        with case(text), pytest.raises(ConnectionDenied, match=f"denied by t.*: {text}"):
            open_client(options)


def test_a_certificate_of_another_authority_is_named_as_the_reason(secured, tmp_path):
    found = strangers(secured, tmp_path)["another authority"].zenoh_config
    options = replace(secured.options, timeout=0.5, secure=found.parent)

    with pytest.raises(
        ConnectionDenied, match="with the certificate of 'operator': the certificate is of another authority"
    ):
        open_client(options)


def test_a_revoked_member_sees_no_simulator_and_a_hint(secured):
    """Its certificate is valid, so it gets in but may do nothing."""
    options = replace(secured.options, secure=secured.store.path.with_name("former"))
    with Client(options) as client, pytest.raises(SimulatorNotFound, match="hidden from 'former', who may be revoked"):
        client.wait_for_simulator(0.3)


def test_a_connection_ends_when_its_certificate_expires(secured, tmp_path):
    key, payload = "hmrsim/wall_e/wait/_action/cancel_goal", b"{}"

    def cancel(options):
        with open_client(options) as session:
            return [reply.ok is not None for reply in session.get(key, payload=payload, timeout=PATIENCE)]

    brief = secured.brief(tmp_path / "brief", lambda: cancel(secured.of("operator")))
    secured.ledger.commands.clear()
    gone = threading.Event()
    with open_client(replace(secured.options, zenoh_config=brief.folder / SESSION)) as session:
        session.info.declare_transport_events_listener(
            lambda event: gone.set() if event.kind == zenoh.SampleKind.DELETE else None
        )
        assert [True] == [reply.ok is not None for reply in session.get(key, payload=payload, timeout=PATIENCE)]
        assert gone.wait(PATIENCE)

        assert [] == [reply.ok for reply in session.get(key, payload=payload, timeout=1.0) if reply.ok]
    assert ["CancelGoal"] == secured.ledger.commands


def test_a_simulator_without_tls_is_reported(secured):
    with served_world() as options:
        there = tuple(each.replace("tcp", "tls") for each in options.connect)
        mine = replace(secured.of("viewer"), connect=there, timeout=0.5)

        with pytest.raises(ConnectionDenied, match="it does not speak TLS; is the simulator started"):
            open_client(mine)


def test_insecure_endpoints_are_refused_before_connecting(secured):
    for options, text in (
        (
            replace(secured.of("viewer"), connect=("tcp/10.0.0.7:7447",)),
            "--connect .* is not encrypted; .* tls/10.0.0.7:7447",
        ),
        (SessionOptions(secure=secured.store.path, listen=("ws/[::]:1",)), "--listen .* is not encrypted; .* tls/"),
        (replace(secured.of("viewer"), connect=("tls/[::1]:7447",)), "--connect .* no certificate at an IPv6 address"),
        (SessionOptions(role="viewer"), "--role viewer: it is for --secure DIR, which is missing"),
    ):
        with case(text), pytest.raises(BadOptions, match=text):
            open_client(options)


def test_the_policy_check_passes_at_the_simulator_and_executes_nothing(secured):
    secured.ledger.commands.clear()
    found = list(attempts(secured.store, secured.options))

    assert [] == [one for one in found if not one.as_expected]
    assert {"nurses", "porters", "fleet", "viewer", "operator"} < {one.who for one in found}
    assert {"'viewer', expired", "'former', revoked"} < {one.who.replace("nurses", "viewer") for one in found}
    assert any(one.done for one in found)
    assert {("nurses", "wall_e", True), ("nurses", "eve", False), ("viewer", "wall_e", False)} <= {
        (one.who, one.what.split()[4], one.done) for one in found if one.what.endswith("over ROS 2")
    }
    assert [] == secured.ledger.commands


def test_a_policy_that_is_not_enforced_is_found(secured):
    """The simulator has not been restarted since a member was revoked or lost a right."""
    found = secured.store.access_control
    weaker = {**found.rules, "fleet": found.rules["viewer"]}

    class Younger(type(secured.store)):
        access_control = property(lambda _self: type(found)(weaker))

    wrong = [one for one in attempts(Younger(secured.store.path), secured.options) if not one.as_expected]

    assert {"fleet"} == {one.who for one in wrong}
    assert all(one.done for one in wrong)


def test_a_client_without_a_certificate_fails_without_a_connection(secured, monkeypatch):
    monkeypatch.setattr(zenoh, "open", lambda _config: pytest.fail("it was tried"))

    with pytest.raises(ConnectionDenied, match="a certificate is required"):
        open_client(replace(secured.options, timeout=3600.0))

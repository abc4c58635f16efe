"""`hmrsim doctor` under access control distinguishes denied access from a missing simulator."""

from __future__ import annotations

import json
import os
from dataclasses import replace

import pytest

from hmrsim.cli import main
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.wire.options import SessionOptions
from tests.cases import case
from tests.patience import PATIENCE
from tests.served_world import served_world
from tests.wire.ros2.client import RosClient
from tests.wire.security.conftest import of_node


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for name in list(os.environ):
        if name.startswith(("ROS_", "RMW_", "ZENOH_")):
            monkeypatch.delenv(name)


@pytest.fixture
def doctor(secured, capsys):
    """Return the function that runs the command as a member and returns its exit code and JSON."""

    def run(*words, endpoint="", timeout=PATIENCE):
        there = endpoint or secured.options.connect[0]
        code = main(["doctor", "--json", f"--timeout={timeout}", "--connect", there, *words])
        return code, json.loads(capsys.readouterr().out)

    return run


def test_a_viewer_sees_simulator_robots_ros_and_members(secured, doctor):
    with Client(secured.of("nurses")):
        code, found = doctor("--secure", str(secured.store.path))

    assert (0, []) == (code, found["problems"])
    assert found["simulator"]["info"]["robots"]
    assert "viewer" == found["security"]["name"]
    assert {"nurses", "viewer"} <= set(found["connected"].values())


def test_a_ros_node_that_is_denied_a_robot_is_named_with_its_certificate(secured, doctor):
    """The error has the rule and the members that may drive the robot."""
    options = secured.of("porters")
    with RosClient(options.connect[0], node="nav", **of_node(options)) as ros:
        ros.action("/wall_e/wait")
        code, found = doctor("--secure", str(secured.store.path))
        denials = [one for one in found["problems"] if one["kind"] == "denied"]

        assert 1 == code
        assert 1 == len(denials)
        assert "/nav, with the certificate of 'porters', may not use /wall_e/wait" in denials[0]["text"]
        assert "no rule allows it" in denials[0]["text"]
        assert "use the enclave of simulator or nurses or fleet or operator" in denials[0]["remedy"]


def test_denied_access_has_its_kind_remedy_and_exit_code(secured, doctor):
    plain = secured.options.connect[0].replace("tls", "tcp")
    former = ("--secure", str(secured.store.path.with_name("former")))
    for words, endpoint, expected in (
        ((), "", (1, "access_denied", "a certificate is required; give it with --secure DIR")),
        ((), plain, (1, "access_denied", "TLS is spoken there; give --secure DIR")),
        (former, "", (1, "access_denied", "lets 'former' in, but shows nothing")),
        (
            ("--secure", str(secured.store.path)),
            "tls/127.0.0.1:1",
            (3, "nobody_there", "no answer from tls/127.0.0.1:1"),
        ),
    ):
        with case(expected[2]):
            code, found = doctor(*words, endpoint=endpoint, timeout=1)
            (problem,) = found["problems"]

            assert expected[:2] == (code, problem["kind"])
            assert expected[2] in f"{problem['text']}; {problem['remedy']}"


def test_a_certificate_that_expires_soon_is_a_warning_with_the_command_that_renews_it(secured, doctor, tmp_path):
    soon = secured.store.stranger("viewer", 3.0, tmp_path / "soon")
    code, found = doctor("--secure", str(soon.folder))

    assert (0, ["certificate_expires"]) == (code, [one["kind"] for one in found["problems"]])


def test_the_simulator_logs_a_revoked_certificate_once(secured, caplog):
    there = SessionOptions(listen=("tls/127.0.0.1:0",), secure=secured.store.path)
    with served_world(options=there) as options:
        for _ in range(2):
            with Client(replace(options, secure=secured.store.path.with_name("former"))) as client:
                assert not client.alive
    lines = [record.message for record in caplog.records if "denied everything" in record.message]

    assert ["'former' is denied everything: it is revoked, or no member of the policy"] == lines

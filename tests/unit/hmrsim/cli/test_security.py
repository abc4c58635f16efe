"""The output and the errors of ``hmrsim security``."""

from __future__ import annotations

import json
import sys
from functools import partial

import pytest


@pytest.fixture
def security(hmrsim):
    """Return the function that runs a command and returns exit code, output and errors."""
    return partial(hmrsim, "security")


@pytest.fixture
def keys(tmp_path, security):
    path = tmp_path / "keys"
    assert 0 == security("create", path, "--controller", "nurses=wall_e,eve", "--host", "10.0.0.7")[0]
    return path


def test_create_lists_enclaves_and_the_next_command(tmp_path, security):
    path = tmp_path / "keys"
    code, out, _ = security("create", path)

    first, second, third = out.splitlines()
    assert 0 == code
    assert f"made {path}: simulator, controller (controller of all robots), viewer, operator" == first
    assert second.startswith("valid until 2")
    assert f"next: hmrsim run WORLD --secure {path}" == third


def test_create_takes_controllers_and_hosts(keys, security):
    """The configuration of ROS nodes has the first of the hosts."""
    output = json.loads(security("renew", keys, "viewer", "--json")[1])
    session = json.loads((keys / "enclaves" / "nurses" / "session.json5").read_text(encoding="utf-8"))

    assert ["simulator", "nurses", "viewer", "operator"] == [each["name"] for each in output["enclaves"]]
    assert ["wall_e", "eve"] == output["enclaves"][1]["robots"]
    assert ["10.0.0.7", "localhost", "127.0.0.1", "::1"] == output["hosts"][:4]
    assert ["tls/10.0.0.7:7447"] == session["connect"]["endpoints"]


def test_add_and_revoke_ask_for_a_restart(keys, security):
    """A running simulator keeps the policy with which it was started."""
    added = security("add", keys, "controller", "porters", "--robot", "m_o", "--service", "call_lift")[1]
    revoked = security("revoke", keys, "porters")[1]

    assert added.startswith("added porters (controller of m_o, call_lift), valid until 2")
    assert added.endswith("; restart the simulator\n")
    assert "revoked porters; restart the simulator and `hmrsim view`, which know the old policy\n" == revoked


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ("add", "DIR", "viewer", "lobby", "--robot", "eve"),
            "--robot and --service are for controllers, not for a viewer",
        ),
        (("add", "DIR", "root", "lobby"), "no role 'root'; there are controller, viewer, operator"),
        (("revoke", "DIR", "lobby"), "DIR has no 'lobby'; there are: simulator, nurses, viewer, operator"),
        (("create", "DIR"), "DIR exists; name another folder, or replace the keystore there with --force"),
        (("create", "DIR/x", "--controller", "nurses="), "'nurses=' names no robots"),
        (("create", "DIR/x", "--days", "1e9"), "'1e9' is not a number of days greater than 0, and up to 36500"),
        (("explain", "DIR", "a//b"), "'a//b' is not a key expression"),
        (("explain", "DIR", "a", "root"), "no enclave 'root'"),
        (("explain", "DIR/none", "a", "viewer"), "has no enclaves"),
        (("explain", "a", "viewer"), "no keystore; name its folder DIR, or set HMRSIM_SECURE=DIR"),
        (("explain", "DIR"), "expected [DIR] KEY [ROLE]"),
        (("check",), "no keystore; name its folder DIR, or set HMRSIM_SECURE=DIR"),
    ],
)
def test_wrong_use_is_one_line(keys, security, words, text):
    code, _, err = security(*(word.replace("DIR", str(keys)) for word in words))

    assert (2, 1) == (code, err.count("\n"))
    assert text in err.replace(str(keys), "DIR")


def test_a_missing_package_names_the_extra(tmp_path, security, monkeypatch):
    for name in [name for name in sys.modules if name.startswith("hmrsim_zenoh.security")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "cryptography", None)

    error = "hmrsim security needs a package that is not installed; pip install 'hmrsim[security]'\n"
    assert (2, "", error) == security("create", tmp_path / "keys")


def test_explain_uses_the_keystore_of_the_environment(keys, security, monkeypatch):
    monkeypatch.setenv("HMRSIM_SECURE", str(keys))

    assert (
        "viewer  may      ask           rule 'all read values'" in security("explain", "hmrsim/eve/odom", "viewer")[1]
    )


def test_explain_names_the_rule_of_each_enclave(keys, security):
    key = "hmrsim/eve/wait/_action/send_goal"
    every = json.loads(security("explain", keys, key, "--json")[1])["enclaves"]
    lines = security("explain", keys / "enclaves" / "viewer", key, "viewer")[1].splitlines()

    assert {"nurses": True, "operator": True, "simulator": True, "viewer": False} == {
        name: each["ask"]["allowed"] for name, each in every.items()
    }
    assert "nurses drives wall_e, eve" == every["nurses"]["ask"]["rule"]
    assert [
        "viewer  may not  ask           no rule allows it",
        "viewer  may      subscribe     rule 'all subscribe'",
    ] == (lines[:2])

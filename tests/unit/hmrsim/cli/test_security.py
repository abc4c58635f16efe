"""The output and the errors of ``hmrsim security``."""

from __future__ import annotations

import json
import sys

import pytest

from hmrsim.cli import main


@pytest.fixture
def keys(tmp_path, capsys):
    path = tmp_path / "keys"
    assert main(["security", "create", str(path), "--controller", "nurses=wall_e,eve", "--host", "10.0.0.7"]) == 0
    capsys.readouterr()
    return path


def test_create_lists_enclaves_and_the_next_command(tmp_path, capsys):
    path = tmp_path / "keys"

    assert main(["security", "create", str(path)]) == 0
    first, second, third = capsys.readouterr().out.splitlines()
    assert f"made {path}: simulator, controller (controller of all robots), viewer, operator" == first
    assert second.startswith("valid until 2")
    assert f"next: hmrsim run WORLD --secure {path}" == third


def test_create_takes_controllers_and_hosts(keys, capsys):
    """The configuration of ROS nodes has the first of the hosts."""
    assert main(["security", "renew", str(keys), "viewer", "--json"]) == 0
    output = json.loads(capsys.readouterr().out)
    session = json.loads((keys / "enclaves" / "nurses" / "session.json5").read_text(encoding="utf-8"))

    assert ["simulator", "nurses", "viewer", "operator"] == [each["name"] for each in output["enclaves"]]
    assert ["wall_e", "eve"] == output["enclaves"][1]["robots"]
    assert ["10.0.0.7", "localhost", "127.0.0.1", "::1"] == output["hosts"][:4]
    assert ["tls/10.0.0.7:7447"] == session["connect"]["endpoints"]


def test_a_second_create_changes_nothing(keys, capsys):
    assert main(["security", "create", str(keys)]) == 2
    assert f"hmrsim: {keys} exists; name another folder, or replace the keystore there with --force\n" == (
        capsys.readouterr().err
    )


def test_add_and_revoke_ask_for_a_restart(keys, capsys):
    """A running simulator keeps the policy with which it was started."""
    assert (
        main(["security", "add", str(keys), "controller", "porters", "--robot", "m_o", "--service", "call_lift"]) == 0
    )
    assert main(["security", "revoke", str(keys), "porters"]) == 0
    added, revoked = capsys.readouterr().out.splitlines()

    assert added.startswith("added porters (controller of m_o, call_lift), valid until 2")
    assert added.endswith("; restart the simulator")
    assert "revoked porters; restart the simulator and `hmrsim view`, which know the old policy" == revoked


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ("add", "DIR", "viewer", "lobby", "--robot", "eve"),
            "--robot and --service are for controllers, not for a viewer",
        ),
        (("add", "DIR", "root", "lobby"), "no role 'root'; there are controller, viewer, operator"),
        (("revoke", "DIR", "lobby"), "DIR has no 'lobby'; there are: simulator, nurses, viewer, operator"),
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
def test_wrong_use_is_one_line(keys, capsys, words, text):
    assert main(["security", *(word.replace("DIR", str(keys)) for word in words)]) == 2
    error = capsys.readouterr().err.replace(str(keys), "DIR")

    assert text in error
    assert 1 == error.count("\n")


def test_a_missing_package_names_the_extra(tmp_path, capsys, monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("hmrsim_zenoh.security", "hmrsim.cli.security"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "cryptography", None)

    assert main(["security", "create", str(tmp_path / "keys")]) == 2
    assert "hmrsim security needs a package that is not installed; pip install 'hmrsim[security]'\n" == (
        capsys.readouterr().err
    )


def test_explain_uses_the_keystore_of_the_environment(keys, capsys, monkeypatch):
    monkeypatch.setenv("HMRSIM_SECURE", str(keys))

    assert main(["security", "explain", "hmrsim/eve/odom", "viewer"]) == 0
    assert "viewer  may      ask           rule 'all read values'" in capsys.readouterr().out


def test_explain_names_the_rule_of_each_enclave(keys, capsys):
    key = "hmrsim/eve/wait/_action/send_goal"
    assert main(["security", "explain", str(keys), key, "--json"]) == 0
    every = json.loads(capsys.readouterr().out)["enclaves"]
    assert main(["security", "explain", str(keys / "enclaves" / "viewer"), key, "viewer"]) == 0
    lines = capsys.readouterr().out.splitlines()

    assert {"nurses": True, "operator": True, "simulator": True, "viewer": False} == {
        name: each["ask"]["allowed"] for name, each in every.items()
    }
    assert "nurses drives wall_e, eve" == every["nurses"]["ask"]["rule"]
    assert [
        "viewer  may not  ask           no rule allows it",
        "viewer  may      subscribe     rule 'all subscribe'",
    ] == (lines[:2])

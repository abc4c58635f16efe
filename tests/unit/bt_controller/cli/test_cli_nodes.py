"""The list of the nodes that XML trees can be made of."""

from __future__ import annotations

import json
from xml.etree import ElementTree as ET

import pytest

from bt_controller.cli import main
from bt_controller.nodes import registry


def test_all_nodes_are_listed(capsys):
    assert 0 == main(["nodes"])

    out = capsys.readouterr().out
    assert {"controls:", "decorators:", "actions:", "conditions:"} == {
        line for line in out.splitlines() if not line[0].isspace()
    }
    assert set(registry()) == {line.split()[0] for line in out.splitlines() if line[0].isspace()}


def test_a_node_is_listed_with_its_ports(capsys):
    assert 0 == main(["nodes", "RecoveryNode"])

    out = capsys.readouterr().out
    assert out.startswith("RecoveryNode (control)\n")
    assert "  input number_of_retries: int, default 1\n" in out


def test_scripts_are_listed_as_ports_are(capsys):
    main(["nodes", "Script", "--json"])

    (script,) = json.loads(capsys.readouterr().out)["Script"]["ports"]
    assert ("code", "script", True) == (script["name"], script["type"], script["required"])


def test_an_unknown_node_is_an_error(capsys):
    assert 2 == main(["nodes", "RecoverNode"])

    assert "bt-controller: no node 'RecoverNode'; did you mean 'RecoveryNode'?\n" == capsys.readouterr().err


def test_editors_get_a_model_of_all_nodes(capsys):
    main(["nodes", "--xml"])

    model = ET.fromstring(capsys.readouterr().out).find("TreeNodesModel")
    assert sorted(registry()) == [node.get("ID") for node in model]
    recovery = model.find("Control[@ID='RecoveryNode']/input_port")
    assert {"name": "number_of_retries", "type": "int", "default": "1"} == recovery.attrib


def test_two_forms_at_once_are_refused(capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["nodes", "--json", "--xml"])

    assert "not allowed with" in capsys.readouterr().err

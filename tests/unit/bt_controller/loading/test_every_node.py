"""Every node that there is can stand in a file."""

from __future__ import annotations

import pytest

from bt_controller.loading.check import children_of
from bt_controller.nodes import registry

NODES = registry()


@pytest.mark.parametrize("tag", NODES)
def test_a_node_is_built_with_what_it_needs(files, tag):
    node = NODES[tag]
    files.nodes = NODES
    needed = [name for name, port in node.input_ports().items() if port.required and port.default_value is None]
    said = [f'{name}="{{key_{name}}}"' for name in needed] + [f'{name}="true"' for name in getattr(node, "SCRIPTS", ())]
    inside = "<AlwaysSuccess/>" * children_of(node)[0]

    with files.built(f'<BehaviorTree ID="A"><{tag} {" ".join(said)}>{inside}</{tag}></BehaviorTree>') as root:
        assert (root.name, root.origin) == (tag, "tree.xml:1")
    assert [f"key_{name}" in line for name, line in zip(needed, files.unset, strict=True)] == [True] * len(needed)

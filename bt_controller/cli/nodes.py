"""``bt-controller nodes``: list the nodes of XML trees."""

from __future__ import annotations

import argparse
import inspect
import json
import sys
from enum import Enum
from typing import TYPE_CHECKING, Any, Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from bt_controller.cli._options import DONE, EXIT_CODES, WRONG_USE
from hmrsim.diagnostics import meant

if TYPE_CHECKING:
    from bt_controller.core.node import Node

_EXAMPLES: Final = """\
examples:
  bt-controller nodes
  bt-controller nodes RecoveryNode
  bt-controller nodes --xml > palette.xml
  bt-controller nodes --json | jq 'keys'"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bt-controller nodes``."""
    parser.description = "List the nodes of XML trees; the named ones with their ports."
    parser.epilog = f"{_EXAMPLES}\n\n{EXIT_CODES}"
    parser.add_argument("nodes", nargs="*", metavar="NODE", help="a node's tag (default: all nodes)")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="one JSON object: nodes with their ports, by tag")
    form.add_argument("--xml", action="store_true", help="a TreeNodesModel, for editors such as Groot2")
    parser.set_defaults(function=_nodes)


def _nodes(args: argparse.Namespace) -> int:
    from bt_controller.nodes import registry

    known = registry()
    for name in args.nodes:
        if name not in known:
            alike = meant(name, known)
            hint = f"did you mean {alike!r}?" if alike else "`bt-controller nodes` lists them"
            print(f"bt-controller: no node {name!r}; {hint}", file=sys.stderr)
            return WRONG_USE
    shown = {name: known[name] for name in args.nodes or sorted(known)}
    if args.json:
        print(json.dumps({tag: _described(node) for tag, node in shown.items()}, indent=2))
    elif args.xml:
        print(_model(shown))
    elif args.nodes:
        print("\n\n".join(_page(tag, node) for tag, node in shown.items()))
    else:
        for kind in ("control", "decorator", "action", "condition"):
            print(f"{kind}s:")
            tags = [tag for tag, node in shown.items() if _kind(node) == kind]
            widest = max(map(len, tags), default=0)
            for tag in tags:
                print(f"  {tag:{widest}}  {_summary(shown[tag])}")
    return DONE


def _kind(node: type[Node]) -> str:
    """Return BehaviorTree.CPP's name of a node's kind."""
    from bt_controller.core.node import Condition, Control, Decoration

    for base, kind in ((Control, "control"), (Decoration, "decorator"), (Condition, "condition")):
        if issubclass(node, base):
            return kind
    return "action"


def _summary(node: type[Node]) -> str:
    return (inspect.getdoc(node) or "").partition("\n")[0]


def _ports(node: type[Node]) -> list[dict[str, Any]]:
    """Return the ports of a node as plain values, and the attributes that are scripts."""
    sides = [("input", node.INPUTS), ("output", node.OUTPUTS)]
    scripts = [
        {"name": name, "direction": "input", "type": "script", "required": True, "default": None, "description": ""}
        for name in getattr(node, "SCRIPTS", ())
    ]
    return scripts + [
        {
            "name": name,
            "direction": side,
            "type": port.kind.name,
            "required": port.required,
            "default": _plain(port.default_value),
            "description": port.description,
        }
        for side, ports in sides
        for name, port in ports.items()
    ]


def _plain(value: Any) -> Any:
    if isinstance(value, Enum):
        return value.value
    return value if isinstance(value, (str, int, float, bool, type(None))) else str(value)


def _described(node: type[Node]) -> dict[str, Any]:
    return {"kind": _kind(node), "description": inspect.getdoc(node) or "", "ports": _ports(node)}


def _page(tag: str, node: type[Node]) -> str:
    lines = [f"{tag} ({_kind(node)})", *(f"  {line}".rstrip() for line in (inspect.getdoc(node) or "").splitlines())]
    for port in _ports(node):
        needed = ", required" if port["required"] and port["direction"] == "input" else ""
        default = "" if port["default"] is None else f", default {port['default']}"
        lines.append(f"  {port['direction']} {port['name']}: {port['type']}{needed}{default}")
        lines += [f"      {port['description']}"] if port["description"] else []
    return "\n".join(lines)


def _model(nodes: dict[str, type[Node]]) -> str:
    """Return the nodes as a TreeNodesModel for editors of BehaviorTree.CPP's files."""
    root = Element("root", BTCPP_format="4")
    model = SubElement(root, "TreeNodesModel")
    for tag, node in nodes.items():
        element = SubElement(model, _kind(node).capitalize(), ID=tag)
        for port in _ports(node):
            given = {"name": port["name"], "type": port["type"]}
            default = {} if port["default"] is None else {"default": str(port["default"])}
            SubElement(element, f"{port['direction']}_port", given | default).text = port["description"]
    indent(root)
    return tostring(root, encoding="unicode")

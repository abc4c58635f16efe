"""Checking of a file: each node against its class, and its references to the blackboard.

A reference is ``{key}``, ``{=}`` for the port's own name, or ``{@key}`` for the main tree's entry.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.ports import CONST_PREFIX, DOT_REPLACEMENT

from bt_controller.core.ports import BOOL, CHILDREN
from bt_controller.nodes import UNSUPPORTED
from bt_controller.scripting.parser import ScriptError, parse
from bt_controller.scripting.scripted import ATTRIBUTES, ScriptConditions
from hmrsim.diagnostics import instead, meant, shown

if TYPE_CHECKING:
    from bt_controller.loading.source import Document, Element, Faults, Origin
    from bt_controller.scripting.parser import Script


@dataclass(frozen=True)
class Call:
    """A node in a file.

    Attributes:
        node: The node's class, with its scripts; None for a subtree.
        tree: The ID of a subtree's tree.
        ports: The ports that the file mentions, each with a ``{key}`` or a value.
        scripts: The scripts of the node's own attributes.
        around: The decoration with the scripts of common attributes such as ``_skipIf``; None if there are none.
        conditions: The scripts of common attributes.
        autoremap: Whether a subtree shares the keys that are not mentioned.
    """

    origin: Origin
    node: type[Any] | None
    tree: str
    ports: Mapping[str, str]
    scripts: Mapping[str, Script]
    around: type[Any] | None
    conditions: Mapping[str, Script]
    autoremap: bool
    children: tuple[Call, ...] = ()


def is_a(node: type[Any], form: str) -> bool:
    """Return whether a node is of the kind of a long form such as ``<Action ID="…"/>``."""
    if form in ("Action", "Condition"):
        return not issubclass(node, (Composite, Decorator))
    return issubclass(node, Composite if form == "Control" else Decorator)


def children_of(node: type[Any]) -> tuple[int, float]:
    """Return the least and the largest number of a node's children."""
    if issubclass(node, Decorator):
        return 1, 1
    if issubclass(node, Composite):
        return getattr(node, "least", 1), getattr(node, "most", math.inf)
    return 0, 0


def counted(children: int) -> str:
    """Return a number of children as text."""
    return "no children" if children == 0 else "1 child" if children == 1 else f"{children} children"


def connection(node: type[Any], name: str, text: str) -> str:
    """Return the connection of a port: ``{key}``, or a value that the port can parse.

    Raises:
        ValueError: The text is invalid.
    """
    if name in getattr(node, "KEYS", ()) and is_key(text.strip()):
        return f"{{{text.strip()}}}"
    key = reference(name, text)
    if key is not None:
        return f"{{{key}}}"
    if name in node.output_ports():
        raise ValueError(f'{shown(text)} is a value, but the port is an output; use a key: {name}="{{…}}"')
    kind = getattr(node.input_ports()[name], "kind", None)
    if kind is not None:
        kind.read(text, None)
    return text


def shared(name: str, text: str) -> str:
    """Return the connection of a subtree's port: ``{key}``, or a value.

    Raises:
        ValueError: The text is invalid.
    """
    if not is_key(name):
        raise ValueError("not a valid key; expected letters, digits, '_' and '-'")
    key = reference(name, text)
    return text if key is None else f"{{{key}}}"


_KEY: Final = re.compile(r"@?[\w-]+")
_TAKEN: Final = ("name", "ID", "@name", "@ID")
"""The attributes that py_trees reserves."""


def reference(port: str, text: str) -> str | None:
    """Return the key that a text refers to; None if it is a value.

    Raises:
        ValueError: The text is neither, or has a special meaning in py_trees.
    """
    inner = text.strip()
    if not (inner.startswith("{") and inner.endswith("}") and len(inner) > len("{}")):
        if "{" in text or "}" in text:
            raise ValueError(f"{shown(text)} is not a value; braces enclose keys of the blackboard: {{key}}")
        if CONST_PREFIX in text or DOT_REPLACEMENT in text:
            raise ValueError(
                f"{shown(text)} is not a value; {CONST_PREFIX!r} and {DOT_REPLACEMENT!r} are reserved by py_trees"
            )
        return None
    key = port if inner == "{=}" else inner[1:-1].strip()
    if not is_key(key):
        wanted = "the name is reserved" if key in _TAKEN else "expected letters, digits, '_' and '-'"
        raise ValueError(f"{shown(text)} is not a key of the blackboard; {wanted}")
    return key


def is_key(text: str) -> bool:
    """Return whether a text can be a key."""
    return (
        bool(_KEY.fullmatch(text)) and text not in _TAKEN and CONST_PREFIX not in text and DOT_REPLACEMENT not in text
    )


_IGNORED: Final = ("_description", "_fullpath", "_uid")
"""The attributes of editors, which are ignored."""

_AUTOREMAP: Final = "_autoremap"
_SUBTREE: Final = "SubTree"
_FORMS: Final = ("Action", "Condition", "Control", "Decorator")


def check(document: Document, nodes: Mapping[str, type[Any]], faults: Faults) -> dict[str, Call]:
    """Return the root of each tree by ID; trees with errors are incomplete."""
    checker = _Checker(document, nodes, faults)
    return {tree: checker.call(child) for tree, root in document.trees.items() for child in root}  # type: ignore[arg-type]


class _Checker:
    def __init__(self, document: Document, nodes: Mapping[str, type[Any]], faults: Faults) -> None:
        self._document = document
        self._nodes = nodes
        self._faults = faults

    def call(self, element: Element) -> Call:
        """Return an element and its descendants."""
        call = self._subtree(element) if element.tag == _SUBTREE else self._node(element)
        return replace(call, children=tuple(self.call(child) for child in element))  # type: ignore[arg-type]

    def _node(self, element: Element) -> Call:
        attributes = dict(element.attrib)
        tag = attributes.pop("ID", "") if element.tag in _FORMS else element.tag
        origin = replace(element.origin, tag=tag or element.tag)
        call = Call(origin, None, "", {}, {}, None, {}, autoremap=False)
        node = self._nodes.get(tag) or self._spelled(origin, tag)
        if node is None:
            self._unknown(origin, tag)
            return call
        if element.tag in _FORMS and not is_a(node, element.tag):
            self._faults.add(element.origin, f"{tag!r} is not of this kind; use <{tag}>")
        self._count(origin, node, len(element))
        around, conditions = self._conditions(origin, attributes)
        attributes.pop("name", None)
        own = getattr(node, "SCRIPTS", ())
        scripts = self._scripts(origin, attributes, own)
        for name in own:
            if name not in element.attrib:
                self._faults.add(origin, f'needs {name}="…", a script')
        ports = self._ports(origin, node, attributes)
        self._look(origin, node, ports, len(element))
        return replace(
            call,
            node=self._bound(origin, node, scripts),
            ports=ports,
            scripts=scripts,
            around=around,
            conditions=conditions,
        )

    def _spelled(self, origin: Origin, tag: str) -> type[Any] | None:
        """Return the node whose tag differs in case only, as in a tree that Nav2 ships; None if there is none."""
        alike = [known for known in self._nodes if known.lower() == tag.lower()]
        if len(alike) != 1 or tag in self._document.trees or tag in UNSUPPORTED:
            return None
        self._faults.warn(origin, f"read as <{alike[0]}>; BehaviorTree.CPP is case-sensitive")
        return self._nodes[alike[0]]

    def _unknown(self, origin: Origin, tag: str) -> None:
        if not tag:
            self._faults.add(origin, 'needs ID="…", the name of a node')
        elif tag in self._document.trees:
            self._faults.add(origin, f'is a tree, not a node; write <SubTree ID="{tag}"/>')
        elif tag in UNSUPPORTED:
            self._faults.add(origin, f"unsupported node: {UNSUPPORTED[tag]}")
        else:
            alike = meant(tag, sorted({*self._nodes, _SUBTREE}))
            hint = f"did you mean {alike!r}?" if alike else "see bt-controller nodes"
            self._faults.add(origin, f"unknown node; {hint}")

    def _count(self, origin: Origin, node: type[Any], count: int) -> None:
        """Check the number of a node's children."""
        least, most = children_of(node)
        if not least <= count <= most:
            wanted = (
                f"exactly {least}" if least == most else f"at least {least}" if count < least else f"at most {most}"
            )
            self._faults.add(origin, f"has {counted(count)}; expected {wanted if most else 'none'}")

    def _conditions(self, origin: Origin, attributes: dict[str, str]) -> tuple[type[Any] | None, dict[str, Script]]:
        """Process the attributes that every node may have."""
        for name in [name for name in attributes if name.startswith("_") and name not in ATTRIBUTES]:
            del attributes[name]
            if name not in _IGNORED:
                known = (*ATTRIBUTES, _AUTOREMAP) if origin.tag == _SUBTREE else ATTRIBUTES
                self._faults.add(origin, f"unknown attribute {shown(name)}{instead(name, known)}")
        scripts = self._scripts(origin, attributes, ATTRIBUTES)
        return (ScriptConditions.bind(scripts) if scripts else None), scripts

    def _scripts(self, origin: Origin, attributes: dict[str, str], names: Iterable[str]) -> dict[str, Script]:
        """Process the attributes that are scripts."""
        found = {}
        for name in names:
            text = attributes.pop(name, None)
            if text is None:
                continue
            try:
                script = parse(text)
            except ScriptError as error:
                self._faults.add(origin, f"{name}: {error}")
                continue
            for key in script.names:
                if not is_key(key):
                    self._faults.add(origin, f"{name}: {shown(key)} is not a valid name of an entry")
                    break
            else:
                found[name] = script
        return found

    def _bound(self, origin: Origin, node: type[Any], scripts: Mapping[str, Script]) -> type[Any]:
        """Return a class with its scripts."""
        try:
            return node.bind(scripts) if scripts else node
        except ScriptError as error:
            self._faults.add(origin, str(error))
            return node

    def _ports(self, origin: Origin, node: type[Any], attributes: Mapping[str, str]) -> dict[str, str]:
        own = getattr(node, "SCRIPTS", ())
        inputs = {name: port for name, port in node.input_ports().items() if name not in own}
        outputs = node.output_ports()
        found = {}
        for name, text in attributes.items():
            if name not in inputs and name not in outputs:
                known = [*own, *inputs, *outputs]
                hint = instead(name, known, verb="it has")
                if name == "robot" and "server_name" in inputs:
                    hint = f'; to send the goal to another robot, write server_name="{text}/{node.ACTION}"'
                self._faults.add(origin, f"unknown port {shown(name)}{hint}")
                continue
            try:
                found[name] = connection(node, name, text)
            except ValueError as error:
                self._faults.add(origin, f"port {name!r}: {error}")
        for name, port in inputs.items():
            if name in attributes:
                continue
            default = port.default_value
            if default is None and port.required:
                self._faults.add(origin, f'port {name!r} is missing; write {name}="…"')
            elif isinstance(default, str) and (key := reference(name, default)) is not None:
                found[name] = f"{{{key}}}"
        return found

    def _look(self, origin: Origin, node: type[Any], ports: Mapping[str, str], children: int) -> None:
        """Check for valid values that can't be intended."""
        for name, port in node.input_ports().items():
            text, kind = ports.get(name, "{}"), getattr(port, "kind", None)
            if kind is None or text.startswith("{"):
                continue
            if kind is CHILDREN and int(text) > children:
                self._faults.add(origin, f"port {name!r}: {shown(text)} of {counted(children)} is never reached")
            if doubt := kind.doubt(text):
                self._faults.warn(origin, f"port {name!r}: {doubt}")

    def _subtree(self, element: Element) -> Call:
        origin = element.origin
        attributes = dict(element.attrib)
        tree = attributes.pop("ID", "")
        if not tree:
            self._faults.add(origin, 'needs ID="…", that of a <BehaviorTree>')
        elif tree not in self._document.trees:
            self._faults.add(origin, f"unknown tree {shown(tree)}{instead(tree, self._document.trees)}")
        if len(element):
            self._faults.add(origin, "has children; move them to its <BehaviorTree>")
        autoremap = False
        try:
            autoremap = BOOL.read(attributes.pop(_AUTOREMAP, "false"), None)
        except ValueError as error:
            self._faults.add(origin, f"{_AUTOREMAP}: {error}")
        around, conditions = self._conditions(origin, attributes)
        attributes.pop("name", None)
        ports = {}
        for name, given in {**self._defaults(origin, tree, attributes, autoremap=autoremap), **attributes}.items():
            try:
                ports[name] = shared(name, given)
            except ValueError as error:
                self._faults.add(origin, f"port {name!r}: {error}")
        return Call(origin, None, tree, ports, {}, around, conditions, autoremap)

    def _defaults(self, origin: Origin, tree: str, given: Mapping[str, str], *, autoremap: bool) -> dict[str, str]:
        """Return the defaults of unmentioned ports from the file's model of a subtree."""
        missing = {name: text for name, text in self._document.models.get(tree, {}).items() if name not in given}
        if autoremap:
            return {}
        for name, text in missing.items():
            if text is None:
                self._faults.add(origin, f'port {name!r} is missing; write {name}="…", as its model requires')
        return {name: text for name, text in missing.items() if text is not None}

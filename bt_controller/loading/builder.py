"""The nodes of a checked file: planned once, and built for each robot.

A subtree has its own namespace on the blackboard. Its keys lead to entries in that namespace, except for those that it
shares with its parent. ``@key`` leads to the outermost tree from everywhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from itertools import count
from typing import TYPE_CHECKING, Any, Final

from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.ports import CONST_PREFIX, DOT_REPLACEMENT

from bt_controller.core.node import Connections, Decoration, Node, Ticks
from bt_controller.errors import TreeError
from bt_controller.loading.source import MAX_NODES
from hmrsim.diagnostics import meant
from hmrsim.program.users_code import described
from hmrsim.safe_xml import MAX_DEPTH

if TYPE_CHECKING:
    from bt_controller.loading.check import Call
    from bt_controller.loading.source import Faults, Origin
    from bt_controller.scripting.parser import Script

_NOT_IN_NAMESPACE: Final = re.compile(r"[^\w-]|_{2,}")


class SubTree(Decoration):
    """Runs another tree with its own blackboard, and returns its status."""

    def advance(self) -> Ticks:
        """Tick the root of the other tree."""
        return (yield from self.tick_child())


@dataclass(frozen=True)
class Blueprint:
    """A node that is built for each robot.

    Attributes:
        node: Its class.
        place: File and line of its origin.
        name: Its name, also in messages.
        connections: Its connections; of a class that is no `Node`, the arguments of ``setup_ports``.
    """

    node: type[Any]
    origin: Origin
    place: str
    name: str
    connections: Connections | Mapping[str, Any]
    children: Sequence[Blueprint] = ()

    @cached_property
    def _argument(self) -> str:
        """The argument that the node's class has for its children; an empty text for none."""
        return "child" if issubclass(self.node, Decorator) else "children" if issubclass(self.node, Composite) else ""

    def build(self) -> Any:
        """Return a new node with new children, on the blackboard in use.

        Raises:
            TreeError: A constructor raises an error.
        """
        children = [child.build() for child in self.children] if self.children else []
        arguments: dict[str, Any] = {}
        match self._argument:
            case "child":
                arguments["child"] = children[0]
            case "children":
                arguments["children"] = children
        try:
            node = self.node(name=self.name, behaviour_class_name=self.origin.tag, **arguments)
        except Exception as error:
            raise TreeError(f"<{self.origin.tag}>: {described(error)}") from error
        if isinstance(self.connections, Connections):
            node.connect(self.connections)
            node.origin = self.place
        else:
            node.setup_ports(**self.connections)
        return node

    def origins(self) -> Iterator[Origin]:
        """Yield the origins of the nodes in the order of py_trees' ``iterate``: children before their parents."""
        for child in self.children:
            yield from child.origins()
        yield self.origin


@dataclass(frozen=True)
class _Scope:
    """The blackboard of a tree or a subtree.

    Attributes:
        shared: The entries of the parent, by the subtree's keys.
        parent: The scope that all other keys come from; None for the namespace.
        namespaces: The names of the subtrees so far.
    """

    namespace: str = "/"
    shared: Mapping[str, str] = field(default_factory=dict)
    parent: _Scope | None = None
    namespaces: set[str] = field(default_factory=set)

    def entry(self, key: str) -> str:
        """Return the entry to which a key leads."""
        if key.startswith("@"):
            return f"/{key[1:]}"
        if key in self.shared:
            return self.shared[key]
        if self.parent is not None and not key.startswith("_"):
            return self.parent.entry(key)
        return self.own(key)

    def own(self, key: str) -> str:
        """Return the entry of a key in the scope's namespace."""
        return f"{self.namespace.rstrip('/')}/{key}"

    def inside(self, call: Call) -> _Scope:
        """Return the scope of a subtree, with a namespace that no other subtree has."""
        base = name = _NOT_IN_NAMESPACE.sub("_", call.origin.name or call.tree)
        number = 1
        while name in self.namespaces:
            number += 1
            name = f"{base}_{number}"
        self.namespaces.add(name)
        namespace = self.own(name)
        shared = {
            port: self.entry(text[1:-1]) if text.startswith("{") else f"{namespace}/{port}"
            for port, text in call.ports.items()
        }
        return _Scope(namespace, shared, self if call.autoremap else None)


def plan(main: str, calls: Mapping[str, Call]) -> tuple[Blueprint, dict[str, str]]:
    """Return the blueprint of a tree, and the initial texts of its subtrees by blackboard key.

    Args:
        main: The ID of the outermost tree.
        calls: The root of each tree, by ID; without errors.
    """
    planner = _Planner(calls)
    return planner.whole(calls[main], _Scope()), planner.texts


class _Planner:
    """Plans the nodes of a tree and its subtrees."""

    def __init__(self, calls: Mapping[str, Call]) -> None:
        self._calls = calls
        self._numbers = count()
        self.texts: dict[str, str] = {}

    def whole(self, call: Call, scope: _Scope) -> Blueprint:
        """Return the blueprint of a node, with the conditions around it."""
        inner = self._subtree(call, scope) if call.node is None else self._node(call, call.node, scope)
        if call.around is None:
            return inner
        ports = _script_ports(call.around, call.conditions)
        return self._blueprint(call.around, call.origin, " ".join(call.conditions), ports, scope, [inner])

    def _node(self, call: Call, node: type[Any], scope: _Scope) -> Blueprint:
        children = [self.whole(child, scope) for child in call.children]
        ports = {**call.ports, **_script_ports(node, call.scripts)}
        return self._blueprint(node, call.origin, call.origin.name or call.origin.tag, ports, scope, children)

    def _subtree(self, call: Call, scope: _Scope) -> Blueprint:
        inside = scope.inside(call)
        self.texts |= {inside.own(port): text for port, text in call.ports.items() if not text.startswith("{")}
        child = self.whole(self._calls[call.tree], inside)
        return self._blueprint(SubTree, call.origin, call.origin.name or call.tree, {}, scope, [child])

    def _blueprint(
        self,
        node: type[Any],
        origin: Origin,
        name: str,
        ports: Mapping[str, str],
        scope: _Scope,
        children: Sequence[Blueprint],
    ) -> Blueprint:
        keys = {port: scope.entry(text[1:-1]) for port, text in ports.items() if text.startswith("{")}
        texts = {port: text for port, text in ports.items() if port not in keys}
        connections: Connections | Mapping[str, Any]
        if issubclass(node, Node):
            connections = Connections.of(node, f"{name}_{next(self._numbers)}", keys, texts, scope.namespace)
        else:
            encoded = {port: f"{CONST_PREFIX}{text.replace('.', DOT_REPLACEMENT)}" for port, text in texts.items()}
            connections = {"port_remappings": keys | encoded, "subtree_namespace": scope.namespace}
        return Blueprint(node, origin, str(origin), name, connections, children)


def _script_ports(node: type[Any], scripts: Mapping[str, Script]) -> dict[str, str]:
    """Return the connections of the ports that a class has for the names in its scripts."""
    known = {*node.input_ports(), *node.output_ports()} if scripts else set()
    names = dict.fromkeys(name for script in scripts.values() for name in script.names)
    return {port: f"{{{name}}}" for name in names for port in (name, f"{name}>") if port in known}


def check_subtrees(calls: Mapping[str, Call], faults: Faults) -> None:
    """Report trees that contain themselves or are too large, and warn of misspelled ports of subtrees."""
    keys: dict[str, dict[str, None]] = {}
    sizes: dict[str, tuple[int, int]] = {}
    for tree in _in_order(calls, faults):
        keys[tree] = {}
        for call in _all(calls[tree]):
            keys[tree] |= dict.fromkeys(_keys(call, keys))
            if call.node is None:
                _check_shared(call, keys.get(call.tree, {}), faults)
        sizes[tree] = nodes, depth = _size(calls[tree], sizes)
        if nodes > MAX_NODES or depth > MAX_DEPTH:
            excess = (
                f"have more than {MAX_NODES} nodes" if nodes > MAX_NODES else f"be more than {MAX_DEPTH} levels deep"
            )
            faults.add(calls[tree].origin, f"{tree!r} would {excess}, with its subtrees")
            break


def _in_order(calls: Mapping[str, Call], faults: Faults) -> list[str]:
    """Return the trees in an order in which each follows those that it uses; report a tree that contains itself."""
    uses = {tree: [call for call in _all(root) if call.node is None] for tree, root in calls.items()}
    needed = {tree: [call.tree for call in used if call.tree in calls] for tree, used in uses.items()}
    try:
        return list(TopologicalSorter(needed).static_order())
    except CycleError as error:
        # Each tree is used by the next one.
        used, user, *_ = error.args[1]
        call = next(call for call in uses[user] if call.tree == used)
        ring = " in ".join(map(repr, error.args[1]))
        faults.add(call.origin, f"a tree can't contain itself: {ring}")
        return []


def _all(call: Call) -> Iterator[Call]:
    yield call
    for child in call.children:
        yield from _all(child)


def _keys(call: Call, keys: Mapping[str, Mapping[str, None]]) -> Iterator[str]:
    """Yield the keys of a tree that a node uses, and those that a subtree shares with the tree."""
    yield from (text[1:-1] for text in call.ports.values() if text.startswith("{"))
    for script in (*call.scripts.values(), *call.conditions.values()):
        yield from script.names
    for key in keys.get(call.tree, ()):
        if key.startswith("@") or (call.autoremap and not key.startswith("_") and key not in call.ports):
            yield key


def _check_shared(call: Call, keys: Mapping[str, None], faults: Faults) -> None:
    """Warn of a port that a subtree does not use, if the subtree uses a similar key."""
    used = [key for key in keys if key not in call.ports]
    for port in call.ports:
        if port not in keys and (alike := meant(port, used)):
            faults.warn(call.origin, f"{call.tree!r} uses no {port!r}; did you mean {alike!r}?")


def _size(call: Call, sizes: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Return the number of nodes of a call, and their depth."""
    inside = [_size(child, sizes) for child in call.children]
    if call.node is None and call.tree in sizes:
        inside.append(sizes[call.tree])
    around = call.around is not None
    return 1 + around + sum(nodes for nodes, _ in inside), 1 + around + max((depth for _, depth in inside), default=0)

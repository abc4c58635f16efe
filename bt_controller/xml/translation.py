"""Translation of a checked file to the input of py_trees' parser.

py_trees does the work: it makes the nodes, gives each subtree a namespace on the blackboard, and follows keys through
them. It wants a name for each element, one tag for each class, and every key that a subtree shares.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING, Any, Final
from xml.etree.ElementTree import Element

from bt_controller.core.node import Decoration, Ticks
from bt_controller.xml.source import MAX_NODES
from hmrsim.diagnostics import meant
from hmrsim.safe_xml import MAX_DEPTH

if TYPE_CHECKING:
    from bt_controller.scripting.parser import Script
    from bt_controller.xml.call import Call
    from bt_controller.xml.faults import Faults, Origin

SUBTREE: Final = "SubTree"
_SHOWN_SUBTREE: Final = "#SubTree"
"""A tag that can't occur in files."""

_MAX_KEYS: Final = 1_000
"""The largest number of keys of one tree. py_trees formats all of them into an unused message for each node."""


class SubTree(Decoration):
    """Runs another tree with its own blackboard, and returns its status."""

    def advance(self) -> Ticks:
        """Tick the tree."""
        return (yield from self.tick_child())


class Part(Element):
    """An element for py_trees' parser.

    Attributes:
        texts: The initial blackboard entries of a subtree.
    """

    origin: Origin
    shown: str
    texts: Mapping[str, str]


@dataclass
class Translation:
    """The input of py_trees' parser.

    Attributes:
        trees: The <BehaviorTree> elements by ID.
        registry: The classes by tag.
        keys: The keys of each tree, including those that its subtrees share with it.
    """

    trees: dict[str, Element] = field(default_factory=dict)
    registry: dict[str, type[Any]] = field(default_factory=dict)
    keys: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def parts(self, tree: str, namespace: str = "/") -> Iterator[tuple[Part, str]]:
        """Return what becomes of a tree, with the namespace: the parts in the order of py_trees' ``iterate``.

        Subtrees themselves come before what is in them.
        """
        yield from self._parts(self.trees[tree][0], namespace)

    def _parts(self, part: Any, namespace: str) -> Iterator[tuple[Part, str]]:
        if part.tag == SUBTREE:
            inside = f"{namespace}{part.attrib['name']}/"
            yield part, inside
            yield from self.parts(part.attrib["ID"], inside)
            return
        for child in part:
            yield from self._parts(child, namespace)
        yield part, namespace


def translate(calls: Mapping[str, Call], faults: Faults) -> Translation:
    """Return the trees for py_trees, without invalid ones.

    Args:
        calls: The root of each tree, by ID.
        faults: Collects recursive and too large trees.
    """
    result = Translation()
    sizes: dict[str, tuple[int, int]] = {}
    for tree in in_order(calls, faults):
        _Translator(result, tree, faults).add(calls[tree])
        sizes[tree] = count, depth = _size(result.trees[tree][0], sizes)
        if excess := _excess(count, depth, len(result.keys[tree])):
            faults.add(calls[tree].origin, f"{tree!r} would {excess}, with its subtrees")
            break
    return result


def in_order(calls: Mapping[str, Call], faults: Faults) -> list[str]:
    """Return the trees in an order in which each follows those that it uses; recursive trees are mistakes."""
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


def _excess(count: int, depth: int, keys: int) -> str:
    """Return which limit a tree exceeds, as text; empty if none."""
    if count > MAX_NODES:
        return f"have more than {MAX_NODES} nodes"
    if depth > MAX_DEPTH:
        return f"be more than {MAX_DEPTH} levels deep"
    return f"use more than {_MAX_KEYS} keys" if keys > _MAX_KEYS else ""


def _all(call: Call) -> Iterator[Call]:
    yield call
    for child in call.children:
        yield from _all(child)


def _size(part: Element, sizes: Mapping[str, tuple[int, int]]) -> tuple[int, int]:
    """Return the number of nodes of a part, and their depth."""
    if part.tag == SUBTREE:
        return sizes[part.attrib["ID"]]
    children = [_size(child, sizes) for child in part]
    return 1 + sum(count for count, _ in children), 1 + max((depth for _, depth in children), default=0)


class _Translator:
    """Translates one tree; its subtrees are translated already."""

    def __init__(self, result: Translation, tree: str, faults: Faults) -> None:
        self._result = result
        self._faults = faults
        self._tree = tree
        self._keys: dict[str, None] = {}
        self._namespaces: set[str] = set()

    def add(self, call: Call) -> None:
        root = Element("BehaviorTree", ID=self._tree)
        root.append(self._whole(call))
        self._result.trees[self._tree] = root
        self._result.keys[self._tree] = tuple(self._keys)

    def _whole(self, call: Call) -> Part:
        """Return a part with the conditions around it."""
        part = self._subtree(call) if call.node is None else self._node(call)
        if call.around is None:
            return part
        outer = self._scripted(call.around, call.conditions, call.origin, " ".join(call.conditions))
        outer.append(part)
        return outer

    def _node(self, call: Call) -> Part:
        name = call.origin.name or call.origin.tag
        node: type[Any] = call.node or SubTree
        if call.scripts:
            part = self._scripted(node, call.scripts, call.origin, name, call.ports)
        else:
            self._result.registry.setdefault(call.origin.tag, node)
            part = self._part(call.origin.tag, call.origin, name, call.ports)
        part.extend(self._whole(child) for child in call.children)
        return part

    def _scripted(
        self,
        node: type[Any],
        scripts: Mapping[str, Script],
        origin: Origin,
        name: str,
        ports: Mapping[str, str] | None = None,
    ) -> Part:
        """Return a part with a class generated for its scripts, which has a port for each of their keys."""
        tag = f"{origin.tag}#{len(self._result.registry)}"
        self._result.registry[tag] = node
        known = {*node.input_ports(), *node.output_ports()}
        names = dict.fromkeys(name for script in scripts.values() for name in script.names)
        used = {port: f"{{{key}}}" for key in names for port in (key, f"{key}>") if port in known}
        return self._part(tag, origin, name, {**(ports or {}), **used})

    def _subtree(self, call: Call) -> Part:
        self._look_at_shared(call)
        shared = {port: text for port, text in call.ports.items() if text.startswith("{")}
        for key in self._result.keys[call.tree]:
            if key.startswith("@") or (call.autoremap and not key.startswith("_") and key not in call.ports):
                shared[key] = f"{{{key}}}"
        inner = self._part(SUBTREE, call.origin, self._namespace(call), shared)
        inner.attrib["ID"] = call.tree
        inner.texts = {port: text for port, text in call.ports.items() if port not in shared}
        self._result.registry.setdefault(_SHOWN_SUBTREE, SubTree)
        outer = self._part(_SHOWN_SUBTREE, call.origin, call.origin.name or call.tree, {})
        outer.append(inner)
        return outer

    def _look_at_shared(self, call: Call) -> None:
        """Warn of what is shared with a subtree that does not use it, if it uses something like it."""
        used = [key for key in self._result.keys[call.tree] if key not in call.ports]
        for port in call.ports:
            if port not in self._result.keys[call.tree] and (alike := meant(port, used)):
                self._faults.warn(call.origin, f"{call.tree!r} uses no {port!r}; did you mean {alike!r}?")

    def _namespace(self, call: Call) -> str:
        """Return a unique name within this tree for a subtree's namespace on the blackboard."""
        base = name = re.sub(r"[^\w-]|_{2,}", "_", call.origin.name or call.tree)
        number = 1
        while name in self._namespaces:
            number += 1
            name = f"{base}_{number}"
        self._namespaces.add(name)
        return name

    def _part(self, tag: str, origin: Origin, shown: str, ports: Mapping[str, str]) -> Part:
        part = Part(tag, {"name": shown, **ports})
        part.origin, part.shown, part.texts = origin, shown, {}
        self._keys.update(dict.fromkeys(text[1:-1] for text in ports.values() if text.startswith("{")))
        return part

"""Drafts of nodes: what py_trees' parser says of a file, read once; the nodes of each robot's tree are made of it.

The parser makes nodes while it reads. It sees the nodes' own classes here, but what it makes are drafts.
"""

from __future__ import annotations

from functools import partial
from inspect import Signature
from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.parsers.behaviour_tree_xml import build_tree_from_xml

from bt_controller.core.node import Connections, Node
from bt_controller.errors import TreeError
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.xml.translation import Translation


class Draft(Behaviour):
    """A node that is yet to be made.

    Args:
        node: Its class.
        behaviour_class_name: Its tag.
        **known: The other arguments of its constructor; its children are drafts.
    """

    def __init__(self, node: type[Any], *, name: str, behaviour_class_name: str, **known: Any) -> None:
        super().__init__(name)
        self._node = node
        self._tag = behaviour_class_name
        self._known = known
        self._ports: dict[str, Any] = {}
        self._connections: Connections | None = None
        self._shown, self._origin = name, ""
        if "child" in known:
            self.children = [known["child"]]
        self.children += known.get("children", ())

    def setup_ports(self, port_remappings: Mapping[str, str], subtree_namespace: str = "/", **others: Any) -> None:
        """Look up the keys of the ports: those of all nodes that are made of this draft, each on its own blackboard."""
        if issubclass(self._node, Node):
            own = f"{self.name}_{self.id}"
            self._connections = Connections.of(self._node, own, port_remappings, subtree_namespace)
        else:
            self._ports = {"port_remappings": port_remappings, "subtree_namespace": subtree_namespace, **others}

    def label(self, shown: str, origin: str) -> None:
        """Set what the nodes are called in messages, and where they stand in the file."""
        self._shown, self._origin = shown, origin

    def update(self) -> Status:
        """Return that a draft can't be ticked."""
        return Status.INVALID

    def made(self) -> Any:
        """Return a new node with new children, on the blackboard in use.

        Raises:
            TreeError: A constructor raises an error.
        """
        known = dict(self._known)
        if "child" in known:
            known["child"] = known["child"].made()
        if "children" in known:
            known["children"] = [child.made() for child in known["children"]]
        try:
            node = self._node(name=self.name, behaviour_class_name=self._tag, **known)
        except Exception as error:
            raise TreeError(f"<{self._tag}>: {described(error)}") from error
        if self._connections is None:
            node.setup_ports(**self._ports)
        else:
            node.connect(self._connections)
            node.origin = self._origin
        node.name = self._shown
        return node


class _Drafting(partial[Any]):
    """A node's class as py_trees' parser takes it; called, it returns a draft.

    For each node the parser would look through the constructors of all bases of the class, which takes longer than all
    the rest: a signature that is said need not be looked for.
    """

    __signature__: ClassVar = Signature()

    def __call__(self, /, *_args: Any, **known: Any) -> Draft:
        """Return a draft of a node."""
        return Draft(self.func, **known)  # type: ignore[arg-type]  # it is a class


def drafted(main: str, translation: Translation) -> Draft:
    """Return the draft of a tree.

    Args:
        main: The ID of the outermost tree.
        translation: All trees of the file.
    """
    # In the outermost tree a key and the same with @ are one.
    outermost = {key: f"/{key[1:]}" for key in translation.keys[main] if key.startswith("@")}
    nodes = {tag: _Drafting(node) for tag, node in translation.registry.items()}
    draft: Any = build_tree_from_xml(translation.trees[main], outermost, nodes, translation.trees)
    return draft  # type: ignore[no-any-return]  # what the parser makes of a node is a draft

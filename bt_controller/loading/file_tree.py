"""The tree of a file, read and checked once and built for each robot, and the nodes that a file may use.

A built tree is checked for the types of connected ports, and for keys that nothing writes or reads.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from py_trees.blackboard import Blackboard
from py_trees.ports import PortsMixin

from bt_controller.core.blackboards import GENERATED, Board
from bt_controller.core.node import Node
from bt_controller.errors import TreeError
from bt_controller.loading.builder import check_subtrees, plan
from bt_controller.loading.check import check
from bt_controller.loading.named_functions import imported
from bt_controller.loading.source import Element, Faults, document, read
from bt_controller.nodes import nodes_in, registry
from hmrsim.caches import FileCache
from hmrsim.diagnostics import meant
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.ports import Kind
    from bt_controller.loading.builder import Blueprint
    from bt_controller.loading.source import Origin


_LOOSE: Final = (object, str)
"""The types that match every kind: text is parsed by the port that reads it."""
_NUMBERS: Final = (int, float)


@dataclass(frozen=True)
class _End:
    """A port with its key.

    Attributes:
        key: The key that it is connected to.
        kind: The kind of its values; None if unknown.
        written: Whether it is an output.
        needed: Whether it is a required input.
        scripted: Whether it is an entry of a script.
        renewed: Whether it is an output whose first value has to come from elsewhere, as its node needs it, too.
    """

    origin: Origin
    port: str
    key: str
    kind: Kind[Any] | None
    written: bool
    needed: bool
    scripted: bool
    renewed: bool


def examine(nodes: Iterable[tuple[Behaviour, Origin]], faults: Faults) -> tuple[str, ...]:
    """Check a tree that was just built on the blackboard in use.

    Args:
        nodes: The nodes with their origins.
        faults: Collects mismatched ports, invalid values, and warnings of script entries without a value.

    Returns:
        A line for each port that needs a value which nothing writes.
    """
    ends = [end for node, origin in nodes if isinstance(node, PortsMixin) for end in _ends(node, origin)]
    _compare(ends, faults)
    _read(ends, faults)
    written = {end.key for end in ends if end.written and not end.renewed} | set(Blackboard.storage)
    unset = [end.origin.says(_unset(end)) for end in ends if end.needed and end.key not in written]
    outputs = [end.key.rpartition("/") for end in ends if end.written]
    for end in ends:
        if end.written or end.needed or end.key in written:
            continue
        if end.scripted:
            faults.warn(end.origin, f"nothing writes {_shown(end.key)!r}, which a script reads")
        elif not GENERATED.search(end.key):
            # A port with a default: this is no error unless another key of the same tree was intended.
            tree, _, key = end.key.rpartition("/")
            near = [name for place, _, name in outputs if place == tree]
            if key != end.port and (alike := meant(key, near)):
                faults.warn(end.origin, f"port {end.port!r}: nothing writes {key!r}; did you mean {alike!r}?")
    return tuple(dict.fromkeys(unset))


def unread(keys: Iterable[str]) -> tuple[str, ...]:
    """Return a line for each key that no node reads, after the tree was built on the blackboard in use."""
    read = [_shown(key) for key, known in Blackboard.metadata.items() if known.read]
    lines = []
    for key in keys:
        if key not in read:
            alike = meant(key, read)
            lines.append(f"nothing reads {key!r}" + (f"; did you mean {alike!r}?" if alike else ""))
    return tuple(lines)


def _ends(node: PortsMixin, origin: Origin) -> Iterator[_End]:
    names = {name for script in getattr(node, "scripts", {}).values() for name in script.names}
    needed: set[str] = set()
    for ports, written in ((node.input_ports(), False), (node.output_ports(), True)):
        for name, port in ports.items():
            key = _key_of(node, name)
            if needs := not written and port.required and port.default_value is None:
                needed.add(key)
            renewed = written and key in needed
            yield _End(origin, name, key, getattr(port, "kind", None), written, needs, name in names, renewed)


def _key_of(node: PortsMixin, port: str) -> str:
    if isinstance(node, Node):
        return node.key_of(port)
    client = node.blackboard_client
    key: str = client.remappings[client.absolute_name(port)]
    return key


def _compare(ends: Iterable[_End], faults: Faults) -> None:
    """Check that ports with the same key have matching kinds."""
    known: dict[str, _End] = {}
    for end in ends:
        if end.kind is None or end.kind.type in _LOOSE:
            continue
        first = known.setdefault(end.key, end)
        if _name(first) != _name(end) and not (_is_number(first) and _is_number(end)):
            other = f"port {first.port!r} of <{first.origin.tag}>, {first.origin}"
            key = _shown(end.key)
            text = f"port {end.port!r} is {_name(end)}, but {key!r} is {_name(first)} at {other}; use another key"
            faults.add(end.origin, text)


def _read(ends: Iterable[_End], faults: Faults) -> None:
    """Check that the initial texts on the blackboard are valid for their ports."""
    for end in ends:
        text = Blackboard.storage.get(end.key)
        if isinstance(text, str) and end.kind is not None and not end.written:
            try:
                end.kind.read(text, None)
            except ValueError as error:
                faults.add(end.origin, f"port {end.port!r}: {error}")


def _unset(end: _End) -> str:
    shown = _shown(end.key)
    give = f"give it with --set {shown}=…"
    if "/" in shown:
        return f'nothing writes {shown!r}; share {shown.rpartition("/")[2]}="{{…}}" at its <SubTree>, or {give}'
    return f"nothing writes {shown!r}; {give}"


def _is_number(end: _End) -> bool:
    return end.kind is not None and end.kind.type in _NUMBERS


def _name(end: _End) -> str:
    return "" if end.kind is None else end.kind.name


def _shown(key: str) -> str:
    return key.removeprefix("/")


@dataclass(frozen=True)
class FileTree:
    """A tree of a file.

    Attributes:
        blueprint: Its root.
        texts: The initial blackboard entries of its subtrees.
        files: The files that it was read from.
    """

    blueprint: Blueprint
    texts: Mapping[str, str]
    files: tuple[str, ...]

    def build(self) -> Behaviour:
        """Return the root of a new tree, on the blackboard in use."""
        for key, text in self.texts.items():
            Blackboard.set(key, text)
        root: Behaviour = self.blueprint.build()
        return root


def load_file(
    path: str, nodes: Mapping[str, type[Any]], *, tree: str | None, values: Mapping[str, str]
) -> tuple[FileTree, tuple[str, ...], tuple[str, ...]]:
    """Return the tree of a file, a line for each required port that nothing writes, and one for each warning.

    Args:
        path: The file.
        nodes: The known nodes by tag.
        tree: The ID of the tree to run; None for the file's main tree.
        values: The initial texts on each blackboard.

    Raises:
        TreeError: The file is invalid; the text has one line for each error.
    """
    key = (path, str(Path(path).absolute()), frozenset(nodes.items()), tree, frozenset(values.items()))
    # Checking a tree takes ten times as long as building it.
    return _LOADED.get(key, partial(_load, path, nodes, tree, values), lambda loaded: loaded.result.files)


class _Loaded(NamedTuple):
    """A tree as it was loaded."""

    result: FileTree
    unset: tuple[str, ...]
    warnings: tuple[str, ...]


_LOADED: Final[FileCache[_Loaded]] = FileCache()


def _load(path: str, nodes: Mapping[str, type[Any]], tree: str | None, values: Mapping[str, str]) -> _Loaded:
    root = read(path)
    faults = Faults()
    found = document(root, faults, tree=tree)
    calls = check(found, nodes, faults)
    check_subtrees(calls, faults)
    faults.raise_any()
    files = dict.fromkeys(element.origin.file for element in root.iter() if isinstance(element, Element))
    result = FileTree(*plan(found.main, calls), tuple(files))
    unset, unknown = _tried(path, result, values, faults)
    faults.raise_any()
    return _Loaded(result, unset, (*faults.warnings, *unknown))


def _tried(
    path: str, tree: FileTree, values: Mapping[str, str], faults: Faults
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Build a tree and check it for keys that nothing writes or nothing reads."""
    with Board().in_use:
        for key, text in values.items():
            Blackboard.set(key, text)
        try:
            root = tree.build()
        except TreeError as error:
            raise TreeError(f"{path}: {error}") from error
        except Exception as error:  # such as a value that its port does not take
            raise TreeError(f"{path}: {described(error)}") from error
        # A guard adds a drive back, which no file names.
        nodes = [node for node in root.iterate() if not getattr(node, "implied", False)]
        unset = examine(zip(nodes, tree.blueprint.origins(), strict=True), faults)
        return unset, unread(values)


def vocabulary(modules: Iterable[str] = ()) -> dict[str, type[Any]]:
    """Return all nodes by tag.

    Args:
        modules: The user's modules; each public subclass of Node is a node with its name as the tag.

    Raises:
        TreeError: A module can't be imported, has no nodes, or defines an existing tag.
    """
    found: dict[str, type[Any]] = dict(registry())
    for name in modules:
        module = imported(f"--nodes {name}".rstrip(), name)
        if not (classes := nodes_in(module)):
            raise TreeError(f"--nodes {name}: it defines no nodes, public subclasses of bt_controller.core.node.Node")
        for tag, value in classes.items():
            if found.setdefault(tag, value) is not value:
                where = found[tag].__module__
                raise TreeError(f"--nodes {name}: node {tag!r} exists already, in {where}; rename the class")
    return found

"""Reading of untrusted XML files: limits of size, their trees, and one line for each error, with file and line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final
from xml.etree.ElementTree import Element as _Element

from bt_controller.errors import TreeError
from hmrsim.diagnostics import instead, meant, shortened, shown
from hmrsim.errors import reason_of
from hmrsim.safe_xml import XmlError, parse

MAX_BYTES: Final = 1 << 20
"""The largest size of all files of a tree in bytes; a hand-written one has a few thousand."""
MAX_NODES: Final = 10_000
"""The largest number of elements in all files of a tree, and of nodes in the tree."""
MAX_LETTERS: Final = 10_000
"""The largest length of a tag or an attribute."""

_MAX_INCLUDES: Final = 20
"""The largest depth of includes."""

_INCLUDES: Final = ("include", "Include", "Import")
_PATHS: Final = ("path", "src", "file")
"""The attributes of an included path in BehaviorTree.CPP and in py_trees."""


class Element(_Element):
    """An element with its place in the file."""

    def __init__(self, tag: str, attributes: dict[str, str], origin: Origin) -> None:
        super().__init__(tag, attributes)
        self.origin = origin


def read(path: str) -> Element:
    """Return the root element of a file, with included files inserted.

    Raises:
        TreeError: The file can't be read, is not XML, or exceeds a limit.
    """
    file = Path(path)
    if missing := _missing(file):
        raise TreeError(Origin(str(file), 0).says(missing))
    return _Reader(file).main()


class _Reader:
    """Reads a file and the files that it includes, each once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._folder = path.parent.resolve()
        self._left = MAX_BYTES
        self._elements = 0
        self._errors: dict[str, None] = {}
        self._begun: list[Path] = []
        self._done: set[Path] = set()

    def main(self) -> Element:
        origin = Origin(str(self._path), 0)
        root = self._read(self._path.resolve(), origin, origin)
        if self._errors:
            raise TreeError("\n".join(list(self._errors)[:MAX_FAULTS]))
        return root

    def _read(self, path: Path, file: Origin, asked: Origin) -> Element:
        try:
            with path.open("rb") as opened:
                data = opened.read(max(self._left, 0) + 1)
        except OSError as error:
            raise TreeError(asked.says(f"can't read {file.file!r}: {reason_of(error)}")) from None
        self._left -= len(data)
        if self._left < 0:
            raise TreeError(file.says(f"larger than {MAX_BYTES} bytes, with all included files"))
        make = partial(self._element, file.file)
        try:
            root = parse(data, make, max_elements=MAX_NODES)
        except XmlError as error:
            raise TreeError(Origin(file.file, error.line or 1).says(str(error))) from None
        self._begun.append(path)
        self._inline(root, path)
        self._begun.pop()
        return root

    def _element(self, file: str, tag: str, attributes: dict[str, str], line: int) -> Element:
        self._elements += 1
        if self._elements > MAX_NODES:
            raise XmlError(f"has more than {MAX_NODES} elements, with all included files", line)
        if max(map(len, [tag, *attributes, *attributes.values()])) > MAX_LETTERS:
            raise XmlError(f"has a text of more than {MAX_LETTERS} characters", line)
        return Element(tag, attributes, Origin(file, line, tag, attributes.get("name", "")))

    def _inline(self, root: Element, path: Path) -> None:
        """Insert included files into an element."""
        children: list[Any] = list(root)
        root[:] = []
        for child in children:
            if child.tag in _INCLUDES:
                root.extend(self._included_if_right(child, path))
            else:
                root.append(child)

    def _included_if_right(self, element: Element, path: Path) -> list[Any]:
        """Return the trees of an included file; its errors are reported after all files have been read."""
        try:
            return self._included(element, path)
        except TreeError as error:
            self._errors[str(error)] = None
            return []

    def _included(self, element: Element, path: Path) -> list[Any]:
        origin = element.origin
        if "ros_pkg" in element.attrib:
            raise TreeError(origin.says("ROS packages are not supported; give a path relative to this file"))
        name = next((element.attrib[key] for key in _PATHS if key in element.attrib), "")
        if not name.isprintable() or not name:
            raise TreeError(origin.says('needs path="…", relative to this file'))
        try:
            wanted = (path.parent / name).resolve()
        except (OSError, RuntimeError):
            raise TreeError(origin.says(f"{shown(name)} is not a valid path")) from None
        if not wanted.is_relative_to(self._folder):
            raise TreeError(origin.says(f"{shown(name)} is outside the folder of {self._path.name!r}"))
        if wanted in self._begun:
            raise TreeError(origin.says(f"{shown(name)} includes itself"))
        if len(self._begun) >= _MAX_INCLUDES:
            raise TreeError(origin.says(f"includes are nested more than {_MAX_INCLUDES} deep"))
        if wanted in self._done:
            return []
        self._done.add(wanted)
        if missing := _missing(wanted):
            raise TreeError(origin.says(f"{shown(name)}: {missing}"))
        root = self._read(wanted, Origin(str(self._path.parent / wanted.relative_to(self._folder)), 0), origin)
        if root.tag != "root":
            raise TreeError(root.origin.says("not a file of trees; expected <root>"))
        return list(root)


def _missing(path: Path) -> str:
    """Return why a path can't be read; empty if it can."""
    try:
        if path.is_file():
            return ""
        return "not a regular file" if path.exists() else "no such file"
    except OSError as error:
        return reason_of(error)


MAX_FAULTS: Final = 50
"""The largest number of errors in a message: more do not help, and each suggestion takes time to compute."""

_MAX_LINE: Final = 400


@dataclass(frozen=True)
class Origin:
    """The place of an element in the files.

    Attributes:
        file: The file, as the user names it.
        line: The line, from 1; 0 for the whole file.
        name: The element's ``name``; empty if it has none.
    """

    file: str
    line: int
    tag: str = ""
    name: str = ""

    def __str__(self) -> str:
        """Return file and line."""
        return f"{self.file}:{self.line}" if self.line else self.file

    def says(self, text: str) -> str:
        """Return a message about the element as one line."""
        element = f" <{shortened(self.tag)}>" if self.tag else ""
        name = f" {shown(self.name)}" if self.name and self.name != self.tag else ""
        line = " ".join(f"{self}:{element}{name}{':' if element else ''} {text}".splitlines())
        return line if len(line) <= _MAX_LINE else f"{line[:_MAX_LINE]}…"


class Faults:
    """The errors found so far."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}
        self._warnings: dict[str, None] = {}

    @property
    def warnings(self) -> tuple[str, ...]:
        """The warnings; one line for each."""
        return tuple(self._warnings)

    def add(self, origin: Origin, text: str) -> None:
        """Add an error; duplicates count once.

        Raises:
            TreeError: There are `MAX_FAULTS` errors.
        """
        self._lines[origin.says(text)] = None
        if len(self._lines) >= MAX_FAULTS:
            raise TreeError("\n".join([*self._lines, f"stopped after {MAX_FAULTS} errors"]))

    def warn(self, origin: Origin, text: str) -> None:
        """Add a warning; only a limited number of them is kept."""
        if len(self._warnings) < MAX_FAULTS:
            self._warnings[origin.says(text)] = None

    def raise_any(self) -> None:
        """Raise an error if there were any.

        Raises:
            TreeError: Something was; a line each.
        """
        if self._lines:
            raise TreeError("\n".join(self._lines))


_ROOT_ATTRIBUTES: Final = ("BTCPP_format", "main_tree_to_execute")
_PORTS: Final = ("input_port", "output_port", "inout_port")
_PARTS: Final = ("BehaviorTree", "TreeNodesModel", "include")


@dataclass(frozen=True)
class Document:
    """The trees of a file.

    Attributes:
        trees: The <BehaviorTree> elements by ID.
        main: The ID of the tree to run.
        models: The ports of subtrees by ID, each with its default; None if it has none.
    """

    trees: Mapping[str, Element]
    main: str
    models: Mapping[str, Mapping[str, str | None]]


def document(root: Element, faults: Faults, *, tree: str | None = None) -> Document:
    """Return the trees of a file.

    Args:
        root: The root element.
        faults: Collects the errors; invalid elements are left out.
        tree: The ID of the tree to run; by default the file's main tree.
    """
    if root.tag != "root":
        faults.add(root.origin, 'is not a file of trees; expected <root BTCPP_format="4">')
    trees, models = _parts(root, faults)
    found = root.findall("BehaviorTree")
    if not found and root.tag == "root":
        faults.add(root.origin, 'has no trees; expected <BehaviorTree ID="…">')
    if found:
        _look(root, faults)
    # A tree without an ID is reported already, and may be the main tree.
    known = bool(found) and all(element.attrib.get("ID") for element in found)
    return Document(trees, _main(root, trees, tree, faults) if known else "", models)


def _parts(root: Element, faults: Faults) -> tuple[dict[str, Element], dict[str, dict[str, str | None]]]:
    trees: dict[str, Element] = {}
    models: dict[str, dict[str, str | None]] = {}
    children: list[Any] = list(root)
    for child in children:
        if child.tag == "BehaviorTree":
            _add_tree(child, trees, faults)
        elif child.tag == "TreeNodesModel":
            models |= {model.attrib["ID"]: _model(model) for model in child.findall("SubTree") if "ID" in model.attrib}
        elif root.tag == "root":
            faults.add(child.origin, f"not allowed in <root>{instead(child.tag, _PARTS)}")
    return trees, models


def _add_tree(element: Any, trees: dict[str, Element], faults: Faults) -> None:
    tree_id = element.attrib.get("ID", "")
    for attribute in element.attrib:
        if attribute != "ID" and not attribute.startswith("_"):
            faults.add(element.origin, f"unknown attribute {shown(attribute)}; expected ID")
    if not tree_id:
        faults.add(element.origin, 'has no ID; write ID="…"')
        return
    if len(element) != 1:
        faults.add(element.origin, f"{shown(tree_id)} has {len(element)} children; expected exactly 1")
    if tree_id in trees:
        faults.add(element.origin, f"tree {shown(tree_id)} is already defined at {trees[tree_id].origin}")
    else:
        trees[tree_id] = element


def _model(element: Any) -> dict[str, str | None]:
    return {
        port.attrib["name"]: port.attrib.get("default") or None
        for port in element
        if port.tag in _PORTS and "name" in port.attrib
    }


def _look(root: Element, faults: Faults) -> None:
    """Check the attributes of the root."""
    for attribute in root.attrib:
        if attribute not in _ROOT_ATTRIBUTES and (alike := meant(attribute, _ROOT_ATTRIBUTES)):
            faults.add(root.origin, f"unknown attribute {shown(attribute)}; did you mean {alike!r}?")
    said = root.attrib.get("BTCPP_format")
    if said is None:
        faults.warn(root.origin, 'has no BTCPP_format; "4" is assumed, and BehaviorTree.CPP requires it')
    elif said != "4":
        faults.add(root.origin, f'has the format {shown(said)}; expected BTCPP_format="4"')


def _main(root: Element, trees: Mapping[str, Element], tree: str | None, faults: Faults) -> str:
    main = root.attrib.get("main_tree_to_execute") if tree is None else tree
    if main is None and len(trees) > 1:
        known = ", ".join(trees)
        faults.add(root.origin, f"names no tree to run; give main_tree_to_execute or --tree, one of {known}")
    elif main is not None and main not in trees:
        faults.add(root.origin, f"unknown tree {shown(main)}{instead(main, trees)}")
    return next(iter(trees)) if main is None else main

"""Reading XML files that may come from anybody: elements that know where they are, and nothing that blows up."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final
from xml.etree.ElementTree import Element as _Element
from xml.parsers import expat

from bt_controller.trees import TreeError
from bt_controller.xml.faults import Origin

LARGEST: Final = 1 << 20
"""Bytes of all files of a tree; a hand-written one has a few thousand."""
MOST_NODES: Final = 10_000
"""Elements of all files of a tree, and nodes of the tree that they make."""
DEEPEST: Final = 100
"""How deep elements may be in each other, and nodes in a tree: py_trees goes down by recursion."""

LONGEST: Final = 10_000
"""Letters of a tag or an attribute."""

_MOST_INCLUDES: Final = 20
"""How many files may include the next."""

_INCLUDES: Final = ("include", "Include", "Import")
_PATHS: Final = ("path", "src", "file")
"""How BehaviorTree.CPP calls what is included, and how py_trees does."""


class Element(_Element):
    """An element that knows its place."""

    origin: Origin


def read(path: str) -> Element:
    """Return the root element of a file, with all that it includes in place.

    Raises:
        TreeError: It can't be read, is no XML, or more than a tree can need.
    """
    return _Reader(Path(path)).main()


class _Reader:
    """Reads a file and what it includes; what it includes twice it reads once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._folder = path.parent.resolve()
        self._left = LARGEST
        self._elements = 0
        self._begun: list[Path] = []
        self._done: set[Path] = set()

    def main(self) -> Element:
        origin = Origin(str(self._path), 0)
        if not self._path.is_file():
            raise TreeError(f"{origin}: there is no such file")
        return self._read(self._path.resolve(), origin, origin)

    def _read(self, path: Path, shown: Origin, asked: Origin) -> Element:
        try:
            with path.open("rb") as file:
                data = file.read(self._left + 1)
        except OSError as error:
            raise TreeError(
                asked.says(f"can't read {shown.file!r}: {(error.strerror or str(error)).lower()}")
            ) from None
        self._left -= len(data)
        if self._left < 0:
            raise TreeError(shown.says(f"more than {LARGEST} bytes are no tree"))
        self._begun.append(path)
        parser = _Parser(shown.file, MOST_NODES - self._elements)
        root = parser.parse(data)
        self._elements += parser.count
        self._inline(root, path)
        self._begun.pop()
        self._done.add(path)
        return root

    def _inline(self, root: Element, path: Path) -> None:
        """Put what a file includes where it includes it."""
        children: list[Any] = list(root)
        root[:] = []
        for child in children:
            if child.tag in _INCLUDES:
                root.extend(self._included(child, path))
            else:
                root.append(child)

    def _included(self, element: Element, path: Path) -> list[Any]:
        origin = element.origin
        if "ros_pkg" in element.attrib:
            raise TreeError(origin.says("there are no ROS packages here; give a path relative to this file"))
        name = next((element.attrib[key] for key in _PATHS if key in element.attrib), "")
        if not name.isprintable() or not name:
            raise TreeError(origin.says('needs path="…", relative to this file'))
        wanted = (path.parent / name).resolve()
        if not wanted.is_relative_to(self._folder):
            raise TreeError(origin.says(f"{name!r} is outside the folder of {self._path.name!r}, and not read"))
        if wanted in self._begun:
            raise TreeError(origin.says(f"{name!r} includes itself"))
        if len(self._begun) >= _MOST_INCLUDES:
            raise TreeError(origin.says(f"files include each other more than {_MOST_INCLUDES} deep"))
        if wanted in self._done:
            return []
        if not wanted.is_file():
            raise TreeError(origin.says(f"there is no file {name!r}"))
        shown = Origin(str(self._path.parent / wanted.relative_to(self._folder)), 0)
        root = self._read(wanted, shown, origin)
        if root.tag != "root":
            raise TreeError(root.origin.says("is no file of trees; <root> is expected"))
        return list(root)


class _Parser:
    """Makes elements of one file's bytes."""

    def __init__(self, file: str, most: int) -> None:
        self.count = 0
        self._file = file
        self._most = most
        self._open: list[Element] = []
        self._root: Element | None = None
        self._expat: Any = expat.ParserCreate()
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.StartDoctypeDeclHandler = self._doctype

    def parse(self, data: bytes) -> Element:
        try:
            self._expat.Parse(data, True)
        except expat.ExpatError as error:
            text = expat.ErrorString(error.code)
            raise TreeError(Origin(self._file, error.lineno).says(f"no XML: {text}")) from None
        except (LookupError, ValueError) as error:
            raise TreeError(self._here().says(f"no XML: {error}")) from None
        if self._root is None:
            raise TreeError(self._here().says("no XML: no element found"))
        return self._root

    def _here(self, tag: str = "", name: str = "") -> Origin:
        return Origin(self._file, self._expat.CurrentLineNumber, tag, name)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.count += 1
        if self.count > self._most:
            raise TreeError(self._here().says(f"more than {MOST_NODES} elements are no tree"))
        if len(self._open) >= DEEPEST:
            raise TreeError(self._here().says(f"elements are more than {DEEPEST} levels deep"))
        if max(map(len, [tag, *attributes, *attributes.values()])) > LONGEST:
            raise TreeError(self._here().says(f"a text of more than {LONGEST} letters is none for a tree"))
        element = Element(tag, attributes)
        element.origin = self._here(tag, attributes.get("name", ""))
        if self._open:
            self._open[-1].append(element)
        else:
            self._root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _doctype(self, *_declared: object) -> None:
        raise TreeError(self._here().says("a DOCTYPE is not read; leave it out, trees need no entities"))

"""Builds the site of the documentation, and fails if something on it leads nowhere.

Run as ``python -m tools.site``. The page of the changelog is made from CHANGELOG.md first. Zensical reports links to
pages and headings that do not exist. This module checks the rest: images, the links of the README and its like, and
whether each public name has its place.
"""

from __future__ import annotations

import argparse
import importlib
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from typing import Final
from urllib.parse import unquote, urlsplit

from markdown_it import MarkdownIt

_ROOT: Final = Path(__file__).parents[1]
_SITE: Final = _ROOT / ".make" / "site"
_BESIDE: Final = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
"""Pages of the repository that are not on the site, and lead there."""
_DOCUMENT: Final = re.compile(r"^docs/(.*)\.md")
_PUBLIC: Final = (
    "hmrsim",
    "hmrsim.events",
    "hmrsim.experiments.statistics",
    "hmrsim.testing",
    "hmrsim_gym",
    "hmrsim_zenoh",
    "bt_controller",
)


class Page(HTMLParser):
    """A page of the site: the ids of its elements, and the targets of its links."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.places: set[str] = set()
        self.targets: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Record the id or the target of an element."""
        for name, value in attrs:
            if name == "id" and value:
                self.places.add(value)
            elif name in {"href", "src"} and value and tag != "base":
                self.targets.append(value)


def main(argv: Sequence[str] | None = None) -> int:
    """Build the site; return 1 if something is wrong with it."""
    parser = argparse.ArgumentParser(prog="python -m tools.site", description=main.__doc__)
    parser.add_argument("--prepare", action="store_true", help="only make the pages that are not in docs/")
    arguments = parser.parse_args(argv)
    (_ROOT / "docs" / "changelog.md").write_text(changelog_page(_ROOT), encoding="utf-8")
    if arguments.prepare:
        return 0
    built = subprocess.run(
        [sys.executable, "-m", "zensical", "build", "--clean", "--strict"],
        cwd=_ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    if built.returncode:
        sys.stderr.write(f"{built.stdout}{built.stderr}")
        return 1
    pages = {path: Page(path) for path in sorted(_SITE.rglob("*.html"))}
    wrong = [*_dead(pages), *_dead_beside(pages), *_missing(pages)]
    for line in wrong:
        sys.stderr.write(f"{line}\n")
    sys.stdout.write(f"{len(pages)} pages in {_SITE.relative_to(_ROOT)}\n")
    return 1 if wrong else 0


def changelog_page(root: Path) -> str:
    """Return the text of the changelog with links as seen from docs/."""
    return (root / "CHANGELOG.md").read_text(encoding="utf-8").replace("](docs/", "](")


def _dead(pages: dict[Path, Page]) -> Iterator[str]:
    """Yield the links of pages that lead nowhere."""
    for path, page in pages.items():
        if path.name == "404.html":  # served at any depth, so that its links can't be followed here
            continue
        for target in page.targets:
            if why := fault_of(target, path.parent, pages):
                yield f"{path.relative_to(_SITE)}: {target}: {why}"


def _dead_beside(pages: dict[Path, Page]) -> Iterator[str]:
    """Yield the links of pages beside the site that lead nowhere."""
    for name in _BESIDE:
        for target in _links_of((_ROOT / name).read_text(encoding="utf-8")):
            if why := fault_of(_DOCUMENT.sub(rf"{_SITE}/\1.html", target), _ROOT, pages):
                yield f"{name}: {target}: {why}"


def _links_of(text: str) -> Iterator[str]:
    for block in MarkdownIt("commonmark").enable("table").parse(text):
        for token in block.children or ():
            target = token.attrGet("href") or token.attrGet("src")
            if target:
                yield str(target)


def fault_of(target: str, folder: Path, pages: dict[Path, Page]) -> str:
    """Return the error of a link, or an empty text; links to other sites are not checked."""
    parts = urlsplit(target)
    if parts.scheme or parts.netloc:
        return "" if parts.scheme in {"https", "http", "data"} else "expected a path or an address"
    if not parts.path:
        return ""  # a heading of the same page, at which Zensical has looked
    there = (folder / unquote(parts.path)).resolve()
    if not there.exists():
        return "there is no such file"
    if parts.fragment and there in pages and unquote(parts.fragment) not in pages[there].places:
        return "there is no such heading"
    return ""


def _missing(pages: dict[Path, Page]) -> Iterator[str]:
    """Yield the public names that no page describes."""
    places = set[str]().union(*(page.places for page in pages.values()))
    for module in _PUBLIC:
        package = importlib.import_module(module)
        for name in package.__all__:
            is_module = isinstance(getattr(package, name), ModuleType)  # modules have separate pages
            if f"{module}.{name}" not in places and not is_module and not name.startswith("__"):
                yield f"docs/reference/python: {module}.{name} has no place there"


if __name__ == "__main__":
    sys.exit(main())

"""Checks the prose of the documentation for empty phrases, and for phrases for which the project has a word.

Run as ``python -m tools.prose``; code is left out. Spelling is codespell's.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from markdown_it import MarkdownIt

_ROOT: Final = Path(__file__).parents[1]
_PAGES: Final = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/**/*.md")
_BANNED: Final[Mapping[str, str]] = {
    r"simply|just|easy|easily|of course|obviously|clearly|basically|actually": "leave it out",
    r"very|quite|really|extremely": "leave it out, or give the number",
    r"please|note that|as you can see": "leave it out",
    r"powerful|seamless(ly)?|blazing|cutting-edge|state-of-the-art": "say what it does",
    r"utili[sz]es?|leverages?": "use",
    r"in order to": "to",
    r"allows? (you|one|users) to": "name the thing that can be done",
    r"e\.g\.|i\.e\.|etc\.": "such as; that is; and so on",
    r"somebody|someone|nobody|whoever|anyone": "name who: the client, a subscriber, a robot",
    r"click here|this page explains": "let the link say where it leads",
    r"whitelist|blacklist|sanity check": "allowed, denied; check",
    r"cancel{2}(ed|ing)": "canceled, canceling, as action_msgs has it",
    r"currently|at the moment of writing": "say since which version, or leave it out",
}
"""The patterns, with alternatives."""
_PATTERNS: Final = [(re.compile(rf"(?<![\w-])({words})(?![\w-])", re.IGNORECASE), do) for words, do in _BANNED.items()]


def flaws_of(text: str) -> Iterator[tuple[int, str]]:
    """Yield the flaws in the prose of a Markdown page: the line, and a remedy."""
    for block in MarkdownIt("commonmark").enable("table").parse(text):
        words = " ".join(token.content for token in block.children or () if token.type == "text")
        for pattern, instead in _PATTERNS:
            for match in pattern.finditer(words):
                line = block.map[0] + 1 if block.map else 0
                yield line, f"{match[0]!r}: {instead}"


def main() -> int:
    """Report the flaws in the documentation; return 1 if there are any."""
    wrong = 0
    for page in sorted(path for pattern in _PAGES for path in _ROOT.glob(pattern)):
        for line, flaw in flaws_of(page.read_text(encoding="utf-8")):
            sys.stderr.write(f"{page.relative_to(_ROOT)}:{line}: {flaw}\n")
            wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

"""A page of the documentation as its code blocks, with the remarks of comments."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from markdown_it import MarkdownIt

from tests.docs.kinds import KINDS

if TYPE_CHECKING:
    from pathlib import Path

_COMMENT: Final = re.compile(
    r"<!--\s*(?P<name>[a-z][a-z ]*?)\s*(?::[ \t]*(?P<value>[^\n]*?)\s*(?P<body>\n.*?)?)?\s*-->", re.DOTALL
)
_TITLE: Final = re.compile(r'title="([^"]+)"')

ABOUT_A_BLOCK: Final = frozenset({"background", "background output", "exit", "needs", "output", *KINDS})
"""What a comment directly before a block may say of it."""
ON_THEIR_OWN: Final = frozenset({"file", "run", "stand in", "stop"})
"""What a comment does by itself: write a file, run a command, have a text stand for another, stop what goes on."""


@dataclass(frozen=True)
class Block:
    """A code block, or a comment that stands for one.

    Attributes:
        line: Its first line, from 1.
        language: The first word after the fence; of a comment, its name.
        title: The name of the file that it is.
        text: What is in it.
        remarks: The comments directly before it, by their names.
    """

    line: int
    language: str
    text: str
    title: str = ""
    remarks: dict[str, str] = field(default_factory=dict)


def blocks_of(path: Path) -> list[Block]:
    """Return the blocks of a page.

    Raises:
        ValueError: A comment before a block says what is not known.
    """
    found: list[Block] = []
    remarks: dict[str, str] = {}
    for token in MarkdownIt().parse(path.read_text(encoding="utf-8")):
        line = token.map[0] + 1 if token.map else 0
        if token.type == "html_block":
            for comment in _COMMENT.finditer(token.content):
                name, value = comment["name"], comment["value"] or ""
                if name == "file":
                    found.append(Block(line, name, (comment["body"] or "").removeprefix("\n") + "\n", title=value))
                elif name in ON_THEIR_OWN:
                    found.append(Block(line, name, value))
                else:
                    remarks[name] = value
        elif token.type in {"fence", "code_block"}:
            if strange := remarks.keys() - ABOUT_A_BLOCK:
                raise ValueError(f"{path}:{line}: nothing is known of the comment {min(strange)!r} before this block")
            language, _, rest = token.info.partition(" ")
            title = _TITLE.search(rest)
            found.append(Block(line, language, token.content, title[1] if title else "", remarks))
            remarks = {}
        elif token.type.endswith("_open") or token.type == "hr":
            remarks = {}
    return found

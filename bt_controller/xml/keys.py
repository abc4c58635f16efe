"""How files refer to the blackboard: ``{key}``, ``{=}`` for the port's own name, ``{@key}`` for the main tree's."""

from __future__ import annotations

import re
from typing import Final

from py_trees.ports import CONST_PREFIX, DOT_REPLACEMENT

from hmrsim.diagnostics import shown

_KEY: Final = re.compile(r"@?[\w-]+")
_TAKEN: Final = ("name", "ID", "@name", "@ID")
"""What py_trees takes for an element's own."""


def reference(port: str, text: str) -> str | None:
    """Return the key that a text refers to; None if it is a value.

    Args:
        port: Where it stands.
        text: As it is in the file.

    Raises:
        ValueError: It is neither, or py_trees would take it for something else; the text says what is expected.
    """
    inner = text.strip()
    if not (inner.startswith("{") and inner.endswith("}") and len(inner) > len("{}")):
        if "{" in text or "}" in text:
            raise ValueError(f"{shown(text)} is no value; braces are for keys of the blackboard: {{key}}")
        if CONST_PREFIX in text or DOT_REPLACEMENT in text:
            raise ValueError(
                f"{shown(text)} is no value; {CONST_PREFIX!r} and {DOT_REPLACEMENT!r} mean something to py_trees"
            )
        return None
    key = port if inner == "{=}" else inner[1:-1].strip()
    if not is_key(key):
        wanted = "another name, that one is taken, is" if key in _TAKEN else "letters, digits, '_' and '-' are"
        raise ValueError(f"{shown(text)} is no key of the blackboard; {wanted} expected")
    return key


def is_key(text: str) -> bool:
    """Return whether a text can be a key."""
    return (
        bool(_KEY.fullmatch(text)) and text not in _TAKEN and CONST_PREFIX not in text and DOT_REPLACEMENT not in text
    )


def is_private(key: str) -> bool:
    """Return whether a key is not handed on by ``_autoremap``."""
    return key.startswith("_")

"""References to the blackboard: ``{key}``, ``{=}`` for the port's own name, ``{@key}`` for the main tree's entry."""

from __future__ import annotations

import re
from typing import Final

from py_trees.ports import CONST_PREFIX, DOT_REPLACEMENT

from hmrsim.diagnostics import shown

_KEY: Final = re.compile(r"@?[\w-]+")
_TAKEN: Final = ("name", "ID", "@name", "@ID")
"""The attributes that py_trees reserves."""


def reference(port: str, text: str) -> str | None:
    """Return the key that a text refers to; None if it is a value.

    Raises:
        ValueError: The text is neither, or has a special meaning in py_trees.
    """
    inner = text.strip()
    if not (inner.startswith("{") and inner.endswith("}") and len(inner) > len("{}")):
        if "{" in text or "}" in text:
            raise ValueError(f"{shown(text)} is not a value; braces enclose keys of the blackboard: {{key}}")
        if CONST_PREFIX in text or DOT_REPLACEMENT in text:
            raise ValueError(
                f"{shown(text)} is not a value; {CONST_PREFIX!r} and {DOT_REPLACEMENT!r} are reserved by py_trees"
            )
        return None
    key = port if inner == "{=}" else inner[1:-1].strip()
    if not is_key(key):
        wanted = "the name is reserved" if key in _TAKEN else "expected letters, digits, '_' and '-'"
        raise ValueError(f"{shown(text)} is not a key of the blackboard; {wanted}")
    return key


def is_key(text: str) -> bool:
    """Return whether a text can be a key."""
    return (
        bool(_KEY.fullmatch(text)) and text not in _TAKEN and CONST_PREFIX not in text and DOT_REPLACEMENT not in text
    )

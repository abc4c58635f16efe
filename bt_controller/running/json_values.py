"""What is on a blackboard, as JSON has it."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from pydantic_core import PydanticSerializationError, to_jsonable_python

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_INTERNAL: Final = re.compile(r"__const|[0-9a-f]{8}([-_]?[0-9a-f]{4}){3}[-_]?[0-9a-f]{12}")
"""In the keys that py_trees makes up: for values that a file gives, and for ports that lead nowhere."""


def board_values(storage: Mapping[str, Any]) -> dict[str, Any]:
    """Return what users have on a blackboard, by key, in the keys' order; what JSON can't say is left out."""
    return dict(_said(storage))


def _said(storage: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key in sorted(storage):
        if not _INTERNAL.search(key):
            try:
                yield key.removeprefix("/"), to_jsonable_python(storage[key], inf_nan_mode="null")
            except (PydanticSerializationError, ValueError):
                # Of a kind that is unknown there, or within itself.
                continue

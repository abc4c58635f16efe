"""The entries of a blackboard as JSON values."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from pydantic_core import PydanticSerializationError, to_jsonable_python

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

_INTERNAL: Final = re.compile(r"__const|[0-9a-f]{8}([-_]?[0-9a-f]{4}){3}[-_]?[0-9a-f]{12}")
"""A part of the keys that py_trees generates for values in a file and for unconnected ports."""


def board_values(storage: Mapping[str, Any]) -> dict[str, Any]:
    """Return the user's entries of a blackboard, ordered by key; values without a JSON form are left out."""
    return dict(_said(storage))


def _said(storage: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for key in sorted(storage):
        if not _INTERNAL.search(key):
            try:
                yield key.removeprefix("/"), to_jsonable_python(storage[key], inf_nan_mode="null")
            except (PydanticSerializationError, ValueError):
                # Of a kind that is unknown there, or within itself.
                continue

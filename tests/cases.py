"""Named cases within one test, so that a failure names its case."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def case(name: object) -> Iterator[None]:
    """Name the case within; pytest shows the name under the error."""
    try:
        yield
    except Exception as error:
        error.add_note(f"case: {name}")
        raise

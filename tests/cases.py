"""Many small cases in one test: what fails says which case it was."""

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

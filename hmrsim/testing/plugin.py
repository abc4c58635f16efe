"""The fixture `simulation` for pytest, which closes the runs that a test has made."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from hmrsim.testing.run import Run


@pytest.fixture
def simulation() -> Iterator[Callable[..., Run]]:
    """Return a function like `hmrsim.testing.simulation`, whose runs are closed after the test."""
    # Imported only for tests that use it.
    from hmrsim.testing.run import simulation as make  # noqa: PLC0415

    with ExitStack() as stack:

        def made(*arguments: Any, **options: Any) -> Run:
            return stack.enter_context(make(*arguments, **options))

        yield made

"""The plugin of pytest: the fixture `simulation`, and tracebacks that end at the line of the test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Final

import pytest

from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from types import TracebackType

    from hmrsim.testing.run import Run

_PACKAGES: Final = ("hmrsim", "hmrsim_zenoh", "bt_controller", "hmrsim_gym")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """End the traceback of an error that hmrsim reports at the test's own line, unless ``--full-trace`` is given."""
    if call.excinfo is None or item.config.getoption("fulltrace") or not isinstance(call.excinfo.value, HmrsimError):
        return
    own = [
        entry
        for entry in _entries(call.excinfo.tb)
        if str(entry.tb_frame.f_globals.get("__name__", "")).partition(".")[0] not in _PACKAGES
    ]
    if own:
        own[-1].tb_next = None


def _entries(traceback: TracebackType | None) -> Iterator[TracebackType]:
    while traceback is not None:
        yield traceback
        traceback = traceback.tb_next


@pytest.fixture
def simulation() -> Iterator[Callable[..., Run]]:
    """Return a function like `hmrsim.testing.simulation`, whose runs are closed after the test."""
    # Imported only for tests that use it.
    from hmrsim.testing.run import simulation as make  # noqa: PLC0415

    with ExitStack() as stack:

        def made(*arguments: Any, **options: Any) -> Run:
            return stack.enter_context(make(*arguments, **options))

        yield made

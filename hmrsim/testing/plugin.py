"""The plugin of pytest: the fixture `simulation`, and tracebacks that end at the line of the test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import pytest

from hmrsim.errors import HmrsimError

if TYPE_CHECKING:
    from types import TracebackType

    from hmrsim.testing.run import Run

_PACKAGES: Final = ("hmrsim", "hmrsim_zenoh", "bt_controller", "hmrsim_gym")
_LOOP: Final = "asyncio"


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """Leave hmrsim's frames out of tracebacks between those of the user, unless ``--full-trace`` is given."""
    if call.excinfo is not None and not item.config.getoption("fulltrace"):
        _shorten(call.excinfo.value, call.excinfo.tb)


def _shorten(error: BaseException, traceback: TracebackType | None) -> None:
    """Shorten the traceback of an error, which ends at the user's own line if hmrsim reports the error."""
    if isinstance(error, BaseExceptionGroup):
        for each in error.exceptions:
            _shorten(each, each.__traceback__)
    entries = [*_entries(traceback)]
    packages = [str(entry.tb_frame.f_globals.get("__name__", "")).partition(".")[0] for entry in entries]
    own = [entry for entry, package in zip(entries, packages, strict=True) if package not in (*_PACKAGES, _LOOP)]
    if not own or not any(package in _PACKAGES for package in packages):
        return
    for entry, following in pairwise(own):
        entry.tb_next = following
    if isinstance(error, HmrsimError):
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

"""Where a run that was repeated first differs."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from typing import TYPE_CHECKING, Any, Final

from hmrsim.trace.difference import first_difference

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_MOST_REPEATS: Final = 4
_SEED: Final = "PYTHONHASHSEED"


def difference_from(kept: str, now: str, repeat: Callable[..., str], *args: Any) -> str:
    """Return where a run that came out otherwise first differs, in words.

    Args:
        kept: The trace of the run as it was; empty if it was not kept. Then the run is repeated in other processes,
            until one of them differs.
        now: The trace of the run as it is now.
        repeat: Returns the trace of the run, in another process.
        args: Its arguments.
    """
    if kept:
        found = first_difference(kept, now)
        return found.describe() if found else "the trace is the same"
    for other in _elsewhere(repeat, *args):
        if found := first_difference(other, now):
            return f"two runs of now differ, too: the controller is not deterministic; {found.describe()}"
    return (
        f"{_MOST_REPEATS} more runs are all as this one: the code of the controller, or something that it reads, "
        "has changed since"
    )


def _elsewhere(repeat: Callable[..., str], *args: Any) -> Iterator[str]:
    """Yield what a function returns in new processes, in each of which sets have another order."""
    before = os.environ.get(_SEED)
    try:
        for number in range(_MOST_REPEATS):
            os.environ[_SEED] = str(number + 1)
            with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as process:
                yield process.submit(repeat, *args).result()
    finally:
        os.environ.pop(_SEED, None)
        if before is not None:
            os.environ[_SEED] = before

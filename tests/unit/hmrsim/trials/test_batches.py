"""Many trials on an executor that may break."""

from __future__ import annotations

import os
import select
import subprocess
import sys
import time
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from subprocess import DEVNULL, PIPE

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import HmrsimError
from hmrsim.trials.batches import Batches, Serial, factory_of


class Pool(Serial):
    """An executor whose process dies of some tasks."""

    def __init__(self, killers):
        self._killers = killers
        self._broken = False

    def submit(self, function, piece):
        """Do a piece of work, if the process is alive."""
        if self._broken:
            raise BrokenProcessPool
        if self._killers.isdisjoint(piece):
            return super().submit(function, piece)
        self._broken = True
        future = Future()
        future.set_exception(BrokenProcessPool())
        return future


def tenfold(piece):
    """Return the results of a piece: ten times each task."""
    return [10 * thing for thing in piece]


def results(batches, pieces, **options):
    """Return pairs of a task and its result, in the order in which they arrive."""
    there = iter(pieces)

    def submit(executor, piece):
        return executor.submit(tenfold, piece)

    with closing(batches.results(lambda: next(there, ()), submit, lambda thing, _seconds: -thing, **options)) as found:
        return [pair for piece, each in found for pair in zip(piece, each, strict=True)]


@given(
    sizes=st.lists(st.integers(1, 4), max_size=12),
    killers=st.sets(st.integers(1, 40), max_size=4),
    workers=st.integers(1, 3),
    in_order=st.booleans(),
)
def test_each_task_has_one_result(sizes, killers, workers, in_order):
    numbers = iter(range(1, 100))
    pieces = [[next(numbers) for _ in range(size)] for size in sizes]
    found = results(Batches(lambda: Pool(killers), workers), pieces, in_order=in_order)

    expected = [(thing, -thing if thing in killers else 10 * thing) for piece in pieces for thing in piece]
    assert expected == sorted(found)


def test_pieces_keep_their_order_on_request():
    found = results(Batches(lambda: Pool({3}), 2), [[1], [2], [3], [4], [5]], in_order=True)

    assert [1, 2, 3, 4, 5] == [thing for thing, _ in found]


def test_executor_that_always_breaks_loses_each_task():
    class Broken(Serial):
        def submit(self, *_arguments):
            raise BrokenProcessPool

    assert [(1, -1), (2, -2), (3, -3)] == results(Batches(Broken, 1), [[1, 2], [3]])


def test_raises_errors_of_the_users_file():
    def submit(_executor, _piece):
        future = Future()
        future.set_exception(HmrsimError("the file has changed"))
        return future

    pieces = iter([[1]])
    with pytest.raises(HmrsimError, match="has changed"):
        list(Batches(Serial, 1).results(lambda: next(pieces, ()), submit, lambda thing, _seconds: thing))


def test_work_beyond_the_time_limit_is_dropped():
    """The next work gets a new executor."""
    made = []

    def make():
        made.append(Serial())
        return made[-1]

    batches = Batches(make, 1)
    pieces = iter([[1], [2]])
    late = batches.results(lambda: next(pieces, ()), lambda *_: Future(), lambda *_: 0, until=time.monotonic() - 10.0)

    assert [] == list(late)
    assert [(3, 30)] == results(batches, [[3]])
    assert 2 == len(made)


_PARENT = """
import os, sys
from hmrsim.trials.batches import factory_of
if __name__ == "__main__":
    make, _ = factory_of("pool", 1)
    pool = make()  # a pool that is not kept ends its processes
    print(pool.submit(os.getpid).result(), flush=True)
    sys.stdin.read()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="needs pidfd_open")
def test_a_process_of_a_pool_ends_with_its_parent(tmp_path):
    """A parent that is killed can't end it."""
    (tmp_path / "parent.py").write_text(_PARENT)
    command = [sys.executable, tmp_path / "parent.py"]
    # Python's own tracker of resources reports the semaphores of the pool.
    with subprocess.Popen(command, stdin=PIPE, stdout=PIPE, stderr=DEVNULL, text=True) as parent:
        worker = os.pidfd_open(int(parent.stdout.readline()))
        parent.kill()
        ended, _, _ = select.select([worker], [], [])
        os.close(worker)

    assert [worker] == ended


def test_a_pool_has_the_environment_of_its_parent(monkeypatch):
    """Also one that was changed after an earlier pool had started."""
    seen = []
    for value in ("1", "2"):
        monkeypatch.setenv("HMRSIM_TEST", value)
        make, _ = factory_of("pool", 1)
        with make() as pool:
            seen.append(pool.submit(os.getenv, "HMRSIM_TEST").result())

    assert ["1", "2"] == seen

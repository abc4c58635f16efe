"""What counts for the limits of a run."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from hmrsim.experiments.file.model import Limits
from hmrsim.trials.meter import Meter, Usage

LIMITS = Limits(wall=20.0, processor=30.0)


@pytest.fixture
def meter():
    """Return a meter, and what lets time pass: wall seconds, and how many of them a run has and wants a processor."""
    now, usage = [1000.0], [Usage(5.0, 1.0)]
    made = Meter(LIMITS, 200.0, lambda: now[0], lambda: usage[0])

    def passes(seconds: float, *, used: float = 0.0, delayed: float = 0.0) -> bool:
        now[0] += seconds
        usage[0] = Usage(usage[0].used + used, usage[0].delayed + delayed)
        return made.look()

    return made, passes


def test_a_run_that_waits_is_over_by_the_walls_clock(meter):
    """A run that waits is over by the walls clock."""
    made, passes = meter
    assert 20.0 == made.left
    assert not passes(19.0)
    assert 1.0 == made.left
    assert passes(1.0)
    assert "it has waited for 20 wall seconds without computing anything" == made.why


def test_a_run_that_computes_is_over_by_processor_time(meter):
    """A run that computes is over by processor time."""
    made, passes = meter
    assert not passes(29.0, used=29.0)
    assert passes(1.0, used=1.0)
    assert "it takes longer than 30 s of processor time" == made.why


def test_a_run_that_does_not_get_a_processor_is_not_over(meter):
    """A machine under load makes a run slow, but not wrong."""
    made, passes = meter
    assert not any(passes(10.0, used=0.5, delayed=9.5) for _ in range(19))
    assert not made.why


def test_what_a_run_waits_is_added_up(meter):
    """What a run waits is added up."""
    made, passes = meter
    assert [passes(2.0, used=1.0) for _ in range(20)] == [False] * 19 + [True]
    assert "waited for 20 wall seconds" in made.why


def test_delays_of_what_has_ended_are_not_forgotten(meter):
    """A thread takes them with it."""
    made, passes = meter
    assert not passes(50.0, delayed=50.0)
    assert not passes(1.0, used=1.0, delayed=-50.0)
    assert (20.0, True) == (made.left, passes(20.0))


def test_a_process_that_is_stopped_while_it_looks_has_not_waited():
    """Under load that is likely: the clock is read before, and what was used after."""
    now, usage = [0.0], [Usage(0.0, 0.0)]

    def stopped() -> Usage:
        now[0] += 100.0
        usage[0] = Usage(usage[0].used, usage[0].delayed + 100.0)
        return usage[0]

    made = Meter(LIMITS, clock=lambda: now[0], usage=stopped)

    assert not any(made.look() for _ in range(3))


def test_a_run_whose_result_nobody_wants_any_more_is_over_whatever_it_does(meter):
    """A run whose result nobody wants any more is over whatever it does."""
    made, passes = meter
    assert not passes(199.0, delayed=199.0)
    assert passes(1.0, delayed=1.0)
    assert "it takes longer than the 200 wall seconds that were left for it" == made.why


def test_processor_time_is_that_of_threads_and_of_processes_that_were_started():
    """Also while these run, and when they have ended."""
    code = "import sys\nwhile __import__('time').process_time() < 0.2: pass\nprint(flush=True)\nsys.stdin.read()"
    before = Usage.now().used
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        running = Usage.now().used - before
        process.communicate("")
    ended = Usage.now().used - before

    assert running >= 0.2 - 2 / os.sysconf("SC_CLK_TCK")
    assert ended >= 0.2

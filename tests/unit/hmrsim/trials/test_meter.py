"""The meter of a run: the time that counts for its limits."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from hmrsim.experiments.model import Limits
from hmrsim.trials.meter import Meter, Usage

LIMITS = Limits(wall=20.0, processor=30.0)


@pytest.fixture
def meter():
    """Return a meter, and a function that lets time pass, of which the run computes or is delayed for some."""
    now, usage = [1000.0], [Usage(5.0, 1.0)]
    made = Meter(LIMITS, 200.0, lambda: now[0], lambda: usage[0])

    def passes(seconds: float, *, used: float = 0.0, delayed: float = 0.0) -> bool:
        now[0] += seconds
        usage[0] = Usage(usage[0].used + used, usage[0].delayed + delayed)
        return made.look()

    return made, passes


def test_waiting_run_exceeds_the_wall_limit(meter):
    made, passes = meter
    assert 20.0 == made.left
    assert not passes(19.0)
    assert 1.0 == made.left
    assert passes(1.0)
    assert "it has waited for 20 wall seconds without computing anything" == made.why


def test_computing_run_exceeds_the_processor_limit(meter):
    made, passes = meter
    assert not passes(29.0, used=29.0)
    assert passes(1.0, used=1.0)
    assert "it takes longer than 30 s of processor time" == made.why


def test_run_without_a_processor_exceeds_no_limit(meter):
    made, passes = meter
    assert not any(passes(10.0, used=0.5, delayed=9.5) for _ in range(19))
    assert not made.why


def test_waits_are_added_up(meter):
    made, passes = meter
    assert [passes(2.0, used=1.0) for _ in range(20)] == [False] * 19 + [True]
    assert "waited for 20 wall seconds" in made.why


def test_delays_of_ended_threads_count(meter):
    made, passes = meter
    assert not passes(50.0, delayed=50.0)
    assert not passes(1.0, used=1.0, delayed=-50.0)
    assert (20.0, True) == (made.left, passes(20.0))


def test_stop_during_a_look_is_no_wait():
    now, usage = [0.0], [Usage(0.0, 0.0)]

    def stopped() -> Usage:
        now[0] += 100.0
        usage[0] = Usage(usage[0].used, usage[0].delayed + 100.0)
        return usage[0]

    made = Meter(LIMITS, clock=lambda: now[0], usage=stopped)

    assert not any(made.look() for _ in range(3))


def test_run_ends_after_the_given_seconds_in_any_case(meter):
    made, passes = meter
    assert not passes(199.0, delayed=199.0)
    assert passes(1.0, delayed=1.0)
    assert "it takes longer than the 200 wall seconds that were left for it" == made.why


def test_processor_time_includes_threads_and_children():
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

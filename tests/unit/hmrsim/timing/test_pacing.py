"""Pacing by a fake wall clock, and what stops simulated time."""

from __future__ import annotations

import itertools
import threading
from types import SimpleNamespace

import pytest

from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.interfaces.simulation_interfaces import ResetSimulation
from hmrsim.protocol.commands import Advance, CallService, GetResult, Inbox, SendGoal
from hmrsim.protocol.outputs import EventStamped
from hmrsim.protocol.time import Join, ReadTime, TokenSeen
from hmrsim.protocol.topics import Topic
from hmrsim.settings.run import RunSettings
from hmrsim.timing import pacing, result_retention
from hmrsim.timing.pacing import Pacing, watch_over
from hmrsim.timing.result_retention import Retention
from tests.patience import PATIENCE
from tests.simulation import simulate

A, B = "a" * 32, "b" * 32
WAIT = SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=4)), A, "x")


class FakeWall:
    """A wall clock that moves only during waits; an inbox that waits on it."""

    def __init__(self, monkeypatch):
        self.now = 100.0
        self.waits = []
        for module in (pacing, result_retention):
            monkeypatch.setattr(module, "wall_time", lambda: self.now)

    def inbox(self, arrivals=(), *, close_at=None):
        """Return an inbox into which commands come at given wall seconds after now."""
        wall, begun = self, self.now
        due = [(begun + at, command) for at, command in arrivals]

        class TimedInbox(Inbox):
            def wait(self, timeout):
                ends = [t for t, _ in due[:1]] + ([begun + close_at] if close_at is not None else [])
                until = min([*ends, wall.now + timeout] if timeout is not None else ends)
                wall.waits.append(round(until - wall.now, 6))
                wall.now = max(wall.now, until)
                while due and due[0][0] <= wall.now:
                    self.put(due.pop(0)[1])
                if close_at is not None and wall.now >= begun + close_at:
                    self.close()

        return TimedInbox()


@pytest.fixture
def wall(monkeypatch):
    """Return a fake wall clock."""
    return FakeWall(monkeypatch)


def paced(wall, arrivals, *, factor=1.0, topics=frozenset(), **kwargs):
    """Run a simulation at a pace; return it with its log."""
    run = simulate(topics=topics)
    inbox = wall.inbox(arrivals, **kwargs)
    pace = Pacing(run.simulator, inbox, Retention(-1), RunSettings(real_time_factor=factor, duration=50.0))
    pace.run()
    return run, pace


def test_a_command_is_stamped_with_the_time_of_its_arrival(wall):
    """The command arrives after 2.5 wall seconds at factor 1, when no event is due."""
    run, _ = paced(wall, [(2.5, WAIT)])

    assert [2.5, 2.5, 6.5] == pytest.approx([time for time, _ in run.log.changes(A)])


def test_at_factor_ten_time_is_ten_times_as_fast(wall):
    """At factor 10 the same command arrives at 25 s."""
    run, _ = paced(wall, [(2.5, WAIT)], factor=10.0)

    assert 25.0 == pytest.approx(run.log.changes(A)[0][0])


def test_it_sleeps_from_event_to_event(wall):
    """It waits for the command, the end of the wait and the end of the run, with checks of the clock in between."""
    paced(wall, [(2.6, WAIT)])
    ends = list(itertools.accumulate(wall.waits))

    assert {2.6, 6.6, 50.0} <= {round(end, 6) for end in ends}
    assert 0.25 == max(wall.waits)
    assert 4 * 50 + 4 >= len(ends)


def test_the_run_ends_with_its_duration(wall):
    run, _ = paced(wall, [])

    assert 50.0 == run.simulator.now


def test_closing_the_inbox_ends_the_run(wall):
    run, _ = paced(wall, [], close_at=3.0)

    assert 3.0 >= run.simulator.now


def test_time_lags_when_the_machine_stalls_and_never_leaps(wall):
    """After a stall of 30 wall seconds a wait of 4 s still ends at 4 s, and the lag is reported."""
    run = simulate(topics=frozenset())
    told = []
    inbox = wall.inbox([], close_at=60.0)
    stall_once(wall, inbox)
    inbox.put(WAIT)
    pace = Pacing(run.simulator, inbox, Retention(-1), on_lag=told.append)
    pace.run()

    assert 29.9 == pytest.approx(pace.lag)
    assert [pace.lag] == told
    assert 31.0 > run.simulator.now


def test_as_fast_as_possible_needs_no_wall_time(wall):
    run, _ = paced(wall, [(1.0, WAIT)], factor=0.0, close_at=1.5)

    assert (4.0, "SUCCEEDED") == run.log.changes(A)[-1]
    assert 101.5 == pytest.approx(wall.now)


def test_as_fast_as_possible_the_clock_is_told_when_time_stands(wall):
    """The last sample of the clock is the time at which everything ended."""
    run, _ = paced(wall, [(1.0, WAIT)], factor=0.0, close_at=1.5, topics=frozenset({Topic.CLOCK}))
    last = [event for _, event in run.log.events if getattr(event, "topic", None) is Topic.CLOCK][-1]

    assert 4_000_000_000 == last.message.clock.to_nanoseconds()


@pytest.mark.parametrize(
    ("timeout", "statuses"), [(10.0, [4, 4, 0]), (0.0, [4, 0, 0]), (-1.0, [4, 4, 4])], ids=["10 s", "none", "for ever"]
)
def test_results_are_dropped_after_their_wall_time(wall, timeout, statuses):
    """The goal ends after 4.5 wall seconds; results are requested before that, and 9 and 11 s later."""
    retention = Retention(timeout)
    run = simulate(topics=frozenset(), sinks=[retention])
    ask = [(t, GetResult("wall_e", "wait", A, t)) for t in (1.0, 4.5 + 9.0, 4.5 + 11.0)]
    inbox = wall.inbox([(0.0, WAIT), *ask], close_at=20.0)
    Pacing(run.simulator, inbox, retention).run()

    assert statuses == [run.log.answer(t).status for t, _ in ask]


def test_as_many_expiries_are_kept_as_results(wall):
    """For a robot with many ended goals, only the latest ones need to be dropped."""
    goals = [SendGoal("wall_e", "wait", Wait.Goal(), f"{number:032x}") for number in range(1, 21)]
    retention, dropped = Retention(10.0, 3), []
    run = simulate(topics=frozenset(), sinks=[retention], keep_results=3)
    for goal in goals:
        run.simulator.submit(goal)
        run.simulator.advance(run.simulator.now + 1.0)
    wall.now += 11.0
    retention.apply(SimpleNamespace(submit=dropped.append))

    assert [goal.goal_id for goal in goals[-3:]] == [command.goal_id for command in dropped]


def test_a_process_that_was_stopped_goes_on_where_it_was(wall):
    """A command after a stop of 30 s, in which nothing was due, is stamped as if there had been no stop."""
    run = simulate(topics=frozenset())
    inbox = wall.inbox([(31.0, WAIT)], close_at=40.0)
    stall_once(wall, inbox)
    pace = Pacing(run.simulator, inbox, Retention(-1))
    pace.run()

    assert 29.9 == pytest.approx(pace.lag)
    assert 1.1 == pytest.approx(run.log.changes(A)[0][0])


def stall_once(wall, inbox, seconds=30.0):
    """Stop the process at the end of its first wait."""
    original, stalls = inbox.wait, [seconds]

    def stall(timeout):
        original(timeout)
        if stalls:
            wall.now += stalls.pop()

    inbox.wait = stall


class TestPause:
    """Commands while the simulation is paused."""

    def test_nothing_moves_while_it_is_paused(self, wall):
        run = simulate(topics=frozenset())
        run.simulator.gate.limit = 0.0
        Pacing(run.simulator, wall.inbox([(1.0, WAIT)], close_at=20.0), Retention(-1)).run()

        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING")] == run.log.changes(A)


def in_lockstep(inbox, *, on_wait=(), **settings):
    """Return a simulation in lockstep, and what lets its time move."""
    made = []

    asked = RunSettings(clock="lockstep", **settings)

    def pace(simulator):
        made.append(Pacing(simulator, inbox, Retention(-1), asked, on_wait=on_wait))
        return [made[0].lockstep]

    run = simulate(topics=frozenset({Topic.EVENTS}), watchers=pace)
    return run, made[0]


class TestLockstep:
    """Participants by the wall clock."""

    def test_an_exception_answers_waiting_participants(self):
        inbox = Inbox()
        for command in (Join("nurse", "x"), Advance("nurse", 0, reply_to="held")):
            inbox.put(command)

        def die():
            raise OSError("the disk is full")

        run, pacing = in_lockstep(inbox, participants=2, on_wait=[die])
        with pytest.raises(OSError, match="the disk is full"):
            pacing.run()
        pacing.end("the disk is full")

        assert ("end", "the disk is full") == run.log.answer("held")[2::4]

    def test_one_that_stalls_is_dropped(self):
        """The run ends on request, although the watchdog has a separate thread."""
        inbox = Inbox()
        inbox.put(Join("nurse", "x"))
        run, pacing = in_lockstep(inbox, participant_timeout=0.05, on_participant_loss="end")
        pacing.run()
        kinds = [event.kind for _, event in run.log.events if isinstance(event, EventStamped)]

        assert ["participant_dropped", "participant_joined"] == sorted(kinds)

    def test_one_that_thinks_at_a_loss_is_told_of_the_end(self):
        inbox = Inbox()
        for name in ("nurse", "porter"):
            inbox.put(Join(name, name))
        inbox.put(TokenSeen("nurse", alive=True))
        inbox.put(TokenSeen("nurse", alive=False))
        asked = Advance("porter", 0, reply_to="asked")
        run, pacing = in_lockstep(inbox, participants=2, on_participant_loss="end", on_wait=[lambda: inbox.put(asked)])
        pacing.run()
        pacing.end("the end")

        lost = "participant 'nurse' was dropped at 0.000 s: its liveliness token is gone"
        assert ("end", lost) == run.log.answer("asked")[2::4]


class TestInbox:
    """The inbox for commands of other threads."""

    def test_commands_come_out_in_order(self):
        inbox = Inbox()
        inbox.put("first")
        inbox.put("second")

        assert ["first", "second", None] == [inbox.poll(), inbox.poll(), inbox.poll()]

    def test_a_command_ends_the_wait(self):
        inbox = Inbox()
        waiter = threading.Thread(target=inbox.wait, args=(None,))
        waiter.start()
        inbox.put("command")
        waiter.join(PATIENCE)

        assert not waiter.is_alive()

    def test_closing_ends_the_wait(self):
        inbox = Inbox()
        waiter = threading.Thread(target=inbox.wait, args=(None,))
        waiter.start()
        inbox.close()
        waiter.join(PATIENCE)

        assert not waiter.is_alive()
        with pytest.raises(SimulationStopped, match="the simulation has ended"):
            inbox.put("late")


def test_no_participant_is_dropped_for_the_time_that_the_simulator_was_stopped(monkeypatch):
    """After a SIGSTOP, participants get their full timeout again."""
    wall, looks, over = FakeWall(monkeypatch), [], threading.Event()
    passed = iter([1.0] * 3 + [60.0] + [1.0] * 9)

    def pass_time(_seconds):
        seconds = next(passed, None)
        wall.now += seconds or 0.0
        return seconds is None

    monkeypatch.setattr(over, "wait", pass_time)
    watch_over(lambda: looks.append(wall.now), 1.0, over)

    assert [*range(101, 104), *range(168, 173)] == looks


def test_a_request_that_comes_with_a_reset_finds_lockstep_begun_anew():
    class Immediate(Inbox):
        def wait(self, timeout):
            """Return at once."""

    run, inbox = simulate(), Immediate()
    pace = Pacing(run.simulator, inbox, None, RunSettings(clock="lockstep"))
    for command in (Join("nurse", "joined"), Advance("nurse", 0, 3.0, reply_to="granted")):
        inbox.put(command)
    pace.run_until_idle()
    assert 1 == pace.lockstep.epoch

    inbox.put(CallService("reset_simulation", ResetSimulation.Request(), "reset"))
    inbox.put(ReadTime("time"))
    pace.run_until_idle()

    (state,) = run.log.answers("time")
    assert (0, 0.0) == (state.epoch, state.now)

"""Generated goal ids, which differ between runs with different identities."""

from __future__ import annotations

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import SendGoal
from hmrsim.trace.replay import replay
from tests.simulation import simulate


def made_id(**settings):
    """Return the id of a goal that was sent without one, and the lines of the trace."""
    run = simulate(traced=True, **settings)
    run((0.0, SendGoal("wall_e", "wait", Wait.Goal(time=Duration(sec=1)), None, "reply")))
    return run.log.answer("reply").goal_id, run.lines()


def test_another_run_generates_other_ids():
    """A client of an earlier run must not cancel a goal of this one."""
    assert 3 == len({made_id(run_id=run_id)[0] for run_id in ("", "one", "two")})


def test_in_lockstep_each_run_generates_the_same_ids():
    """Traces of runs in lockstep are then equal."""
    ids = [made_id(run_id=run_id, clock="lockstep") for run_id in ("one", "two")]

    assert ids[0] == ids[1]
    assert made_id()[0] == ids[0][0]


def test_a_replay_generates_the_ids_of_its_run():
    goal_id, lines = made_id(run_id="one")

    assert any(goal_id in line for line in lines)
    assert replay(lines).difference is None

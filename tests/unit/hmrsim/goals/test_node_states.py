"""Lifecycle states of nodes: inactive nodes reject goals."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.goals.node_states import ACTIVE, TRANSITIONS
from hmrsim.interfaces.lifecycle_msgs import Transition
from hmrsim.protocol.commands import ChangeState
from hmrsim.trace.replay import replay
from tests.profiles import examples
from tests.simulation import A, B, simulate, wait


def change(transition, reply_to="changed"):
    return ChangeState("wall_e", "behavior_server", ("wait", "spin"), transition, reply_to)


DEACTIVATE, ACTIVATE = (change(each) for each in (Transition.TRANSITION_DEACTIVATE, Transition.TRANSITION_ACTIVATE))


def test_an_inactive_node_rejects_goals(run):
    log = run((0.0, DEACTIVATE), (1.0, wait(5, A)), (1.0, wait(5, B, "eve")))

    assert log.answer("changed")
    assert (False, "not_ready") == (log.answer(A).accepted, log.answer(A).reason)
    assert "behavior_server of wall_e is inactive; activate it" == log.answer(A).error_msg
    assert log.answer(B).accepted


def test_deactivation_aborts_executing_goals(run):
    log = run((0.0, wait(5, A)), (1.0, DEACTIVATE))

    assert (1.0, "ABORTED") == log.changes(A)[-1]
    assert "behavior_server was deactivated" == log.result(A).error_msg


def test_an_activated_node_serves_again(run):
    log = run((0.0, DEACTIVATE), (1.0, ACTIVATE), (2.0, wait(5, A)))

    assert (7.0, "SUCCEEDED") == log.changes(A)[-1]


def test_a_transition_from_another_state_does_nothing(run):
    log = run((0.0, ACTIVATE), (0.0, change(99, "unknown")), (1.0, wait(5, A)))

    assert [False, False] == [log.answer("changed"), log.answer("unknown")]
    assert log.answer(A).accepted


def test_a_disconnected_robot_keeps_its_states(run):
    run.ask("inject_fault", {"type": "messages_lost", "robot": "wall_e", "at": 1.0, "until": 6.0})
    log = run((2.0, DEACTIVATE), (7.0, wait(5, A)))

    assert log.answer("changed") is False
    assert log.answer(A).accepted


def test_an_unknown_robot_has_no_states(run):
    """A late request must not affect a robot of that name that is spawned later."""
    log = run((0.0, DEACTIVATE._replace(robot="nobody")))

    assert log.answer("changed") is False
    assert ACTIVE == run.simulator.dispatcher.nodes.of("nobody", "behavior_server")


@examples(30)
@given(st.lists(st.sampled_from([*TRANSITIONS, 0, 99]), max_size=12))
def test_runs_with_transitions_replay(transitions):
    """Goals are accepted in the active state only."""
    run = simulate(traced=True)
    ids = [f"{number:032x}" for number in range(1, len(transitions) + 1)]
    states, accepted = [], []
    for number, (transition, goal_id) in enumerate(zip(transitions, ids, strict=True)):
        log = run((float(number), change(transition, number)), (number + 0.5, wait(5, goal_id)), until=number + 0.75)
        states.append(run.simulator.dispatcher.nodes.of("wall_e", "behavior_server"))
        accepted.append(log.answer(goal_id).accepted)
    run.simulator.stop()

    assert accepted == [state == ACTIVE for state in states]
    assert replay(run.lines()).difference is None

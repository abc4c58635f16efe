"""Pausing, playing, stopping and stepping."""

from __future__ import annotations

import json
import math

import pytest

from hmrsim.actions import registry as actions
from hmrsim.interfaces.simulation_interfaces import Result, SetSimulationState, SimulationState, StepSimulation
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, SendGoal, Stop
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import Answered, GoalChanged
from hmrsim.services import registry
from hmrsim.settings.run import RunSettings
from tests import simulation
from tests.simulation import SMALL_WORLD, send, simulate

STOPPED, PLAYING, PAUSED = (SimulationState.STATE_STOPPED, SimulationState.STATE_PLAYING, SimulationState.STATE_PAUSED)
OK = Result(result=Result.RESULT_OK)
GOAL, STEPS, NEXT = (letter * 32 for letter in "abc")


def go(x=9.0, y=2.0, goal_id=GOAL):
    return simulation.go(x, y, goal_id)


def steps(number, goal_id=STEPS):
    return send("simulate_steps", goal_id, "_world", steps=number)


def step(run, number=3, reply_to="steps"):
    return run.simulator.submit(CallService("step_simulation", StepSimulation.Request(steps=number), reply_to))


def become(run, state):
    return run.ask("set_simulation_state", {"state": {"state": state}}).result


def state_of(run):
    return run.ask("get_simulation_state").state.state


@pytest.fixture
def paused(run):
    become(run, PAUSED)
    return run


class TestStates:
    def test_a_simulation_plays_by_default(self, run):
        assert PLAYING == state_of(run)

    @pytest.mark.parametrize("state", [STOPPED, PLAYING, PAUSED])
    def test_every_state_leads_to_every_other(self, run, state):
        for other in (STOPPED, PLAYING, PAUSED):
            become(run, other)
            expected = 101 if other == state else Result.RESULT_OK

            assert expected == become(run, state).result
            assert state == state_of(run)

    @pytest.mark.parametrize("state", [3, 4, 5, 99])
    def test_other_states_are_not_supported(self, run, state):
        """A client can't quit the program, which belongs to the user who started it."""
        result = become(run, state)

        assert Result.RESULT_FEATURE_UNSUPPORTED == result.result
        assert f"state {state} can't be set" in result.error_message

    def test_time_does_not_move_while_paused(self, run):
        run((0.0, go()), until=1.5)
        become(run, PAUSED)
        run.simulator.run()
        run.simulator.advance(10.0)

        assert (1.5, (2.5, 2.0)) == (run.simulator.now, run.simulator.robots["wall_e"].pose().point)

    def test_a_pause_changes_no_later_event(self, run):
        run((0.0, go()), until=1.5)
        become(run, PAUSED)
        run.simulator.advance(10.0)
        become(run, PLAYING)
        log = run()

        assert (8.0, "SUCCEEDED") == log.changes(GOAL)[-1]

    @pytest.mark.parametrize(
        ("x", "commands", "status"),
        [
            (9.0, [], "EXECUTING"),
            (99.0, [], "ABORTED"),
            (9.0, [(0.0, CancelGoal("wall_e", "navigate_to_pose", GOAL))], "CANCELED"),
        ],
        ids=["accepted", "impossible", "canceled"],
    )
    def test_goals_are_accepted_and_canceled_while_paused(self, paused, x, commands, status):
        log = paused((0.0, go(x)), *commands)

        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING")] == log.changes(GOAL)[:2]
        assert (0.0, status) == log.changes(GOAL)[-1]
        assert (1.0, 2.0) == paused.simulator.robots["wall_e"].pose().point

    @pytest.mark.parametrize("name", [name for name, service in registry().items() if not service.changes_world])
    def test_queries_are_answered_while_paused(self, paused, name):
        paused((0.0, go()))

        assert paused.ask(name, registry()[name].example) is not None
        assert 0.0 == paused.simulator.now

    def test_stopping_resets_and_pauses(self, run):
        log = run((0.0, go()), until=1.5)
        become(run, STOPPED)

        assert (1.5, "ABORTED") == log.changes(GOAL)[-1]
        assert (0.0, True) == (run.simulator.now, run.simulator.paused)

    def test_states_are_published(self, paused):
        become(paused, PLAYING)

        assert [(0.0, {"state": PAUSED}), (0.0, {"state": PLAYING})] == paused.log.happened("simulation_state")


class TestSteps:
    def test_steps_are_answered_at_their_end(self, paused):
        paused((0.0, go()))
        reply = step(paused)
        before = paused.log.answers("steps")
        paused.simulator.run()

        assert ([], None) == (before, reply)
        assert OK == paused.log.answer("steps").result
        assert (0.3, True) == (paused.simulator.now, paused.simulator.paused)
        assert (pytest.approx(1.3), 2.0) == paused.simulator.robots["wall_e"].pose().point

    @pytest.mark.parametrize(("settings", "request_", "end"), [({}, {}, 0.1), ({"step_size": 0.25}, {"steps": 2}, 0.5)])
    def test_the_default_is_one_step_of_the_step_size(self, make_run, settings, request_, end):
        run = make_run(**settings)
        become(run, PAUSED)
        run.ask("step_simulation", request_)
        run.simulator.run()

        assert end == run.simulator.now

    @pytest.mark.parametrize(
        ("number", "why"),
        [
            (2**63, "steps: 9.22337e+18 is not from 0 to 1e+09"),
            (10**9, "steps: 1000000000 of 10 s: 1e+10 s is not from 0 to 1e+09 s"),
        ],
    )
    def test_more_steps_than_time_can_count_are_rejected(self, number, why):
        run = simulate(step_size=10.0)
        run.ask("set_simulation_state", {"state": {"state": PAUSED}})
        answer = run.ask("step_simulation", {"steps": number})

        assert why in str(answer)
        assert 0.0 == run.simulator.now

    def test_a_request_for_no_steps_is_answered_at_once(self, paused):
        assert OK == paused.ask("step_simulation", {"steps": 0}).result

    @pytest.mark.parametrize("state", [PLAYING, STOPPED])
    def test_a_simulation_that_is_not_paused_rejects_steps(self, run, state):
        become(run, state)

        result = run.ask("step_simulation").result
        assert Result.RESULT_OPERATION_FAILED == result.result
        assert "the simulation is not paused; pause it first" == result.error_message

    def test_only_one_request_makes_steps(self, paused):
        step(paused)
        second = paused.ask("step_simulation").result
        paused.simulator.run()

        assert Result.RESULT_OPERATION_FAILED == second.result
        assert "steps are being made already" in second.error_message
        assert (0.3, OK) == (paused.simulator.now, paused.log.answer("steps").result)

    def test_a_step_size_below_a_nanosecond_is_rejected(self):
        with pytest.raises(ValueError, match="5e-10 s is less than a nanosecond"):
            RunSettings(step_size=5e-10)

    @pytest.mark.parametrize(("state", "word"), [(PLAYING, "set to play"), (PAUSED, "paused"), (STOPPED, "reset")])
    def test_another_state_ends_the_steps(self, paused, state, word):
        step(paused)
        paused.simulator.process_events(0.1, 1)
        become(paused, state)
        paused.simulator.process_events(0.1, 100)

        result = paused.log.answer("steps").result
        assert Result.RESULT_OPERATION_FAILED == result.result
        assert f"the simulation was {word}" == result.error_message
        assert state == state_of(paused)

    def test_stopped_steps_do_not_affect_later_ones(self, paused):
        step(paused)
        paused.simulator.process_events(0.1, 1)
        become(paused, PAUSED)
        step(paused, 9, "more")
        paused.simulator.run()

        assert [1.0] == [time for time, event in paused.log.events if getattr(event, "reply_to", "") == "more"]
        assert OK == paused.log.answer("more").result

    def test_the_events_of_a_step_precede_its_answer(self, paused):
        wait = actions()["wait"]
        paused.simulator.submit(SendGoal("eve", "wait", wait.goal.model_validate({"time": {"sec": 1}}), GOAL))
        step(paused, 10)
        paused.simulator.run()
        reported = [event for _, event in paused.log.events if isinstance(event, (GoalChanged, Answered))]

        assert (1.0, "SUCCEEDED") == paused.log.changes(GOAL)[-1]
        assert isinstance(reported[-1], Answered)

    def test_the_end_of_the_simulation_answers_waiting_clients(self, paused):
        step(paused)
        paused.simulator.submit(Stop("enough"))

        assert "enough" == paused.log.answer("steps").result.error_message

    def test_events_at_the_end_of_a_step_belong_to_it(self, make_run):
        run = make_run(feedback_rate=10.0)
        become(run, PAUSED)
        run((0.0, go()))
        run.ask("step_simulation")
        run.simulator.run()

        assert [0.1] == [time for time, _ in run.log.feedback(GOAL)]


class TestSimulateSteps:
    def test_feedback_follows_each_step(self, paused):
        log = paused((0.0, steps(3)))

        assert [(0.1, 1, 2), (0.2, 2, 1), (0.3, 3, 0)] == [
            (time, each.completed_steps, each.remaining_steps) for time, each in log.feedback(STEPS)
        ]
        assert (0.3, "SUCCEEDED") == log.changes(STEPS)[-1]
        assert (OK, True) == (log.result(STEPS).result, paused.simulator.paused)

    def test_only_a_paused_simulation_accepts_it(self, run):
        answer = run((0.0, steps(3))).answer(STEPS)

        assert (False, "not_ready") == (answer.accepted, answer.reason)
        assert "the simulation is not paused; pause it first" == answer.error_msg

    def test_only_one_goal_or_request_makes_steps(self, paused):
        paused.simulator.submit(steps(3))
        paused.simulator.submit(steps(3, NEXT))
        service = paused.ask("step_simulation").result

        assert "not_ready" == paused.log.answer(NEXT).reason
        assert Result.RESULT_OPERATION_FAILED == service.result

    def test_no_robot_serves_it(self, run):
        run((0.0, steps(3)._replace(robot="wall_e", reply_to="robot")), (0.0, go()._replace(robot="_world")))

        assert "unknown_action" == run.log.answer("robot").reason
        assert "_world has no action 'navigate_to_pose'; it has: simulate_steps" == run.log.answer(GOAL).error_msg

    def test_a_cancel_pauses_between_two_steps(self, paused):
        """Further steps are possible at once."""
        paused.simulator.submit(steps(30))
        paused.simulator.advance(1.25)
        paused.simulator.submit(CancelGoal("_world", "simulate_steps", STEPS))
        paused.simulator.advance(9.0)
        stopped = (paused.simulator.now, paused.simulator.paused)
        paused.simulator.submit(steps(2, NEXT))
        paused.simulator.run()

        assert (1.25, "CANCELED") == paused.log.changes(STEPS)[-1]
        assert (1.25, True) == stopped
        assert (1.45, "SUCCEEDED") == paused.log.changes(NEXT)[-1]

    def test_a_reset_aborts_it(self, paused):
        paused.simulator.submit(steps(30))
        paused.simulator.submit(GetResult("_world", "simulate_steps", STEPS, "result"))
        paused.simulator.advance(1.25)
        paused.ask("reset_simulation")

        answer = paused.log.answer("result")
        assert GoalStatus.ABORTED == answer.status
        assert "the simulation was reset" == answer.result.result.error_message
        assert (0.0, True) == (paused.simulator.now, paused.simulator.paused)

    def test_playing_aborts_it(self, paused):
        paused.simulator.submit(steps(30))
        paused.simulator.advance(1.25)
        become(paused, PLAYING)
        paused.simulator.advance(9.0)

        assert (1.25, "ABORTED") == paused.log.changes(STEPS)[-1]
        assert (9.0, math.inf) == (paused.simulator.now, paused.simulator.limit)


SCRIPTED = SMALL_WORLD | {
    "robots": {
        "wall_e": {"type": "nurse", "at": "home", "script": ["Go shelf", "Grab parcel", "Go 7 2.5", "Drop parcel"]},
        "eve": {"type": "nurse", "at": "shelf", "script": ["Wait 0.3", "Go door", "Go island"]},
    }
}


def story(run):
    return [
        (time, event.robot, event.action, event.goal_id, event.status, event.result)
        for time, event in run.log.events
        if isinstance(event, GoalChanged) and event.robot != "_world"
    ]


@pytest.mark.parametrize("number", [1, 3, 1000])
def test_stepping_equals_running(number):
    whole = simulate(SCRIPTED)
    whole.simulator.run(20.0)
    stepped = simulate(SCRIPTED)
    become(stepped, PAUSED)
    while stepped.simulator.now < 20.0:
        stepped.ask("step_simulation", {"steps": number})
        stepped.simulator.run()

    assert story(whole) == story(stepped)


def test_a_request_of_another_kind_is_read_strictly():
    with pytest.raises(ValueError, match="should be an object"):
        SetSimulationState.Request.model_validate_json(json.dumps({"state": 2}))

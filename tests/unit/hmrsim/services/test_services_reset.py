"""Resetting the simulation, in whole or in part."""

from __future__ import annotations

import pytest

from hmrsim.interfaces.simulation_interfaces import ResetSimulation, Result
from hmrsim.protocol.commands import GetResult
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import RosterChanged, Sampled
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.scripts import ScriptState
from tests.simulation import SMALL_WORLD, A, B, go, send, simulate

TIME, STATE, SPAWNED, ALL = (
    ResetSimulation.Request.SCOPE_TIME,
    ResetSimulation.Request.SCOPE_STATE,
    ResetSimulation.Request.SCOPE_SPAWNED,
    ResetSimulation.Request.SCOPE_ALL,
)
SCRIPTED = SMALL_WORLD | {
    "robots": {"wall_e": {"type": "nurse", "at": "home", "script": ["Go shelf", "Grab parcel", "Go home"]}}
}


def reset(run, scope=0):
    return run.ask("reset_simulation", {"scope": scope}).result


def spawn(run, name="bob"):
    pose = {"pose": {"position": {"x": 3.0, "y": 2.0}}}
    run.ask("spawn_entity", {"name": name, "uri": "robot_type:carrier", "initial_pose": pose})


class TestGoals:
    @pytest.mark.parametrize("scope", [0, TIME, STATE, ALL])
    def test_running_goals_are_aborted(self, run, scope):
        run((0.0, go(9, 2)), (0.0, GetResult("wall_e", "navigate_to_pose", A, "waiting")), until=1.5)
        reset(run, scope)
        run.simulator.submit(GetResult("wall_e", "navigate_to_pose", A, "later"))

        assert (1.5, "ABORTED") == run.log.changes(A)[-1]
        assert "the simulation was reset" == run.log.answer("waiting").result.error_msg
        assert GoalStatus.ABORTED is run.log.answer("later").status

    def test_a_goal_accepted_at_the_same_instant_is_aborted(self, run):
        run.simulator.submit(go(9, 2))
        reset(run)
        run.simulator.run()

        assert [(0.0, "ACCEPTED"), (0.0, "EXECUTING"), (0.0, "ABORTED")] == run.log.changes(A)
        assert (1.0, 2.0) == run.simulator.robots["wall_e"].pose().point

    def test_results_of_ended_goals_are_kept(self, run):
        run((0.0, go(9, 2)))
        reset(run)
        run.simulator.submit(GetResult("wall_e", "navigate_to_pose", A, "later"))

        assert GoalStatus.SUCCEEDED is run.log.answer("later").status

    def test_goals_of_robots_that_stay_continue_when_only_others_are_removed(self, run):
        spawn(run)
        run((0.0, go(9, 2)), (0.0, go(9, 2, robot="bob", goal_id=B)), until=1.0)
        reset(run, SPAWNED)
        run.simulator.run()

        assert [(8.0, "SUCCEEDED"), (1.0, "ABORTED")] == [run.log.changes(goal)[-1] for goal in (A, B)]

    def test_a_goal_after_it_takes_as_long_as_before(self, run):
        run((0.0, go(9, 2)), until=3.0)
        reset(run)
        run((0.0, go(9, 2, goal_id=B)))

        assert (8.0, "SUCCEEDED") == run.log.changes(B)[-1]

    def test_generated_ids_are_never_reused(self, run):
        """The result of an old goal is still kept under its id."""
        run.simulator.submit(go(9, 2, None, reply_to=A))
        reset(run)
        run.simulator.submit(go(9, 2, None, reply_to="second"))

        assert run.log.answer(A).goal_id != run.log.answer("second").goal_id


class TestTime:
    @pytest.mark.parametrize(("scope", "now"), [(0, 0.0), (ALL, 0.0), (TIME, 0.0), (STATE, 1.5), (SPAWNED, 1.5)])
    def test_time_is_0_again(self, run, scope, now):
        run((0.0, go(9, 2)), until=1.5)
        reset(run, scope)

        assert now == run.simulator.now
        assert (scope in (0, ALL, TIME)) == (run.simulator.generation == 1)

    def test_a_robot_stays_where_it_is(self, run):
        run((0.0, go(9, 2)), until=1.5)
        reset(run, TIME)
        run.simulator.run()

        assert (2.5, 2.0) == run.simulator.robots["wall_e"].pose().point

    def test_samples_restart(self):
        run = simulate(topics=frozenset({Topic.CLOCK}))
        run.simulator.advance(1.55)
        reset(run, TIME)
        del run.log.events[:]
        run.simulator.advance(0.35)

        assert [0.1, pytest.approx(0.2), pytest.approx(0.3)] == [time for time, _ in run.log.events]

    def test_the_clock_is_published_once_more(self):
        run = simulate(topics=frozenset({Topic.CLOCK}))
        run.simulator.settle()
        run.simulator.advance(0.05)
        reset(run, TIME)
        run.simulator.settle()

        assert 2 == len([event for _, event in run.log.events if isinstance(event, Sampled)])

    def test_a_paused_simulation_stays_paused(self, run):
        run.simulator.advance(1.5)
        run.ask("set_simulation_state", {"state": {"state": 2}})
        reset(run)
        run.simulator.advance(9.0)

        assert (0.0, 2) == (run.simulator.now, run.ask("get_simulation_state").state.state)

    @pytest.mark.parametrize("at", [0.0, 1.5])
    def test_a_script_fails_unless_the_state_is_reset(self, at):
        """Even the first goal of a script that has not begun is aborted, so that the script does not hang."""
        run = simulate(SCRIPTED)
        run.simulator.advance(at)
        reset(run, TIME)
        run.simulator.run()

        script = run.simulator.scripts.all["wall_e"]
        assert (ScriptState.FAILED, 0.0, 0.0) == (script.state, script.ended, run.simulator.now)
        assert "'Go shelf' ended ABORTED: the simulation was reset" == script.error


class TestState:
    def test_robots_return_to_their_start(self, run):
        run((0.0, send("pickup", target_name="letter")), (0.0, go(9, 2, goal_id=B)))
        reset(run, STATE)

        wall_e = run.simulator.robots["wall_e"]
        assert (1.0, 2.0, 0.0) == wall_e.pose()
        assert (None, (1.0, 2.1)) == (wall_e.components["claw"].item, run.simulator.items["letter"].position)

    def test_deleted_robots_are_back(self, run):
        for name in ("wall_e", "parcel", "letter"):
            run.ask("delete_entity", {"entity": name})
        reset(run, STATE)
        run((0.0, send("pickup", target_name="letter")))

        assert ["wall_e", "eve", "cart"] == [*run.simulator.robots]
        assert ["parcel", "anvil", "letter"] == [*run.simulator.items]
        assert (0.0, "SUCCEEDED") == run.log.changes(A)[-1]

    def test_a_deleted_robot_whose_name_is_taken_stays_deleted(self, run):
        run.ask("delete_entity", {"entity": "wall_e"})
        spawn(run, "wall_e")
        reset(run, STATE)
        before = run.simulator.robots["wall_e"].type
        reset(run)

        assert ("carrier", "nurse") == (before, run.simulator.robots["wall_e"].type)

    def test_spawned_robots_return_to_their_first_pose(self, run):
        spawn(run)
        run((0.0, go(9, 2, robot="bob")))
        reset(run, STATE)

        assert (3.0, 2.0, 0.0) == run.simulator.robots["bob"].pose()

    def test_scripts_restart(self):
        run = simulate(SCRIPTED)
        run.simulator.advance(3.0)
        reset(run, STATE)
        run.simulator.run()

        script = run.simulator.scripts.all["wall_e"]
        assert (ScriptState.DONE, 3.0 + 16.0) == (script.state, script.ended)

    def test_scripts_that_start_at_the_instant_of_a_reset_restart(self):
        run = simulate(SCRIPTED)
        reset(run)
        log = run()

        assert 4 == len([event for _, event in log.events if getattr(event, "goal", None) is not None])

    def test_a_run_after_a_reset_repeats_the_first(self):
        """Only the ids of goals differ."""
        run = simulate(SCRIPTED, topics=frozenset({Topic.EVENTS}))
        run.simulator.run()
        first = [(time, type(event)) for time, event in run.log.events]
        reset(run)
        del run.log.events[:]
        run.simulator.run()

        assert first == [(time, type(event)) for time, event in run.log.events]


class TestSpawned:
    def test_spawned_entities_are_removed(self, run):
        spawn(run)
        run.ask("spawn_entity", {"name": "box", "uri": "item"})
        del run.log.events[:]
        reset(run, SPAWNED)

        assert ["wall_e", "eve", "cart", "parcel", "anvil", "letter"] == run.ask("get_entities").entities
        assert [RosterChanged()] == [event for _, event in run.log.events if isinstance(event, RosterChanged)]

    def test_unchanged_robots_are_not_announced(self, run):
        reset(run)

        assert [] == [event for _, event in run.log.events if isinstance(event, RosterChanged)]


def test_a_reset_is_published_after_the_aborted_goals(run):
    run((0.0, go(9, 2)), until=1.5)
    reset(run, TIME | STATE)

    assert [(0.0, {"scope": 3})] == run.log.happened("reset")


@pytest.mark.parametrize("scope", [8, 128, 254])
def test_other_scopes_are_not_supported(run, scope):
    run.simulator.advance(1.5)
    result = reset(run, scope)

    assert (Result.RESULT_FEATURE_UNSUPPORTED, 1.5) == (result.result, run.simulator.now)
    assert f"scope {scope} has unknown bits; expected a sum of 1, 2, 4, or 255" == result.error_message

"""Controllers that are killed, stalled and doubled, and whose wire loses messages."""

from __future__ import annotations

import json

import pytest

from hmrsim.actions import registry
from hmrsim.events.simulation import RunReported
from hmrsim_zenoh import Commander
from hmrsim_zenoh.errors import Idle
from tests.cases import case


def executing(**more):
    """Return the anchor of ann's goals to wait."""
    return {"goal": "executing", "robot": "ann", "action": "wait", **more}


def killed(**more):
    """Return a disturbance that kills the controller 4 s after its goal has begun."""
    return {"disturbance": "controller_killed", "when": executing(after=4.0), **more}


STALLED = {"disturbance": "controller_stalled", "when": executing(after=4.0), "duration": 20.0}
SECOND = {"disturbance": "second_controller", "when": executing(after=4.0)}
LOST = {"disturbance": "reply_lost", "when": executing(after=4.0), "count": 3}
REPEATED = {"disturbance": "request_repeated", "when": executing(), "count": 3}
RESET = {"disturbance": "simulation_reset", "when": executing(after=4.0)}
ALL = [killed(), killed(restart_after=3.0), STALLED, SECOND, LOST, REPEATED, RESET]


def goals(run):
    """Return the goals that ann got, with their times and senders."""
    lines = map(json.loads, run.trace.splitlines())
    return [(line["stamp"]["sec"], line.get("by")) for line in lines if line.get("command") == "send_goal"]


def statuses(run):
    """Return the times and statuses at which ann's goals ended."""
    lines = map(json.loads, run.trace.splitlines())
    return [(line["stamp"]["sec"], line["status"]) for line in lines if line.get("status", 0) > 3]


def test_every_disturbance_gives_the_same_trace_again(disturbed, waiting):
    for disturbances in [*([each] for each in ALL), ALL]:
        with case(disturbances):
            runs = [disturbed(waiting(10, 10, 10), *disturbances) for _ in range(3)]

            assert runs[0].trace == runs[1].trace == runs[2].trace


def test_disturbed_runs_replay_exactly(disturbed, waiting):
    for disturbances in [*([each] for each in ALL), ALL]:
        with case(disturbances):
            run = disturbed(waiting(10, 10), *disturbances)

            assert run.replay.difference is None
            assert run.replay.complete


class TestKilled:
    """A controller that is killed."""

    def test_restarts_after_the_delay(self, disturbed, waiting):
        """A controller starts from scratch each time that it was killed."""
        controller = waiting(10, 10)
        disturbed(controller, killed(restart_after=3.0), killed(restart_after=1.0) | {"when": executing(nth=3)})

        assert [[0.0], [7.0, 17.0], [18.0, 28.0, 38.0]] == controller.times

    def test_goals_of_a_killed_controller_continue(self, disturbed, waiting):
        def careful(client, robots):
            try:
                return controller(client, robots)
            finally:
                client.action_client("ann", registry()["wait"]).cancel_all()
                client.end_run("never_said")

        controller = waiting(10, 10)
        run = disturbed(careful, killed())

        assert [(10, 4)] == statuses(run)
        assert RunReported.kind not in run.trace

    def test_time_passes_after_a_final_kill(self, disturbed, waiting):
        run = disturbed(waiting(10, 10), killed(), duration=50.0)

        assert "killed" == run.ending
        assert run.trace.endswith('{"kind":"end","stamp":{"nanosec":0,"sec":50}}\n')

    def test_time_without_a_limit_passes_until_nothing_is_left(self, disturbed, waiting):
        run = disturbed(waiting(10, 10), killed(), duration=float("inf"))

        assert ("killed", [(10, 4)]) == (run.ending, statuses(run))

    def test_catching_everything_does_not_keep_it_alive(self, disturbed, waiting):
        """A killed controller sends nothing, and has no ending."""
        controller = waiting(10)

        def stubborn(client, robots):
            try:
                return controller(client, robots)
            except BaseException:  # noqa: BLE001 - that is the point
                return True

        assert "killed" == disturbed(stubborn, killed()).ending

    def test_killed_controller_misses_the_events_of_that_instant(self, disturbed, waiting):
        controller = waiting(10, 10)
        disturbed(controller, killed(restart_after=0.0) | {"when": executing(goal="succeeded")})

        assert [[0.0], [10.0, 20.0, 30.0]] == controller.times


class TestStalled:
    """A controller that neither receives nor sends anything for some time."""

    def test_stalled_controller_gets_messages_late(self, disturbed, waiting):
        controller = waiting(10, 10)
        disturbed(controller, STALLED)

        assert [[0.0, 24.0, 34.0]] == controller.times

    def test_goal_that_ends_after_a_stall_is_on_time(self, disturbed, waiting):
        controller = waiting(30)
        disturbed(controller, STALLED)

        assert [[0.0, 30.0]] == controller.times

    def test_stalled_controller_misses_the_event_that_stalls_it(self, disturbed, waiting):
        controller = waiting(10, 10)
        disturbed(controller, STALLED | {"when": executing(goal="succeeded")})

        assert [[0.0, 30.0, 40.0]] == controller.times


class TestSecond:
    """Another instance of the controller."""

    def test_both_controllers_send_goals(self, disturbed, waiting):
        run = disturbed(waiting(10, 10), SECOND)

        assert [(0, "nurse"), (4, "nurse_2")] == goals(run)[:2]

    def test_second_controller_replaces_a_killed_one(self, disturbed, waiting):
        run = disturbed(waiting(10, 10), SECOND, killed())

        assert ("succeeded", [(0, "nurse"), (4, "nurse_2"), (14, "nurse_2")]) == (run.ending, goals(run))

    def test_run_ends_with_the_first_controller(self, disturbed, waiting):
        """The second one stops even if the first has left lockstep before."""

        def leaving(client, robots):
            waiting(10)(client, robots)
            client.lockstep.close()
            return False

        run = disturbed(leaving, SECOND)

        assert [(4, 6), (4, 6)] == statuses(run)

    def test_first_controller_is_killed_while_it_waits_for_the_second(self, disturbed, waiting):
        first, second = waiting(15, robot="bob"), waiting(3, 3, 10)

        def controller(client, robots):
            return (second if first.times else first)(client, robots)

        bob = {"goal": "executing", "robot": "bob", "action": "wait"}
        run = disturbed(
            controller,
            SECOND | {"when": {**bob, "after": 4.0}},
            killed() | {"when": {**bob, "after": 8.0}},
        )

        assert ("succeeded", [[4.0, 7.0, 10.0, 20.0]]) == (run.ending, second.times)

    def test_crash_of_the_second_controller_counts(self, disturbed, waiting):
        def alone(client, robots):
            if client.now:
                raise ValueError("there is another one")
            return waiting(10)(client, robots)

        run = disturbed(alone, SECOND)

        assert "crashed" == run.ending
        assert "there is another one" in run.cause


class TestWire:
    """Messages that are lost or repeated."""

    def test_client_repeats_a_lost_request(self, disturbed, waiting):
        """The request is carried out once."""
        controller = waiting(10, 10)
        run = disturbed(controller, LOST | {"count": 100})

        assert [[0.0, 10.0, 20.0]] == controller.times
        assert 2 == len(goals(run))

    def test_plain_request_without_its_answer_is_carried_out(self, disturbed, waiting):
        replies = []

        def plain(client, robots):
            client.end_run("soon")
            replies.extend(client.session.get(SEND_GOAL, payload=GOAL))
            return waiting(10)(client, robots)

        run = disturbed(plain, LOST | {"when": {"event": RunReported.kind}, "count": 1})

        assert [] == replies
        assert (0, None) == goals(run)[0]

    def test_repeated_plain_request_is_a_second_goal(self, disturbed, waiting):
        replies = []

        def plain(client, robots):
            client.end_run("soon")
            replies.extend(client.session.get(SEND_GOAL, payload=GOAL))
            return waiting(10)(client, robots)

        run = disturbed(plain, REPEATED | {"when": {"event": RunReported.kind}, "count": 1})

        assert [True] == [json.loads(reply.ok.payload)["accepted"] for reply in replies]
        assert 2 == [by for _, by in goals(run)].count(None)


SEND_GOAL = "hmrsim/ann/wait/_action/send_goal"
GOAL = b'{"goal":{"time":{"sec":1}}}'


def test_reset_aborts_the_goal(disturbed, waiting):
    controller = waiting(10, 10)
    run = disturbed(controller, RESET)

    assert [[0.0, 0.0, 10.0]] == controller.times
    assert [(4, 6), (10, 4)] == statuses(run)


def test_delay_continues_after_a_reset(disturbed, waiting):
    run = disturbed(waiting(10, 10), RESET, STALLED | {"when": executing(after=6.0)})

    assert [(4.0, "simulation_reset"), (2.0, "controller_stalled")] == run.acted


def test_delay_ends_at_a_whole_nanosecond(disturbed):
    """Traces have whole nanoseconds, so a replay comes to the same time."""

    def going(client, _robots):
        Commander(client, "ann").go_to_pose(1 / 3, 0)
        Commander(client, "ann").go_to_pose(10, 0)
        return True

    run = disturbed(going, RESET | {"when": {"goal": "succeeded", "after": 1 / 7}})

    assert run.replay.difference is None


def test_each_disturbance_happens_once(disturbed, waiting):
    """Later occurrences do not trigger it, even after a reset."""
    run = disturbed(waiting(10, 10, 10), RESET | {"when": executing(nth=2, after=1.0)})

    assert [(11.0, "simulation_reset")] == run.acted


@pytest.mark.parametrize("error", [ValueError("oops"), Idle("nothing")])
def test_crash_has_its_cause(disturbed, error):
    def crashing(_client, _robots):
        raise error

    run = disturbed(crashing)

    assert "crashed" == run.ending
    assert str(error) in run.cause

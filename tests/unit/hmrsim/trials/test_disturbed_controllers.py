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
    """Return a controller's death 4 s after its goal has begun."""
    return {"disturbance": "controller_killed", "when": executing(after=4.0), **more}


STALLED = {"disturbance": "controller_stalled", "when": executing(after=4.0), "duration": 20.0}
SECOND = {"disturbance": "second_controller", "when": executing(after=4.0)}
LOST = {"disturbance": "reply_lost", "when": executing(after=4.0), "count": 3}
REPEATED = {"disturbance": "request_repeated", "when": executing(), "count": 3}
RESET = {"disturbance": "simulation_reset", "when": executing(after=4.0)}
ALL = [killed(), killed(restart_after=3.0), STALLED, SECOND, LOST, REPEATED, RESET]


def goals(run):
    """Return when ann was sent which goals, and by whom."""
    lines = map(json.loads, run.trace.splitlines())
    return [(line["stamp"]["sec"], line.get("by")) for line in lines if line.get("command") == "send_goal"]


def statuses(run):
    """Return when ann's goals ended, and how."""
    lines = map(json.loads, run.trace.splitlines())
    return [(line["stamp"]["sec"], line["status"]) for line in lines if line.get("status", 0) > 3]


def test_every_disturbance_gives_the_same_trace_again(disturbed, waiting):
    """Also with threads, and alone or with all others."""
    for disturbances in [*([each] for each in ALL), ALL]:
        with case(disturbances):
            runs = [disturbed(waiting(10, 10, 10), *disturbances) for _ in range(3)]

            assert runs[0].trace == runs[1].trace == runs[2].trace


def test_a_replay_of_every_disturbed_run_is_the_same(disturbed, waiting):
    """A trace has all that a disturbance does to the simulation."""
    for disturbances in [*([each] for each in ALL), ALL]:
        with case(disturbances):
            run = disturbed(waiting(10, 10), *disturbances)

            assert run.replay.difference is None
            assert run.replay.complete


class TestKilled:
    """A controller that is killed."""

    def test_it_begins_again_later(self, disturbed, waiting):
        """From scratch, at the time at which it is started, and as often as it is killed."""
        controller = waiting(10, 10)
        disturbed(controller, killed(restart_after=3.0), killed(restart_after=1.0) | {"when": executing(nth=3)})

        assert [[0.0], [7.0, 17.0], [18.0, 28.0, 38.0]] == controller.times

    def test_its_goals_go_on(self, disturbed, waiting):
        """Nobody cancels them, also not what it does in the end."""

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

    def test_one_that_stays_away_lets_time_go_on(self, disturbed, waiting):
        """To the end of the run."""
        run = disturbed(waiting(10, 10), killed(), duration=50.0)

        assert "killed" == run.ending
        assert run.trace.endswith('{"kind":"end","stamp":{"nanosec":0,"sec":50}}\n')

    def test_without_an_end_time_goes_on_until_nothing_is_left(self, disturbed, waiting):
        """As nobody will ever ask for more."""
        run = disturbed(waiting(10, 10), killed(), duration=float("inf"))

        assert ("killed", [(10, 4)]) == (run.ending, statuses(run))

    def test_it_can_catch_everything(self, disturbed, waiting):
        """It is dead all the same: what it says is not heard, and it has not ended by itself."""
        controller = waiting(10)

        def stubborn(client, robots):
            try:
                return controller(client, robots)
            except BaseException:  # noqa: BLE001 - that is the point
                return True

        assert "killed" == disturbed(stubborn, killed()).ending

    def test_it_dies_before_it_hears_of_that_instant(self, disturbed, waiting):
        """A controller that dies when its goal ends has not been told."""
        controller = waiting(10, 10)
        disturbed(controller, killed(restart_after=0.0) | {"when": executing(goal="succeeded")})

        assert [[0.0], [10.0, 20.0, 30.0]] == controller.times


class TestStalled:
    """A controller that hears and says nothing for some time."""

    def test_it_hears_later(self, disturbed, waiting):
        """Of a goal that has ended meanwhile, and goes on from there."""
        controller = waiting(10, 10)
        disturbed(controller, STALLED)

        assert [[0.0, 24.0, 34.0]] == controller.times

    def test_what_it_hears_on_time_is_on_time(self, disturbed, waiting):
        """A goal that ends later than that is not late."""
        controller = waiting(30)
        disturbed(controller, STALLED)

        assert [[0.0, 30.0]] == controller.times

    def test_it_does_not_hear_what_stalls_it(self, disturbed, waiting):
        """As when its goal ends."""
        controller = waiting(10, 10)
        disturbed(controller, STALLED | {"when": executing(goal="succeeded")})

        assert [[0.0, 30.0, 40.0]] == controller.times


class TestSecond:
    """Another instance of the controller."""

    def test_both_control(self, disturbed, waiting):
        """The second from when it is started."""
        run = disturbed(waiting(10, 10), SECOND)

        assert [(0, "nurse"), (4, "nurse_2")] == goals(run)[:2]

    def test_it_goes_on_for_one_that_is_killed(self, disturbed, waiting):
        """Its ending is that of the run."""
        run = disturbed(waiting(10, 10), SECOND, killed())

        assert ("succeeded", [(0, "nurse"), (4, "nurse_2"), (14, "nurse_2")]) == (run.ending, goals(run))

    def test_the_run_ends_with_the_first_one(self, disturbed, waiting):
        """Also where that has left lockstep before it ends: the other does nothing more."""

        def leaving(client, robots):
            waiting(10)(client, robots)
            client.lockstep.close()
            return False

        run = disturbed(leaving, SECOND)

        assert [(4, 6), (4, 6)] == statuses(run)

    def test_its_crash_is_one(self, disturbed, waiting):
        """Two of them are no reason to crash."""

        def alone(client, robots):
            if client.now:
                raise ValueError("there is another one")
            return waiting(10)(client, robots)

        run = disturbed(alone, SECOND)

        assert "crashed" == run.ending
        assert "there is another one" in run.cause


class TestWire:
    """Messages that get lost, or come twice."""

    def test_a_client_asks_again(self, disturbed, waiting):
        """Nothing is done twice."""
        controller = waiting(10, 10)
        run = disturbed(controller, LOST | {"count": 100})

        assert [[0.0, 10.0, 20.0]] == controller.times
        assert 2 == len(goals(run))

    def test_an_answer_to_a_plain_request_is_lost(self, disturbed, waiting):
        """The request was carried out, and no reply comes."""
        replies = []

        def plain(client, robots):
            client.end_run("soon")
            replies.extend(client.session.get(SEND_GOAL, payload=GOAL))
            return waiting(10)(client, robots)

        run = disturbed(plain, LOST | {"when": {"event": RunReported.kind}, "count": 1})

        assert [] == replies
        assert (0, None) == goals(run)[0]

    def test_a_plain_request_comes_twice(self, disturbed, waiting):
        """As a second goal, if it has no id; nobody hears the answer to that."""
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


def test_a_reset_aborts_the_goal(disturbed, waiting):
    """The controller is told, and goes on at time 0."""
    controller = waiting(10, 10)
    run = disturbed(controller, RESET)

    assert [[0.0, 0.0, 10.0]] == controller.times
    assert [(4, 6), (10, 4)] == statuses(run)


def test_a_delay_goes_on_after_a_reset(disturbed, waiting):
    """What is left of it is left."""
    run = disturbed(waiting(10, 10), RESET, STALLED | {"when": executing(after=6.0)})

    assert [(4.0, "simulation_reset"), (2.0, "controller_stalled")] == run.acted


def test_a_delay_ends_at_a_whole_nanosecond(disturbed):
    """As a trace has it, so that a replay comes to the very same time."""

    def going(client, _robots):
        Commander(client, "ann").go_to_pose(1 / 3, 0)
        Commander(client, "ann").go_to_pose(10, 0)
        return True

    run = disturbed(going, RESET | {"when": {"goal": "succeeded", "after": 1 / 7}})

    assert run.replay.difference is None


def test_each_disturbance_happens_once(disturbed, waiting):
    """At the occurrence that is meant, however many there are, also after a reset."""
    run = disturbed(waiting(10, 10, 10), RESET | {"when": executing(nth=2, after=1.0)})

    assert [(11.0, "simulation_reset")] == run.acted


@pytest.mark.parametrize("error", [ValueError("oops"), Idle("nothing")])
def test_a_crash_is_told(disturbed, error):
    """With its cause."""

    def crashing(_client, _robots):
        raise error

    run = disturbed(crashing)

    assert "crashed" == run.ending
    assert str(error) in run.cause

"""A client that takes part in a real simulator's time."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.nav2_msgs import FollowPath, Wait
from hmrsim.interfaces.nav_msgs import Path
from hmrsim.protocol.goal import GoalStatus, made_goal_id
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.client.connection import Condition
from hmrsim_zenoh.client.zenoh_connection import MAX_BYTES
from hmrsim_zenoh.errors import ClientClosed, Dropped, GoalRejectedError, GoalTimeout, Idle, RequestError
from tests.patience import PATIENCE
from tests.served_world import served_world

WAIT = registry()["wait"]


def seconds(number):
    return Wait.Goal(time=Duration.from_seconds(number))


@pytest.fixture
def options():
    with served_world(clock="lockstep") as options:
        yield options


@pytest.fixture
def client(options):
    """Return a client that takes part by itself, as the simulator's time waits for participants."""
    with Client(options, name="nurse") as client:
        yield client


@pytest.fixture
def wait(client):
    return client.action_client("wall_e", WAIT)


# --- goals -------------------------------------------------------------------------------------------------------


def test_after_a_result_the_time_is_that_of_the_goals_end(client, wait):
    goal = wait.send_goal(seconds(3000))

    assert goal.result(PATIENCE).total_elapsed_time == Duration(sec=3000)
    assert (client.now, goal.status) == (3000.0, GoalStatus.SUCCEEDED)


def test_sending_a_goal_takes_no_time(client, wait):
    """The goal is not even sent before the client waits."""
    goal = wait.send_goal(seconds(3))

    assert (goal.accepted, goal.status, client.now) == (None, GoalStatus.UNKNOWN, 0.0)


def test_waiting_for_the_acceptance_takes_no_time(client, wait):
    goal = wait.send_goal(seconds(3))
    goal.wait_accepted(PATIENCE)

    assert (goal.accepted, goal.done, client.now) == (True, False, 0.0)


def test_a_cancel_of_all_goals_ends_those_sent_before_at_once(client, wait):
    goal = wait.send_goal(seconds(100))
    wait.cancel_all()
    goal.result(PATIENCE)

    assert (GoalStatus.CANCELED, 0.0) == (goal.status, client.now)


def test_a_cancel_of_all_goals_leaves_later_ones_alone(wait):
    wait.cancel_all()
    goal = wait.send_goal(seconds(100))
    goal.result(PATIENCE)

    assert GoalStatus.SUCCEEDED is goal.status


def test_goals_of_many_robots_end_at_their_own_times(client):
    """The order of the waits does not matter."""
    ends = []
    goals = [
        client.action_client(robot, WAIT).send_goal(seconds(time), on_change=lambda _goal: ends.append(client.now))
        for robot, time in (("wall_e", 5.0), ("eve", 2.5), ("cart", 4.0))
    ]
    for goal in goals:
        goal.result(PATIENCE)

    # All three were accepted by the time that the first had ended.
    assert ends == [2.5, 2.5, 2.5, 2.5, 4.0, 5.0]


def test_the_ids_are_the_same_in_every_run(options):
    """Ids count by participant, also when it joins again and beside ids of the user."""
    with Client(options, name="nurse") as client:
        first = client.action_client("wall_e", WAIT).send_goal(seconds(1))
        first.result(PATIENCE)
    with Client(options, name="nurse") as client:
        given = client.action_client("wall_e", WAIT).send_goal(seconds(1), goal_id="0" * 31 + "1")
        third = client.action_client("wall_e", WAIT).send_goal(seconds(1))
        third.result(PATIENCE)

    expected = (made_goal_id("nurse", 1), "0" * 31 + "1", made_goal_id("nurse", 3))
    assert expected == (first.goal_id, given.goal_id, third.goal_id)


def test_a_rejection_is_known_at_once(client, wait):
    wait.send_goal(seconds(100))
    rejected = client.action_client("marvin", WAIT).send_goal(seconds(1))

    with pytest.raises(GoalRejectedError, match="unknown_robot"):
        rejected.result(PATIENCE)
    assert client.now == 0.0


def test_more_goals_than_fit_in_a_request_are_sent_at_one_time(client):
    """They go in several requests at one instant."""
    goal = FollowPath.Goal(path=Path(poses=[PoseStamped()] * 2000))
    follow = client.action_client("wall_e", registry()["follow_path"])
    goals = [follow.send_goal(goal) for _ in range(5)]
    last = client.action_client("eve", WAIT).send_goal(seconds(1))
    last.wait_accepted(PATIENCE)

    assert sum(len(goal.model_dump_json()) for _ in goals) > MAX_BYTES
    assert ([True] * 5, client.now) == ([each.accepted for each in goals], 0.0)


def test_a_malformed_goal_fails_no_other(wait):
    bad = wait.send_goal({"time": {"sec": "soon"}})
    good = wait.send_goal(seconds(1))

    with pytest.raises(RequestError, match=r"goal\.time\.sec: Input should be a valid integer"):
        bad.result(PATIENCE)
    assert good.result(PATIENCE).total_elapsed_time == Duration(sec=1)


def test_a_wait_for_a_condition_ends_when_it_is_met(client, wait):
    goal = wait.send_goal(seconds(30))
    near = Condition("wall_e/wait/_action/feedback", [("/feedback/time_left/sec", "<", 12)])
    other = Condition("_world/events", [("/kind", "==", "fault_began")])

    assert client.lockstep.wait_for(near, other) == [near]
    assert (client.now, goal.done) == (18.1, False)
    assert client.lockstep.wait_for(other, until=20.0) == []
    assert goal.result(PATIENCE).total_elapsed_time == Duration(sec=30)
    assert client.now == 30.0


def test_an_invalid_condition_is_an_error(client):
    with pytest.raises(RequestError, match="eve has no battery"):
        client.lockstep.wait_for(Condition("eve/battery_state"), until=5.0)

    client.sleep(1.0)


def test_a_condition_calls_back_once(client, wait):
    """The callback follows the results of its instant, and does not come after the condition was removed."""
    seen = []
    lockstep = client.lockstep
    ended = Condition("_world/events", [("/kind", "==", "status"), ("/status", "==", 4)])
    lockstep.watch(ended, lambda error: seen.append((error, goal.done, client.now)))
    take_back = lockstep.watch(ended, seen.append)
    goal = wait.send_goal(seconds(3))
    client.sleep(1.0)
    take_back()
    wait.send_goal(seconds(3)).result(PATIENCE)
    goal = wait.send_goal(seconds(3))
    goal.result(PATIENCE)

    assert seen == [(None, True, 4.0)]


def test_the_end_of_lockstep_ends_conditions_with_an_error(client, options):
    seen = []
    client.lockstep.watch(Condition("_world/events", [("/kind", "==", "never")]), seen.append)
    goal = client.action_client("wall_e", WAIT).send_goal(seconds(5))
    goal.wait_accepted(PATIENCE)
    with Client(options, clock="realtime") as operator:
        operator.get("hmrsim/_world/time/set", payload=b'{"clock":"realtime","real_time_factor":100}')
    goal.result(PATIENCE)

    assert ["lockstep is over; subscribe to the topic"] == list(map(str, seen))


def test_a_cancel_follows_its_goal_without_waiting_for_the_acceptance(client, wait):
    goal = wait.send_goal(seconds(3))
    goal.cancel()
    goal.result(PATIENCE)

    assert (goal.status, client.now) == (GoalStatus.CANCELED, 0.0)


def test_feedback_wakes_the_client_that_asked_for_it(client, wait):
    """A callback can cancel the goal at the instant of its feedback."""
    seen = []

    def look(feedback):
        seen.append(feedback.time_left.to_seconds())
        if len(seen) == 3:
            goal.cancel()

    goal = wait.send_goal(seconds(3), on_feedback=look)
    goal.result(PATIENCE)

    assert (seen[:3], goal.status, client.now) == ([2.9, 2.8, 2.7], GoalStatus.CANCELED, 0.3)


def test_feedback_without_a_callback_wakes_no_client(client, wait):
    """Two advances suffice, and the goal goes with the first."""
    wait.send_goal(seconds(3)).result(PATIENCE)

    assert client.lockstep._epoch == 1


def test_timeouts_are_in_wall_time(options):
    """Another participant holds the time, and goal and client continue after the timeout."""
    with Client(options, name="thinker") as thinker, Client(options, name="nurse") as client:
        assert thinker.now == 0.0
        goal = client.action_client("wall_e", WAIT).send_goal(seconds(3))
        with pytest.raises(GoalTimeout, match=r"no result of goal .* after 0.05 s; it goes on"):
            goal.result(0.05)
        thinker.close()

        assert goal.result(PATIENCE).total_elapsed_time == Duration(sec=3)


def test_the_commander_works_in_lockstep(client):
    wall_e = Commander(client, "wall_e")
    wall_e.go_to_pose(9, 2)
    wall_e.pickup("parcel")

    assert client.now == 8.0


def test_an_unreadable_advance_fails_its_goals_and_the_next_may_succeed():
    with served_world(clock="lockstep", max_payload=500) as options, Client(options) as client:
        pickup = client.action_client("wall_e", registry()["pickup"]).send_goal(registry()["pickup"].goal())
        with pytest.raises(RequestError, match=r"payload of .* bytes; at most 500 are taken"):
            pickup.result(PATIENCE)

        assert client.action_client("wall_e", WAIT).send_goal(seconds(1)).result(PATIENCE) == Wait.Result(
            total_elapsed_time=Duration(sec=1)
        )


# --- time --------------------------------------------------------------------------------------------------------


def test_a_sleep_advances_time_to_the_nanosecond(client):
    client.sleep(0.1)
    client.sleep(0.2)

    assert client.now == pytest.approx(0.3, abs=1e-9)


def test_a_wait_that_can_not_end_is_an_error(client):
    client.sleep(1.0)

    with pytest.raises(Idle, match="nothing is scheduled"):
        client.lockstep.drive(lambda: False, PATIENCE)


def test_two_clients_wait_for_each_other(options):
    """Time stands while either client computes."""
    times = []

    def other():
        with Client(options, name="other") as client:
            assert client.now == 0.0
            joined.set()
            for _ in range(5):
                client.sleep(1.0)
                times.append(client.now)

    with Client(options, name="nurse") as client:
        assert client.now == 0.0
        joined = threading.Event()
        thread = threading.Thread(target=other)
        thread.start()
        joined.wait(PATIENCE)
        client.action_client("wall_e", WAIT).send_goal(seconds(10)).result(PATIENCE)
        thread.join(PATIENCE)

    assert times == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_two_threads_can_each_wait_for_a_goal(client):
    """One thread advances time and wakes the other."""
    ends = {}

    def follow(robot, time):
        client.action_client(robot, WAIT).send_goal(seconds(time)).result(PATIENCE)
        ends[robot] = client.now

    threads = [threading.Thread(target=follow, args=args) for args in (("wall_e", 5.0), ("eve", 2.0))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)

    assert ends["wall_e"] >= 5.0
    assert ends["eve"] >= 2.0


def test_a_wait_in_a_callback_is_an_error(client, wait, caplog):
    """The awaited event comes only after the callback."""
    other = client.action_client("eve", WAIT)
    goal = wait.send_goal(seconds(1), on_change=lambda _goal: other.send_goal(seconds(1)).result())
    goal.result(PATIENCE)

    assert "a callback can't wait for what happens after it" in caplog.text


# --- ends --------------------------------------------------------------------------------------------------------


def test_a_client_of_real_time_does_not_take_part(options):
    """Its goals are applied while time is stopped."""
    with Client(options, clock="realtime") as client:
        client.action_client("wall_e", WAIT).send_goal(seconds(1)).wait_accepted(PATIENCE)

        assert (client.lockstep, client.now) == (None, 0.0)


def test_a_taken_name_is_refused(client, options):
    assert client.now == 0.0
    with Client(options, name="nurse") as second, pytest.raises(RequestError, match="'nurse' has joined already"):
        second.action_client("wall_e", WAIT).send_goal(seconds(1))


def test_a_client_that_computes_for_too_long_is_dropped():
    """All its open goals fail with the reason."""
    with served_world(clock="lockstep", participant_timeout=2.0) as options, Client(options, name="nurse") as client:
        dropped = threading.Event()
        client.subscribe("hmrsim/_world/events", lambda _key, body: b"dropped" in body and dropped.set())
        goal = client.action_client("wall_e", WAIT).send_goal(seconds(100))
        assert dropped.wait(PATIENCE)

        with pytest.raises(Dropped, match=r"'nurse' was dropped at 0\.000 s: .* join again"):
            goal.result(PATIENCE)


def test_goals_and_sleeps_continue_when_the_clock_is_set_to_real_time(client, options):
    goal = client.action_client("wall_e", WAIT).send_goal(seconds(5))
    goal.wait_accepted(PATIENCE)
    with Client(options, clock="realtime") as operator:
        operator.get("hmrsim/_world/time/set", payload=b'{"clock":"realtime","real_time_factor":100}')

    assert goal.result(PATIENCE).total_elapsed_time == Duration(sec=5)
    client.sleep(1.0)
    assert (client.lockstep, client.now >= 6.0) == (None, True)


def test_a_reset_ends_open_goals(client, options, wait):
    """The reset may come while the client computes, and the client continues afterwards."""
    client.sleep(3.0)
    goal = wait.send_goal(seconds(30))
    goal.wait_accepted(PATIENCE)
    with Client(options, clock="realtime") as operator:
        operator.get("hmrsim/_world/reset_simulation", payload=b"{}")

    assert goal.result(PATIENCE).error_msg == "the simulation was reset"
    client.sleep(1.0)
    assert (goal.status, client.now) == (GoalStatus.ABORTED, 1.0)


@pytest.mark.parametrize(("service", "payload"), [("reset_simulation", b"{}"), ("load_world", b'{"uri":"scenario1"}')])
def test_the_time_after_the_clients_own_reset_is_zero_at_once(client, service, payload):
    client.sleep(50.0)
    client.get(f"hmrsim/_world/{service}", payload=payload)

    assert client.now == 0.0


def test_time_advances_after_a_reset_by_a_callback(client, wait):
    client.sleep(3.0)
    seen = []

    def reset(goal):
        if goal.accepted and not seen:
            client.get("hmrsim/_world/reset_simulation", payload=b"{}")
            seen.append(client.now)

    wait.send_goal(seconds(30), on_change=reset)
    client.sleep(1.0)
    wait.send_goal(seconds(2)).result(PATIENCE)

    assert seen == [0.0]
    assert client.now == 2.0


def test_a_goal_that_waited_for_long_survives_the_end_of_lockstep(options):
    """Its time for acceptance starts when the simulator could have answered."""
    with Client(options, name="thinker") as thinker, Client(options, name="nurse", acknowledge_timeout=3.0) as client:
        assert thinker.now == 0.0
        goal = client.action_client("wall_e", WAIT).send_goal(seconds(1))
        with pytest.raises(GoalTimeout, match="it goes on"):
            goal.result(3.2)
        thinker.get("hmrsim/_world/time/set", payload=b'{"clock":"realtime","real_time_factor":100}')

        assert goal.result(PATIENCE).total_elapsed_time == Duration(sec=1)


def test_an_interrupt_while_another_participant_holds_the_time_cancels_the_goal():
    program = """
import signal, sys
from hmrsim_zenoh import Client, Commander, SessionOptions
signal.signal(signal.SIGINT, signal.default_int_handler)
with Client(SessionOptions(connect=(sys.argv[1],)), name="script") as client:
    Commander(client, "wall_e").wait(100)
"""
    with (
        served_world(clock="lockstep", participants=("nurse", "script")) as options,
        Client(options, name="nurse") as nurse,
    ):
        command = [sys.executable, "-c", program, *options.connect]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as script:
            nurse.sleep(1.0)
            # The script has its grant, and has asked again.
            waiting = (json.loads(nurse.get("hmrsim/_world/time/state"))["waiting_for"] for _ in range(10_000))
            assert ["nurse"] in waiting
            script.send_signal(signal.SIGINT)
            _, errors = script.communicate()
        # The script does not wait for long until its cancel has an answer.
        statuses = (nurse.get("hmrsim/wall_e/wait/_action/status") for _ in range(1000))
        canceled = any(b'"status":5' in status for status in statuses)

    assert errors.endswith("KeyboardInterrupt\n")
    assert canceled


def test_a_cancel_is_not_lost_when_the_client_leaves(options):
    """Without a further advance it is sent on the goal's own key."""
    with Client(options, clock="realtime") as watcher:
        with Client(options, name="nurse") as client:
            goal = client.action_client("wall_e", WAIT).send_goal(seconds(100))
            goal.wait_accepted(PATIENCE)
            goal.cancel()
        status = watcher.get("hmrsim/wall_e/wait/_action/status")

    assert b'"status":5' in status


def test_closing_fails_open_goals(options):
    client = Client(options)
    goal = client.action_client("wall_e", WAIT).send_goal(seconds(100))
    goal.wait_accepted(PATIENCE)
    client.close()

    with pytest.raises(ClientClosed, match="closed while the goal was under way"):
        goal.result(PATIENCE)
    with pytest.raises(ClientClosed, match="closed"):
        client.sleep(1.0)


# --- what went wrong once ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("duration", [float("inf"), float("nan"), -1.0, 1e12])
def test_an_invalid_duration_of_a_sleep_is_refused(client, wait, duration):
    """Later requests work as usual."""
    with pytest.raises(ValueError, match=r"can't sleep for .* s; it is 0\.0 s now"):
        client.sleep(duration)

    assert wait.send_goal(seconds(3)).result(PATIENCE).total_elapsed_time == Duration(sec=3)


def test_a_goal_that_is_sent_twice_has_two_tickets(wait):
    """The first gets its result, and the second an error, as the goal already exists."""
    first = wait.send_goal(seconds(3), goal_id="c" * 32)
    second = wait.send_goal(seconds(3), goal_id="c" * 32)

    assert first.result(PATIENCE).total_elapsed_time == Duration(sec=3)
    with pytest.raises(GoalRejectedError, match="duplicate_goal_id"):
        second.result(PATIENCE)


def test_events_after_an_interrupted_callback_come_with_the_next_wait(client, wait):

    def interrupt(_goal):
        if not interrupted:
            interrupted.append(True)
            raise KeyboardInterrupt

    interrupted = []
    first = wait.send_goal(seconds(3), on_change=interrupt)
    second = client.action_client("eve", WAIT).send_goal(seconds(3))
    with pytest.raises(KeyboardInterrupt):
        first.result(PATIENCE)

    assert second.result(PATIENCE).total_elapsed_time == Duration(sec=3)


def test_a_client_may_take_part_again_after_the_clock_was_set(client, wait):
    """The clock is set to real time and back: the client gets one error and then takes part again."""
    wait.send_goal(seconds(3)).result(PATIENCE)
    for clock in ("realtime", "lockstep"):
        client.get(client.keys.world("time/set"), payload=b'{"clock":"%b"}' % clock.encode())
    with pytest.raises(Dropped, match="was removed: the clock was set to realtime; join again"):
        client.sleep(1.0)

    assert wait.send_goal(seconds(3000)).result(PATIENCE).total_elapsed_time == Duration(sec=3000)

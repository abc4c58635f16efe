"""A simulator in the process of its clients, which behaves as over Zenoh."""

from __future__ import annotations

import json
import threading

import pytest
import zenoh

from hmrsim.actions import registry
from hmrsim.errors import SimulationStopped
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh import Client, ClientClosed, Commander, RequestError, SimulationEnded, SimulatorGone, Unreachable
from hmrsim_zenoh.errors import SimulatorNotFound
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost
from tests.patience import PATIENCE
from tests.wire.loopback.conftest import goal_to

NAVIGATE, WAIT = registry()["navigate_to_pose"], registry()["wait"]


def waiting(seconds):
    return Wait.Goal.model_validate({"time": {"sec": seconds}})


class TestGoals:
    def test_a_goal_succeeds_with_feedback_while_its_result_is_awaited(self, host, client):
        heard = []
        goal = client.action_client("ann", NAVIGATE).send_goal(goal_to(10, 0), on_feedback=heard.append)

        assert NavigateToPose.Result() == goal.result()
        assert (10.0, (10.0, 0.0)) == (client.now, host.simulator.robots["ann"].pose().point)
        assert heard

    def test_a_canceled_robot_stops_where_it_is(self, client):
        goal = client.action_client("ann", WAIT).send_goal(waiting(60))
        goal.wait_accepted()
        client.sleep(2.0)
        goal.cancel()
        goal.result()

        assert ("CANCELED", 2.0) == (goal.status.name, client.now)

    @pytest.mark.parametrize("lockstep", [False, True])
    @pytest.mark.parametrize("kind", [dict, NavigateToPose.Goal])
    def test_a_text_that_is_too_long_is_the_same_error_as_over_zenoh(self, client, kind, lockstep):
        if lockstep:
            client.sleep(1.0)
        goal = client.action_client("ann", NAVIGATE).send_goal(kind(behavior_tree="x" * 4097))

        with pytest.raises(
            RequestError, match=r"^goal\.behavior_tree: a text of 4097 characters; at most 4096 are taken$"
        ):
            goal.wait_accepted()

    def test_a_commander_waits_for_its_goals(self, client):
        ann = Commander(client, "ann")
        ann.go_to_pose(10, 0)
        ann.go_to_pose(0, 0)

        assert 20.0 == client.now

    def test_no_thread_is_started(self, client):
        before = threading.active_count()
        client.subscribe("hmrsim/**", lambda _key, _payload: None)
        client.action_client("ann", WAIT).send_goal(waiting(3)).result()

        assert before == threading.active_count()

    def test_open_goals_fail_when_the_host_stops(self, host, client):
        goal = client.action_client("ann", WAIT).send_goal(waiting(60))
        goal.wait_accepted()
        host.stop()

        with pytest.raises(SimulatorGone):
            goal.result(1.0)

    def test_requests_fail_after_the_duration_of_the_run(self, world):
        with LoopbackHost(world, RunSettings(duration=5.0)) as host, Client(session=host.open_session()) as client:
            goal = client.action_client("ann", WAIT).send_goal(waiting(60))

            assert ("the simulation has ended", GoalStatus.ABORTED) == (goal.result().error_msg, goal.status)
            assert 5.0 == host.simulator.now
            with pytest.raises(SimulationEnded, match="the run is over: it was to last 5 s"):
                client.sleep(1.0)
            with pytest.raises(SimulationEnded, match="the run is over: it was to last 5 s"):
                client.action_client("ann", WAIT).send_goal(waiting(60))


class TestReading:
    def test_latest_values_are_read_by_key_or_by_wildcard(self, client):
        odometry = json.loads(client.get("hmrsim/ann/odom"))

        assert 0.0 == odometry["pose"]["pose"]["position"]["x"]
        assert {"hmrsim/ann/odom", "hmrsim/bob/odom"} == client.get_all("hmrsim/*/odom").keys()
        assert ["ann", "bob"] == [robot["name"] for robot in client.info()["robots"]]

    def test_a_reading_of_all_ends_when_all_have_answered(self, client, monkeypatch):
        limits = []
        monkeypatch.setattr(client.session, "get", lambda _key, timeout: limits.append(timeout) or [])
        client.get_all("hmrsim/*/odom")

        assert [60.0] == limits

    def test_the_description_is_a_copy_of_the_info_message(self, client):
        said = json.loads(client.get("hmrsim/_world/info"))
        told = client.info()
        told["robots"][0]["actions"].clear()
        told["services"].clear()

        assert said == client.info()

    def test_a_stopped_host_answers_no_lookups(self, host, client):
        client.alive  # noqa: B018 - it has been seen
        host.stop()
        for ask in (client.info, client.places.load):
            with pytest.raises((SimulatorGone, SimulatorNotFound, Unreachable)):
                ask()

    def test_a_request_that_comes_as_another_thread_ends_the_run_is_refused(self, host, client, monkeypatch):
        def put(_command):
            raise SimulationStopped("the simulation has ended")

        monkeypatch.setattr(host._inbox, "put", put)
        with pytest.raises(RequestError, match="the simulation has ended"):
            client.places.load()

    def test_keys_are_served_once_for_all_threads(self, host):
        """The first use of a key waits while another thread runs the simulation."""
        found = []
        with host.delivery.lock:
            threads = [threading.Thread(target=lambda: found.append(host.exchange)) for _ in range(2)]
            for thread in threads:
                thread.start()
            assert [] == found
        for thread in threads:
            thread.join(PATIENCE)

        assert [host.exchange] * 2 == found

    def test_closing_the_session_closes_the_client(self, host):
        for ask in (Client.info, lambda client: client.places.load(), lambda client: client.get("hmrsim/_world/info")):
            session = host.open_session()
            with Client(session=session) as client:
                client.info()
                session.close()
                with pytest.raises(ClientClosed):
                    ask(client)

    def test_a_key_without_a_value_is_the_same_error_as_over_zenoh(self, client):
        with pytest.raises(RequestError, match="no topic 'smell'"):
            client.get("hmrsim/ann/smell")
        with pytest.raises(Unreachable):
            client.get("elsewhere/odom")

    def test_samples_arrive_in_order_while_time_is_stopped(self, client):
        heard = []
        client.subscribe("hmrsim/_world/events", lambda _key, payload: heard.append(json.loads(payload)))
        client.action_client("ann", WAIT).send_goal(waiting(3)).result()

        assert [1, 2, 4] == [event["status"] for event in heard if event["kind"] == "status"]

    def test_a_subscriber_with_history_gets_the_latest_value_first(self, client):
        heard = []
        for history in (False, True):
            client.subscribe("hmrsim/_world/info", lambda _key, _payload, at=history: heard.append(at), history=history)

        assert [True] == heard

    def test_a_closed_subscription_gets_no_more_samples(self, client):
        heard = []
        client.subscribe("hmrsim/_world/events", lambda _key, payload: heard.append(payload)).close()
        client.action_client("ann", WAIT).send_goal(waiting(3)).result()

        assert [] == heard

    def test_the_host_is_present_while_it_serves(self, host, client):
        assert client.alive
        host.stop()
        assert not client.alive


class TestTokens:
    """Liveliness tokens, as a session of Zenoh has them."""

    @pytest.fixture
    def seen(self, client):
        """Return the tokens that have come (True) and gone (False)."""
        seen = []
        client.session.liveliness().declare_subscriber(
            "hmrsim/*/alive",
            lambda sample: seen.append((str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)),
            history=True,
        )
        return seen

    def test_those_of_the_robots_and_the_world_are_there_until_the_host_stops(self, host, seen):
        tokens = ["hmrsim/ann/alive", "hmrsim/bob/alive", "hmrsim/_world/alive"]
        before = [*seen]
        host.stop()

        assert [(token, True) for token in tokens] == before
        assert [(token, False) for token in tokens] == seen[3:]

    @pytest.mark.parametrize("end", ["undeclare", "close", "cut"])
    def test_that_of_a_session_is_gone_when_it_ends(self, host, client, seen, end):
        session = host.open_session()
        token = session.liveliness().declare_token("hmrsim/cat/alive")
        if end == "cut":
            host.cut(session, Cut())
            client.info()
        else:
            getattr(token if end == "undeclare" else session, end)()

        assert [("hmrsim/cat/alive", True), ("hmrsim/cat/alive", False)] == seen[3:]

    def test_they_can_be_queried(self, client):
        found, ended = [], []
        handler = zenoh.handlers.Callback(found.append, lambda: ended.append(True), indirect=False)
        client.session.liveliness().get("hmrsim/_world/alive", handler)

        assert (["hmrsim/_world/alive"], [True]) == ([str(reply.ok.key_expr) for reply in found], ended)


class TestTime:
    """Time advances while all participants wait."""

    def test_two_clients_in_threads_are_granted_the_same_time(self, host):
        ends = {}

        def wait(name, seconds):
            with Client(session=host.open_session(), name=name) as client:
                client.now  # noqa: B018 - it takes part from now on
                both.wait()
                client.sleep(seconds)
                ends[name] = client.now

        both = threading.Barrier(2)
        threads = [threading.Thread(target=wait, args=each) for each in (("one", 2.0), ("two", 5.0))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)

        assert {"one": 2.0, "two": 5.0} == ends

    def test_a_clock_that_moves_by_itself_is_refused(self, client):
        with pytest.raises(RequestError, match="lockstep only"):
            client.get("hmrsim/_world/time/set", payload=b'{"clock":"realtime"}')

    def test_a_taken_name_is_refused(self, host, client):
        assert client.now == 0.0
        other = Client(session=host.open_session())
        with pytest.raises(RequestError, match="has joined already"):
            other.sleep(1.0)
        other.close()

    def test_a_client_that_is_refused_for_its_name_does_not_end_the_other_one(self, host, client):
        client.sleep(1.0)
        with Client(session=host.open_session()) as other, pytest.raises(RequestError):
            other.sleep(1.0)
        client.sleep(1.0)

        assert 2.0 == client.now

    def test_a_closed_client_makes_no_requests(self, client):
        client.close()
        with pytest.raises(ClientClosed):
            client.get("hmrsim/ann/odom")


class TestPlanner:
    def test_a_planner_in_the_same_process_plans_while_time_is_stopped(self, host, client):
        asked = []

        def plan(query):
            goal = json.loads(query.payload.to_bytes())
            asked.append(client.now)
            poses = [{"pose": {"position": {"x": x, "y": 0.0}}} for x in (0.0, 10.0)]
            query.reply("hmrsim/_planner/compute_path_to_pose", json.dumps({"path": {"poses": [*poses, goal["goal"]]}}))

        host.open_session().declare_queryable("hmrsim/_planner/compute_path_to_pose", plan)
        client.action_client("bob", NAVIGATE).send_goal(goal_to(10, 0)).result()

        assert ([0.0], (10.0, 0.0)) == (asked, host.simulator.robots["bob"].pose().point)


def test_a_program_can_take_part_twice_under_names_from_the_environment(host, monkeypatch):
    monkeypatch.setenv("HMRSIM_NAME_SUFFIX", "_2")
    with Client(session=host.open_session(), name="nurse") as client:
        client.sleep(1.0)

        assert ("nurse_2",) == host.pacing.lockstep.participants


class Cut(BaseException):
    """Raised by a session that was cut."""


class TestCut:
    def test_each_call_on_a_cut_session_raises_the_error(self, host):
        """So does a call that is waiting for its reply at that moment."""
        with Client(session=host.open_session()) as client:
            client.sleep(1.0)
            host.simulator.env.alarm(1.0, lambda: host.pacing.intervene(lambda: host.cut(client.session, Cut())))
            for _ in range(2):
                with pytest.raises(Cut):
                    client.sleep(5.0)
            with pytest.raises(Cut):
                client.close()

    def test_a_call_that_waits_for_another_client_raises_the_error(self, host, client, monkeypatch):
        waits, raised, wait_while = threading.Event(), [], host.delivery.wait_while

        def note_wait(*args):
            waits.set()
            wait_while(*args)

        def sleep(session):
            try:
                Client(session=session, name="other").sleep(5.0)
            except Cut as error:
                raised.append(error)

        monkeypatch.setattr(host.delivery, "wait_while", note_wait)
        client.now  # noqa: B018 - it takes part from now on
        session, error = host.open_session(), Cut()
        thread = threading.Thread(target=sleep, args=(session,), daemon=True)
        thread.start()
        waits.wait(PATIENCE)
        host.cut(session, error)
        thread.join(PATIENCE)

        assert [error] == raised

    def test_the_participant_of_a_cut_session_is_dropped_at_once(self, host):
        client = Client(session=host.open_session())
        client.sleep(1.0)
        host.simulator.env.alarm(1.0, lambda: host.pacing.intervene(lambda: host.cut(client.session, Cut())))
        with pytest.raises(Cut):
            client.sleep(5.0)

        assert (2.0, ()) == (host.simulator.now, host.pacing.lockstep.participants)

    def test_a_cut_session_receives_nothing(self, host, client):
        session, heard = host.open_session(), []
        session.declare_subscriber("there/**", lambda sample: heard.append(sample.payload.to_bytes()))
        host.cut(session, Cut())
        client.session.put("there/it/is", b"news")

        assert [] == heard


class TestLosses:
    def test_a_query_with_a_lost_answer_ends_without_a_reply(self, host, client):
        host.losses.watch()
        host.losses.lose_answers(1)
        key, request = "hmrsim/_world/get_entities", b"{}"
        lost, there = list(client.session.get(key, payload=request)), list(client.session.get(key, payload=request))

        assert ([], 1) == (lost, len(there))

    def test_a_lost_answer_to_join_is_given_again(self, host, client):
        """The client is not mistaken for another one of its name."""
        host.losses.watch()
        host.losses.lose_answers(1)
        client.sleep(2.0)

        assert ("client",) == host.pacing.lockstep.participants

    def test_a_lookup_of_places_with_a_lost_answer_is_repeated(self, host, client):
        """It changes nothing, unlike other requests with a payload."""
        host.losses.watch()
        host.losses.lose_answers(1)

        assert "a" in client.places.load()
        host.losses.lose_answers(1)
        with pytest.raises(Unreachable):
            client.get("hmrsim/_world/get_entities", payload=b"{}")

    def test_a_repeated_request_is_answered_once(self, host, client):
        host.losses.repeat_requests(1)
        goal = b'{"goal": {"time": {"sec": 60}}}'
        replies = list(client.session.get("hmrsim/ann/wait/_action/send_goal", payload=goal))
        status = json.loads(client.get("hmrsim/ann/wait/_action/status"))

        assert (1, 2) == (len(replies), len(status["status_list"]))

    def test_readings_are_neither_lost_nor_repeated(self, host, client):
        host.losses.watch()
        host.losses.lose_answers(1)

        assert client.info()

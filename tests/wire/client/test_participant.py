"""The requests of a participant, to a simulator that loses replies, forgets and rejects."""

from __future__ import annotations

import json
import threading

import pytest
import zenoh

from hmrsim.protocol.commands import CancelGoal
from hmrsim.protocol.outputs import Granted
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.participant import Participant, check_name
from hmrsim_zenoh.errors import ClientClosed, Dropped, RequestError, SimulatorGone
from hmrsim_zenoh.wire.session import SessionOptions
from tests.patience import PATIENCE

CANCEL = CancelGoal("eve", "wait", "a" * 32)
NOTHING = {"accepted": [], "events": []}


class Keeper:
    """Answers the requests about time by a script: each has its answers; the last one is repeated.

    An answer is the body of a reply; a `RequestError`, which is replied as such; or None for no reply at all.
    """

    def __init__(self, simulator):
        self.requests = []
        self.answers = {
            "join": [{"participant": "nurse", "epoch": 4, "now": 2.5, "goals": 3}],
            "leave": [{"participant": "nurse"}],
            "state": [{"epoch": 0, "now": 0.0, "clock": "lockstep", "participants": ["nurse"]}],
        }
        handler = zenoh.handlers.Callback(self._on_query, indirect=False)
        self._queryable = simulator.session.declare_queryable("hmrsim/_world/time/*", handler, complete=True)

    def of(self, name):
        """Return the bodies of the requests of a name."""
        return [body for request, body in self.requests if request == name]

    def _on_query(self, query):
        name = str(query.key_expr).rpartition("/")[2]
        self.requests.append((name, json.loads(query.payload.to_bytes()) if query.payload else None))
        answers = self.answers[name]
        answer = answers.pop(0) if len(answers) > 1 else answers[0]
        if isinstance(answer, RequestError):
            query.reply_err(json.dumps({"error": str(answer), "details": list(answer.details)}))
        elif answer is not None:
            query.reply(query.key_expr, json.dumps(answer))


def refusal(field, text):
    """Return a simulator's error reply."""
    return RequestError(text, [{"field": field, "message": text, "value": None}])


@pytest.fixture
def keeper(simulator):
    """Return a keeper that answers for the simulator."""
    return Keeper(simulator)


@pytest.fixture
def participant(keeper, client):  # noqa: ARG001 - who answers
    """Return a participant that has joined in epoch 4, at 2.5 s, after three goals in former lives."""
    participant = Participant(client._link, "nurse")
    assert participant.join() == 3
    return participant


def test_joining_returns_epoch_and_time(keeper, participant):
    assert (participant.epoch, participant.now) == (4, 2.5)
    assert [request["name"] for request in keeper.of("join")] == ["nurse"]


def test_the_token_is_declared_before_joining_and_removed_after_a_rejection(simulator, keeper, client, watched):
    keeper.answers["join"] = [refusal("name", "no")]
    simulator.session.liveliness().declare_subscriber("hmrsim/_participant/*", lambda sample: watched(sample.kind))
    with pytest.raises(RequestError, match="no"):
        Participant(client._link, "nurse").join()

    assert watched.wait(lambda kinds: len(kinds) == 2) == [zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE]


def test_an_advance_has_all_its_fields_and_commands(keeper, participant):
    keeper.answers["advance"] = [{"epoch": 5, "now": 3.0, "reason": "until", **NOTHING}]
    participant.ask(3.0, frozenset({"result"}), frozenset({"feedback"}), (CANCEL,))
    granted = participant.take(PATIENCE)
    participant.accept(granted)

    assert (granted, participant.epoch, participant.now) == (Granted(5, 3.0, "until"), 5, 3.0)
    assert keeper.of("advance") == [
        {
            "participant": "nurse",
            "epoch": 4,
            "until": 3.0,
            "wake": ["result"],
            "report": ["feedback"],
            "commands": [{"robot": "eve", "action": "wait", "cancel": "a" * 32}],
        }
    ]


def test_an_advance_whose_reply_was_lost_is_repeated(keeper, participant):
    keeper.answers["advance"] = [None, None, {"epoch": 5, "now": 3.0, "reason": "idle", **NOTHING}]
    participant.ask(commands=(CANCEL,))
    granted = participant.take(PATIENCE)

    first, second, third = keeper.of("advance")
    assert (granted.reason, first, second) == ("idle", second, third)


def test_waiting_in_turns_does_not_repeat_the_request(simulator, keeper, participant):
    release = threading.Event()
    keeper._queryable.undeclare()

    def held(query):
        release.wait(PATIENCE)
        query.reply(query.key_expr, json.dumps({"epoch": 5, "now": 3.0, "reason": "until", **NOTHING}))

    queryable = simulator.session.declare_queryable("hmrsim/_world/time/advance", held, complete=True)
    participant.ask()
    early = participant.take(0.05)
    asking = participant.request is not None
    release.set()

    assert (early, asking, participant.take(PATIENCE).now) == (None, True, 3.0)
    queryable.undeclare()


def test_a_grant_can_be_taken_again_until_it_is_accepted(keeper, participant):
    """The client may be interrupted before it has handled the grant."""
    keeper.answers["advance"] = [{"epoch": 5, "now": 3.0, "reason": "until", **NOTHING}]
    participant.ask(3.0)
    first, second = participant.take(PATIENCE), participant.take(PATIENCE)
    asking = participant.request is not None
    participant.accept(second)

    assert (first, asking, participant.request, len(keeper.of("advance"))) == (second, True, None, 1)


def test_a_wrong_epoch_is_corrected_once(keeper, participant):
    """The simulation was reset meanwhile, and the advance is still to be made."""
    granted = {"epoch": 1, "now": 0.5, "reason": "until", **NOTHING}
    keeper.answers["advance"] = [refusal("epoch", "epoch 4 is not the current one, which is 0"), granted]
    participant.ask(0.5)
    participant.accept(participant.take(PATIENCE))

    assert [4, 0] == [request["epoch"] for request in keeper.of("advance")]
    assert (participant.epoch, participant.now) == (1, 0.5)


def test_an_epoch_that_stays_wrong_is_an_error(keeper, participant):
    """Another participant advances under the same name."""
    keeper.answers["advance"] = [refusal("epoch", "epoch 4 is not the current one, which is 7")]
    participant.ask()

    with pytest.raises(RequestError, match="not the current one"):
        participant.take(PATIENCE)
    assert len(keeper.of("advance")) == 2


def test_a_dropped_participant_gets_the_reason(keeper, participant):
    text = "participant 'nurse' was dropped at 4.000 s: it kept the others waiting; join again"
    keeper.answers["advance"] = [refusal("participant", text)]
    participant.ask()

    with pytest.raises(Dropped, match=r"dropped at 4\.000 s: it kept the others waiting; join again"):
        participant.take(PATIENCE)


def test_setting_the_clock_to_real_time_ends_the_part(keeper, participant):
    keeper.answers["advance"] = [refusal("", "the clock is realtime; set it to lockstep first")]
    keeper.answers["state"] = [{"epoch": 6, "now": 9.5, "clock": "realtime"}]
    participant.ask()

    assert participant.take(PATIENCE) == Granted(6, 9.5, "end")


def test_an_unreadable_request_is_an_error_and_the_next_may_succeed(keeper, participant):
    keeper.answers["advance"] = [
        refusal("commands.0.goal", "too large"),
        {"epoch": 5, "now": 3.0, "reason": "until", **NOTHING},
    ]
    participant.ask()
    with pytest.raises(RequestError, match="too large"):
        participant.take(PATIENCE)
    participant.ask()

    assert participant.take(PATIENCE).reason == "until"


def test_a_wait_ends_when_the_simulator_goes(simulator, keeper, participant):
    """The request itself is held by a participant that hangs."""
    keeper.answers["advance"] = [None]
    participant.ask()
    simulator.vanish()

    with pytest.raises(SimulatorGone, match="is gone"):
        participant.take(PATIENCE)


def test_leaving_is_announced(keeper, participant):
    participant.leave()

    assert keeper.of("leave") == [{"participant": "nurse"}]


def test_a_closed_client_can_not_join(simulator):
    client = Client(SessionOptions(connect=(simulator.endpoint,)))
    client.close()

    with pytest.raises(ClientClosed, match="closed"):
        Participant(client._link, "nurse").join()


@pytest.mark.parametrize("name", ["", "7of9", "a/b", "a*", "nurse station"])
def test_a_name_is_one_chunk_of_a_key(name):
    with pytest.raises(ValueError, match="is not a valid participant name"):
        check_name(name)

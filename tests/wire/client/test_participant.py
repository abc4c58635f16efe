"""The requests of a participant, against a simulator that loses replies, forgets and refuses."""

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
    """Return an error as the simulator replies it."""
    return RequestError(text, [{"field": field, "message": text, "value": None}])


@pytest.fixture
def keeper(simulator):
    """Return what answers for the simulator."""
    return Keeper(simulator)


@pytest.fixture
def participant(keeper, client):  # noqa: ARG001 - who answers
    """Return a participant that has joined in epoch 4, at 2.5 s, after three goals in former lives."""
    participant = Participant(client._link, "nurse")
    assert participant.join() == 3
    return participant


def test_joining_returns_epoch_and_time(keeper, participant):
    """The first advance begins with them."""
    assert (participant.epoch, participant.now) == (4, 2.5)
    assert [request["name"] for request in keeper.of("join")] == ["nurse"]


def test_the_token_is_there_before_it_joins(simulator, keeper, client, watched):
    """Otherwise a simulator could not tell a dead participant from a living one; a refused join removes it."""
    keeper.answers["join"] = [refusal("name", "no")]
    simulator.session.liveliness().declare_subscriber("hmrsim/_participant/*", lambda sample: watched(sample.kind))
    with pytest.raises(RequestError, match="no"):
        Participant(client._link, "nurse").join()

    assert watched.wait(lambda kinds: len(kinds) == 2) == [zenoh.SampleKind.PUT, zenoh.SampleKind.DELETE]


def test_an_advance_says_what_is_wanted(keeper, participant):
    """Field by field; the commands come as they were given."""
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


def test_a_lost_reply_is_asked_for_again(keeper, participant):
    """The same request, which gets the same answer."""
    keeper.answers["advance"] = [None, None, {"epoch": 5, "now": 3.0, "reason": "idle", **NOTHING}]
    participant.ask(commands=(CANCEL,))
    granted = participant.take(PATIENCE)

    first, second, third = keeper.of("advance")
    assert (granted.reason, first, second) == ("idle", second, third)


def test_an_answer_may_be_waited_for_in_turns(simulator, keeper, participant):
    """Time that is not granted yet is not asked for again."""
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


def test_an_answer_may_be_taken_until_it_is_accepted(keeper, participant):
    """A caller that was interrupted before gets the answer again, without another request to the simulator."""
    keeper.answers["advance"] = [{"epoch": 5, "now": 3.0, "reason": "until", **NOTHING}]
    participant.ask(3.0)
    first, second = participant.take(PATIENCE), participant.take(PATIENCE)
    asking = participant.request is not None
    participant.accept(second)

    assert (first, asking, participant.request, len(keeper.of("advance"))) == (second, True, None, 1)


def test_a_wrong_epoch_is_looked_up_once(keeper, participant):
    """The simulation was reset while we were thinking: what we want is still to be done."""
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
    """The error has the simulator's text."""
    text = "participant 'nurse' was dropped at 4.000 s: it kept the others waiting; join again"
    keeper.answers["advance"] = [refusal("participant", text)]
    participant.ask()

    with pytest.raises(Dropped, match=r"dropped at 4\.000 s: it kept the others waiting; join again"):
        participant.take(PATIENCE)


def test_a_clock_that_was_set_to_real_time_is_an_end(keeper, participant):
    """The error is not the participant's fault: time goes on without it."""
    keeper.answers["advance"] = [refusal("", "the clock is realtime; set it to lockstep first")]
    keeper.answers["state"] = [{"epoch": 6, "now": 9.5, "clock": "realtime"}]
    participant.ask()

    assert participant.take(PATIENCE) == Granted(6, 9.5, "end")


def test_a_request_that_can_not_be_read_is_an_error(keeper, participant):
    """Nothing was done of it, and the next one may be better."""
    keeper.answers["advance"] = [
        refusal("commands.0.goal", "too large"),
        {"epoch": 5, "now": 3.0, "reason": "until", **NOTHING},
    ]
    participant.ask()
    with pytest.raises(RequestError, match="too large"):
        participant.take(PATIENCE)
    participant.ask()

    assert participant.take(PATIENCE).reason == "until"


def test_a_simulator_that_goes_ends_the_wait(simulator, keeper, participant):
    """The wait ends after the grace, although the request is held by a participant that hangs."""
    keeper.answers["advance"] = [None]
    participant.ask()
    simulator.vanish()

    with pytest.raises(SimulatorGone, match="is gone"):
        participant.take(PATIENCE)


def test_leaving_is_announced(keeper, participant):
    """The other participants do not wait for it any longer."""
    participant.leave()

    assert keeper.of("leave") == [{"participant": "nurse"}]


def test_a_closed_client_can_not_join(simulator):
    """A participant of a closed client could not advance."""
    client = Client(SessionOptions(connect=(simulator.endpoint,)))
    client.close()

    with pytest.raises(ClientClosed, match="closed"):
        Participant(client._link, "nurse").join()


@pytest.mark.parametrize("name", ["", "7of9", "a/b", "a*", "nurse station"])
def test_a_name_is_one_word(name):
    """It is part of a key."""
    with pytest.raises(ValueError, match="is not a valid participant name"):
        check_name(name)

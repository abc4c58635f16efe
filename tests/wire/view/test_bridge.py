"""A page's WebSocket and the simulator behind it."""

from __future__ import annotations

import json
from contextlib import ExitStack

import pytest
from websockets.exceptions import ConnectionClosed

from hmrsim import __version__
from hmrsim_zenoh.wire.session import SessionOptions
from tests.served_world import served_world
from tests.wire.view.pages import fetched, opened, viewed

WAIT = {"goal": {"time": {"sec": 0, "nanosec": 1}}}


def test_the_server_introduces_itself(page):
    """The first frame names the prefix, the version, and whether the simulator is there."""
    hello = page.hear("hello")
    hello.pop("alive")

    assert {"op": "hello", "source": "live", "prefix": "hmrsim", "version": __version__} == hello


def test_a_key_is_got(page):
    """The reply's key is below the prefix, as the request's was."""
    ((key, scene),) = page.get("_world/scene")["replies"]

    assert ("_world/scene", "wall_e") == (key, scene["robots"][0]["name"])


def test_a_goal_is_sent_and_followed(page):
    """A page sees what happens to its goal: nothing of it is known to the server."""
    page.say("subscribe", id=1, key="_world/events")
    ((_, accepted),) = page.get("wall_e/wait/_action/send_goal", payload=WAIT)["replies"]
    heard = page.samples(lambda payload: payload.get("status") == 4)

    assert accepted["accepted"] is True
    mine = [payload for _, _, payload in heard if payload.get("goal_id") == accepted["goal_id"]]
    assert [None, 1, 2, 4] == [payload.get("status") for payload in mine]


def test_events_from_before_a_page_was_opened_are_kept(server, session, wait_for_listener):
    """The events for people are kept, even if no page was open."""
    wait_for_listener("hmrsim/_world/log", there=True)
    asked = json.dumps({"goal_id": "7" * 32, **WAIT}).encode()
    session.get("hmrsim/wall_e/wait/_action/send_goal", payload=asked).recv()
    session.get("hmrsim/wall_e/wait/_action/get_result", payload=json.dumps({"goal_id": "7" * 32}).encode()).recv()

    mine = []
    # The last one may be on its way to the server when the result is here.
    for _ in range(1000):
        status, _, body = fetched(server.url, "/log")
        mine = [event for event in json.loads(body) if event.get("goal_id") == "7" * 32]
        if len(mine) == 4:
            break
    assert (200, [None, 1, 2, 4]) == (status, [event.get("status") for event in mine])
    assert WAIT["goal"] == mine[0]["goal"]


def test_an_error_reply_comes_with_its_details(page):
    """Field, message and value, as the simulator says them."""
    answer = page.get("_world/inject_fault", payload={"nonsense": 1})

    assert {"op", "id", "error", "details"} == answer.keys()
    assert "nonsense" == answer["details"][0]["field"]


def test_an_unserved_key_is_an_error(page):
    """A query on a key without a queryable ends at once."""
    answer = page.get("nobody/here/at/all")

    assert "nothing answers on 'nobody/here/at/all'" == answer["error"]


def test_an_answer_takes_too_long(page):
    """A page says how long it waits."""
    page.get("wall_e/wait/_action/send_goal", payload={"goal_id": "1" * 32, "goal": {"time": {"sec": 1000}}})
    answer = page.get("wall_e/wait/_action/get_result", payload={"goal_id": "1" * 32}, timeout=0.2)

    assert "no answer on 'wall_e/wait/_action/get_result' in 0.2 s" == answer["error"]


def test_all_answers_are_passed_on(page, session):
    """All queryables that match a key expression answer it."""
    for name in ("a", "b"):
        key = f"hmrsim/{name}/of/two"
        session.declare_queryable(key, lambda query, key=key: query.reply(key, json.dumps(key)))
    # The simulator is the router: when it answers, it knows what was declared before.
    session.get("hmrsim/_world/info").recv()

    replies = page.get("*/of/two")["replies"]
    assert [["a/of/two", "hmrsim/a/of/two"], ["b/of/two", "hmrsim/b/of/two"]] == sorted(replies)


@pytest.mark.parametrize(
    "key", ["/_world/scene", "_world/scene/", "a//b", "@/router", "a/@adv/**", "**/**", "a?b", "#"]
)
def test_a_malformed_key_is_refused(page, key):
    """Only key expressions below the prefix are served, and none of Zenoh's own."""
    assert repr(key) in page.get(key)["error"]
    page.say("subscribe", id=1, key=key)
    assert repr(key) in page.hear("error")["error"]


def test_other_prefixes_are_out_of_reach(page, session):
    """A page can't leave the prefix."""
    session.declare_queryable("elsewhere/a", lambda query: query.reply("elsewhere/a", '"secret"'))

    assert "error" in page.get("../elsewhere/a")


def test_a_broken_payload_does_no_harm(page, session, wait_for_listener):
    """A payload that is not JSON is left out; the frame and the next samples are valid."""
    page.say("subscribe", id=1, key="another/topic")
    wait_for_listener("hmrsim/another/topic", there=True)
    for payload in (b'{"a": ', b"\xff\xfe", b"NaN", b'"good"'):
        session.put("hmrsim/another/topic", payload)

    assert [(1, "another/topic", "good")] == page.samples(lambda payload: payload == "good")


def test_only_the_latest_of_a_key(page, session, wait_for_listener):
    """A page that wants the latest gets one sample a key and frame, the newest."""
    page.say("subscribe", id=1, key="*/number", latest=True, every=0.5)
    wait_for_listener("hmrsim/a/number", there=True)
    for number in range(100):
        session.put("hmrsim/a/number", str(number))
        session.put("hmrsim/b/number", str(-number))

    heard = page.samples(lambda payload: payload == -99)
    assert [(1, "a/number", 99), (1, "b/number", -99)] == heard[-2:]
    assert len(heard) <= 4


def test_an_ended_subscription_is_ended_on_the_network(page, wait_for_listener):
    """Nothing is published any more for a page that has unsubscribed."""
    page.say("subscribe", id=1, key="another/topic")
    wait_for_listener("hmrsim/another/topic", there=True)
    page.say("unsubscribe", id=1)

    wait_for_listener("hmrsim/another/topic", there=False)


def test_no_page_no_subscription(open_page, wait_for_listener):
    """Pages that share a key share a subscription, which ends with the last of them."""
    with open_page() as second:
        with open_page() as first:
            first.say("subscribe", id=1, key="another/topic")
            second.say("subscribe", id=5, key="another/topic")
            wait_for_listener("hmrsim/another/topic", there=True)
        second.get("_world/info")
        wait_for_listener("hmrsim/another/topic", there=True)

    wait_for_listener("hmrsim/another/topic", there=False)


def test_all_pages_hear_a_sample(open_page, session, wait_for_listener):
    """Each under the id of its own subscription."""
    with open_page() as first, open_page() as second:
        first.say("subscribe", id=1, key="another/topic")
        second.say("subscribe", id=5, key="another/topic")
        # An answer says that what was asked before is done.
        first.get("nobody")
        second.get("nobody")
        wait_for_listener("hmrsim/another/topic", there=True)
        session.put("hmrsim/another/topic", "7")

        heard = [page.samples(lambda payload: payload == 7) for page in (first, second)]
    assert [[(1, "another/topic", 7)], [(5, "another/topic", 7)]] == heard


@pytest.mark.parametrize("frame", ["", "{", "[]", '{"op": "dance"}', b"\x00", '{"op": "unsubscribe", "id": 3}'])
def test_a_malformed_frame_breaks_nothing(page, frame):
    """The page gets an error, and goes on."""
    page.send(frame)

    assert "error" in page.hear("error")
    assert "replies" in page.get("_world/info")


def test_a_huge_frame_ends_that_page_only(open_page):
    """More than 1 MiB is not read; the connection is closed, and another page is well."""
    with open_page() as first:
        first.send('{"op": "' + "x" * 2**20)
        with pytest.raises(ConnectionClosed, match="1009"):
            first.hear("never")

    with open_page() as second:
        assert "replies" in second.get("_world/info")


def test_a_page_that_goes_while_answers_wait_is_let_go(open_page, wait_for_listener):
    """The page never read an answer, so that its further requests were not served; it has no subscribers any more."""
    with open_page() as page:
        page.say("subscribe", id=1, key="another/topic")
        wait_for_listener("hmrsim/another/topic", there=True)
        for _ in range(400):
            page.send("?")
        page.vanish()

    wait_for_listener("hmrsim/another/topic", there=False)


def test_an_id_is_taken_once(page):
    """Two subscriptions can't have one id."""
    page.say("subscribe", id=1, key="a")
    page.say("subscribe", id=1, key="b")

    assert "subscription 1 exists already" == page.hear("error")["error"]


def test_subscriptions_are_counted(page):
    """A page may have 64, and gets an error for one more."""
    for id_ in range(65):
        page.say("subscribe", id=id_, key=f"key/{id_}")

    assert "there are 64 subscriptions already" == page.hear("error")["error"]


def test_gets_are_counted(page, session):
    """A page may have 64 under way, and gets an error for one more."""
    held = []
    session.declare_queryable("hmrsim/held", held.append)
    # As above.
    session.get("hmrsim/_world/info").recv()
    for id_ in range(65):
        page.say("get", id=id_, key="held", timeout=60)

    answer = page.hear("reply")
    assert (64, "64 gets are pending already") == (answer["id"], answer["error"])


def test_the_simulator_goes_and_comes_back():
    """The page gets both changes, and its subscriptions continue with the new one."""
    with ExitStack() as stack, ExitStack() as simulator:
        options = simulator.enter_context(served_world())
        page = stack.enter_context(opened(stack.enter_context(viewed(options)).url))
        page.say("subscribe", id=1, key="_world/clock")
        page.samples(lambda payload: payload["clock"]["nanosec"] > 0)
        simulator.close()
        while page.hear("alive")["alive"]:
            pass
        stack.enter_context(served_world(options=SessionOptions(listen=options.connect)))

        assert page.hear("alive")["alive"] is True
        assert page.samples(lambda payload: payload["clock"]["nanosec"] > 0)


def test_a_controller_answers_for_its_tree(page, session):
    """A wildcard reaches controllers, though the simulator, which has no trees, refuses it."""
    key = "hmrsim/wall_e/_tree"
    session.declare_queryable(key, lambda query: query.reply(key, '{"status": "RUNNING"}'))
    # As above.
    session.get("hmrsim/_world/info").recv()

    assert [["wall_e/_tree", {"status": "RUNNING"}]] == page.get("*/_tree")["replies"]

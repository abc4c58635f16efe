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


def test_the_first_frame_has_prefix_version_and_presence(page):
    hello = page.hear("hello")
    hello.pop("alive")

    assert {"op": "hello", "source": "live", "prefix": "hmrsim", "version": __version__} == hello


def test_a_key_is_queried_below_the_prefix(page):
    ((key, scene),) = page.get("_world/scene")["replies"]

    assert ("_world/scene", "wall_e") == (key, scene["robots"][0]["name"])


def test_a_page_sends_and_follows_a_goal(page):
    page.say("subscribe", id=1, key="_world/events")
    ((_, accepted),) = page.get("wall_e/wait/_action/send_goal", payload=WAIT)["replies"]
    heard = page.samples(lambda payload: payload.get("status") == 4)

    assert accepted["accepted"] is True
    mine = [payload for _, _, payload in heard if payload.get("goal_id") == accepted["goal_id"]]
    assert [None, 1, 2, 4] == [payload.get("status") for payload in mine]


def test_events_from_before_a_page_was_opened_are_kept(server, session, wait_for_listener):
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
    answer = page.get("_world/inject_fault", payload={"nonsense": 1})

    assert {"op", "id", "error", "details"} == answer.keys()
    assert "nonsense" == answer["details"][0]["field"]


def test_a_key_without_a_queryable_is_an_error(page):
    answer = page.get("nobody/here/at/all")

    assert "nothing answers on 'nobody/here/at/all'" == answer["error"]


def test_a_page_sets_the_timeout_of_its_query(page):
    page.get("wall_e/wait/_action/send_goal", payload={"goal_id": "1" * 32, "goal": {"time": {"sec": 1000}}})
    answer = page.get("wall_e/wait/_action/get_result", payload={"goal_id": "1" * 32}, timeout=0.2)

    assert "no answer on 'wall_e/wait/_action/get_result' in 0.2 s" == answer["error"]


def test_the_replies_of_all_matching_queryables_are_forwarded(page, session):
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
def test_malformed_keys_and_zenohs_own_are_refused(page, key):
    assert repr(key) in page.get(key)["error"]
    page.say("subscribe", id=1, key=key)
    assert repr(key) in page.hear("error")["error"]


def test_other_prefixes_are_out_of_reach(page, session):
    session.declare_queryable("elsewhere/a", lambda query: query.reply("elsewhere/a", '"secret"'))

    assert "error" in page.get("../elsewhere/a")


def test_a_payload_that_is_not_json_is_left_out(page, session, wait_for_listener):
    page.say("subscribe", id=1, key="another/topic")
    wait_for_listener("hmrsim/another/topic", there=True)
    for payload in (b'{"a": ', b"\xff\xfe", b"NaN", b'"good"'):
        session.put("hmrsim/another/topic", payload)

    assert [(1, "another/topic", "good")] == page.samples(lambda payload: payload == "good")


def test_a_page_can_get_only_the_latest_sample_of_a_key(page, session, wait_for_listener):
    page.say("subscribe", id=1, key="*/number", latest=True, every=0.5)
    wait_for_listener("hmrsim/a/number", there=True)
    for number in range(100):
        session.put("hmrsim/a/number", str(number))
        session.put("hmrsim/b/number", str(-number))

    heard = page.samples(lambda payload: payload == -99)
    assert [(1, "a/number", 99), (1, "b/number", -99)] == heard[-2:]
    assert len(heard) <= 4


def test_unsubscribing_undeclares_the_subscriber(page, wait_for_listener):
    page.say("subscribe", id=1, key="another/topic")
    wait_for_listener("hmrsim/another/topic", there=True)
    page.say("unsubscribe", id=1)

    wait_for_listener("hmrsim/another/topic", there=False)


def test_pages_share_a_subscriber_until_the_last_one_leaves(open_page, wait_for_listener):
    with open_page() as second:
        with open_page() as first:
            first.say("subscribe", id=1, key="another/topic")
            second.say("subscribe", id=5, key="another/topic")
            wait_for_listener("hmrsim/another/topic", there=True)
        second.get("_world/info")
        wait_for_listener("hmrsim/another/topic", there=True)

    wait_for_listener("hmrsim/another/topic", there=False)


def test_each_page_gets_a_sample_under_its_own_id(open_page, session, wait_for_listener):
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
def test_a_malformed_frame_is_an_error_and_the_page_continues(page, frame):
    page.send(frame)

    assert "error" in page.hear("error")
    assert "replies" in page.get("_world/info")


def test_a_huge_frame_closes_only_its_page(open_page):
    with open_page() as first:
        first.send('{"op": "' + "x" * 2**20)
        with pytest.raises(ConnectionClosed, match="1009"):
            first.hear("never")

    with open_page() as second:
        assert "replies" in second.get("_world/info")


def test_a_page_that_vanishes_with_unread_replies_is_removed(open_page, wait_for_listener):
    with open_page() as page:
        page.say("subscribe", id=1, key="another/topic")
        wait_for_listener("hmrsim/another/topic", there=True)
        for _ in range(400):
            page.send("?")
        page.vanish()

    wait_for_listener("hmrsim/another/topic", there=False)


def test_a_taken_subscription_id_is_refused(page):
    page.say("subscribe", id=1, key="a")
    page.say("subscribe", id=1, key="b")

    assert "subscription 1 exists already" == page.hear("error")["error"]


def test_a_page_may_have_64_subscriptions(page):
    for id_ in range(65):
        page.say("subscribe", id=id_, key=f"key/{id_}")

    assert "there are 64 subscriptions already" == page.hear("error")["error"]


def test_a_page_may_have_64_open_queries(page, session):
    held = []
    session.declare_queryable("hmrsim/held", held.append)
    # As above.
    session.get("hmrsim/_world/info").recv()
    for id_ in range(65):
        page.say("get", id=id_, key="held", timeout=60)

    answer = page.hear("reply")
    assert (64, "64 gets are pending already") == (answer["id"], answer["error"])


def test_subscriptions_continue_with_a_restarted_simulator():
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


def test_a_wildcard_query_reaches_controllers(page, session):
    key = "hmrsim/wall_e/_tree"
    session.declare_queryable(key, lambda query: query.reply(key, '{"status": "RUNNING"}'))
    # As above.
    session.get("hmrsim/_world/info").recv()

    assert [["wall_e/_tree", {"status": "RUNNING"}]] == page.get("*/_tree")["replies"]

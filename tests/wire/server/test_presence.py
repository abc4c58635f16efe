"""Presence on the network: liveliness tokens, a second simulator, and a taken port."""

from __future__ import annotations

import pytest
import zenoh

from hmrsim_zenoh.errors import PrefixTaken
from hmrsim_zenoh.wire.session import SessionOptions
from tests.wire.server.conftest import Heard

TOKENS = {"hmrsim/_world/alive", "hmrsim/wall_e/alive", "hmrsim/eve/alive", "hmrsim/cart/alive"}


def watch(tester):
    heard = Heard()
    handler = zenoh.handlers.Callback(heard.on_sample, indirect=False)
    heard.subscriber = tester.session.liveliness().declare_subscriber("hmrsim/*/alive", handler, history=True)
    return heard


def test_the_simulator_and_each_robot_have_a_token(shared):
    tokens = {str(reply.ok.key_expr) for reply in shared.session.liveliness().get("hmrsim/**")}

    assert tokens == TOKENS


def test_the_tokens_disappear_when_the_simulator_stops(serve):
    router = serve.host({"robots": {}}, SessionOptions(listen=("tcp/127.0.0.1:0",), prefix="router"))
    host = serve.host(None, SessionOptions(connect=router.endpoints), real_time_factor=0)
    host.start()
    heard = watch(serve.tester(router))
    heard.wait(lambda bodies: len(bodies) == 4)

    host.stop()

    heard.wait(lambda bodies: len(bodies) == 8)
    assert TOKENS == {item.key for item in heard.items[:4]} == {item.key for item in heard.items[4:]}
    assert [True] * 4 + [False] * 4 == [item.ok for item in heard.items]


def test_a_second_simulator_with_the_same_prefix_refuses_to_start(serve):
    tester = serve(real_time_factor=0)

    with pytest.raises(PrefixTaken) as caught:
        serve.host(None, SessionOptions(connect=(tester.endpoint,)))

    assert str(caught.value) == (
        f"another simulator serves prefix 'hmrsim', found by connecting to {tester.endpoint} (--connect or "
        "HMRSIM_CONNECT); don't connect there, or give another prefix with --prefix"
    )
    assert 1 == tester.one("_world/info")["contract"]


def test_simulators_with_different_prefixes_do_not_interfere(serve, wait):
    tester = serve(real_time_factor=0)
    other = serve.host(None, SessionOptions(connect=(tester.endpoint,), prefix="lab/two"), real_time_factor=0)
    other.start()
    second = serve.tester(serve.hosts[0], prefix="lab/two")

    assert 4 == second.do("wall_e/wait", wait(3))["status"]
    assert [1, 0] == [len(client.status("wall_e/wait")) for client in (second, tester)]


def test_a_prefix_and_port_are_free_when_the_simulator_has_stopped(serve):
    tester = serve(real_time_factor=0)
    tester.close()
    serve.hosts[0].stop()

    host = serve.host(None, SessionOptions(listen=(tester.endpoint,)), real_time_factor=0)
    host.start()

    assert 1 == serve.tester(host).one("_world/info")["contract"]

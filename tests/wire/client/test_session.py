"""Opening sessions: it works, or it says in one line why not."""

from __future__ import annotations

import socket
import threading
from typing import TYPE_CHECKING

import pytest

from hmrsim_zenoh.errors import BadOptions, PortTaken, SimulatorNotFound
from hmrsim_zenoh.wire.session import SessionOptions, open_client, open_server
from tests.patience import PATIENCE

if TYPE_CHECKING:
    from pathlib import Path

ANY_PORT = ("tcp/127.0.0.1:0",)


@pytest.fixture
def free_endpoint():
    """Return an endpoint on which no process listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def test_port_zero_becomes_a_real_one():
    """The endpoint that is returned is one that a client can connect to."""
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    with server, open_client(SessionOptions(connect=(endpoint,))) as client:
        assert server.zid() in client.info.routers_zid()


def test_port_zero_works_for_ipv6():
    """An IPv6 address keeps its brackets."""
    server, (endpoint,) = open_server(SessionOptions(listen=("tcp/[::1]:0",)))
    with server, open_client(SessionOptions(connect=(endpoint,))):
        assert endpoint.startswith("tcp/[::1]:")


def test_no_simulator_is_said_within_the_timeout(free_endpoint):
    """Without a listener at the endpoint the timeout holds, and the error names the endpoint."""
    with pytest.raises(SimulatorNotFound, match=f"no answer from {free_endpoint}; start `hmrsim run WORLD`"):
        open_client(SessionOptions(connect=(free_endpoint,), timeout=0.3))


def test_a_client_waits_for_a_simulator_that_starts_late(free_endpoint):
    """The start order does not matter, within the timeout."""
    sessions = []
    thread = threading.Thread(
        target=lambda: sessions.append(open_client(SessionOptions(connect=(free_endpoint,), timeout=PATIENCE)))
    )
    thread.start()
    server, _ = open_server(SessionOptions(listen=(free_endpoint,)))
    with server:
        thread.join(PATIENCE)

        assert len(sessions) == 1
        sessions[0].close()


@pytest.fixture
def mute_endpoint():
    """Return an endpoint that accepts connections and never sends a word."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        yield f"tcp/127.0.0.1:{mute.getsockname()[1]}"


@pytest.mark.parametrize("mode", ["client", "peer"])
@pytest.mark.parametrize("before", ["free_endpoint", "mute_endpoint"])
@pytest.mark.parametrize("live_is_first", [False, True])
def test_one_live_endpoint_is_enough(request, mode, before, live_is_first):
    """An endpoint that does not answer hides no other one, whatever the order."""
    server, (live,) = open_server(SessionOptions(listen=ANY_PORT))
    silent = request.getfixturevalue(before)
    connect = (live, silent) if live_is_first else (silent, live)

    with server, open_client(SessionOptions(connect=connect, mode=mode, timeout=PATIENCE)) as client:
        assert [server.zid()] == client.info.routers_zid()


@pytest.mark.parametrize("mode", ["client", "peer"])
def test_no_simulator_at_several_endpoints_is_said_within_the_timeout(free_endpoint, mute_endpoint, mode):
    """The error names all endpoints."""
    with pytest.raises(SimulatorNotFound, match=f"no answer from {mute_endpoint}, {free_endpoint}; start"):
        open_client(SessionOptions(connect=(mute_endpoint, free_endpoint), mode=mode, timeout=0.6))


def test_a_client_of_several_waits_for_one_that_starts_late(free_endpoint, mute_endpoint):
    """All endpoints are tried again until the timeout."""
    sessions = []
    options = SessionOptions(connect=(mute_endpoint, free_endpoint), timeout=PATIENCE)
    thread = threading.Thread(target=lambda: sessions.append(open_client(options)))
    thread.start()
    thread.join(0.3)
    server, _ = open_server(SessionOptions(listen=(free_endpoint,)))
    with server:
        thread.join(PATIENCE)

        assert len(sessions) == 1
        sessions[0].close()


def test_a_taken_port_is_named():
    """The error of a second simulator on the same port names the port, and the options that help."""
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    with server, pytest.raises(PortTaken, match=rf"{endpoint} is in use.*--listen.*--connect"):
        open_server(SessionOptions(listen=(endpoint,)))


def test_a_simulator_that_connects_does_not_listen():
    """With an endpoint to connect to and none to listen on, the simulator accepts no connections."""
    router, endpoints = open_server(SessionOptions(listen=ANY_PORT))
    with router:
        simulator, listening = open_server(SessionOptions(connect=endpoints))
        with simulator:
            assert (listening, simulator.info.routers_zid()) == ((), [router.zid()])


def test_a_simulator_that_only_connects_needs_a_router(free_endpoint):
    """The simulator gives up after the timeout, too."""
    with pytest.raises(SimulatorNotFound, match=r"no answer from .*; start a Zenoh router"):
        open_server(SessionOptions(connect=(free_endpoint,), timeout=0.2))


def test_a_tool_can_listen():
    """A tool that listens is found by a simulator that connects to it."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    with open_client(SessionOptions(listen=(endpoint,))) as tool:
        simulator, _ = open_server(SessionOptions(connect=(endpoint,)))
        with simulator:
            assert tool.zid() in simulator.info.peers_zid()


@pytest.mark.parametrize(
    ("endpoint", "message"),
    [
        ("garbage", "'garbage' is not an endpoint"),
        ("", "'' is not an endpoint"),
        ("tcp/", "'tcp/' is not an endpoint"),
        ("carrier-pigeon/127.0.0.1:7447", "no protocol 'carrier-pigeon'"),
        ("tcp/127.0.0.1", "'127.0.0.1' is not HOST:PORT"),
        ("tcp/127.0.0.1:99999", "not HOST:PORT with a port of 1 to 65535"),
        ("tcp/127.0.0.1:0", "not HOST:PORT with a port of 1 to 65535"),
        ("tcp/::1:7447", "not HOST:PORT"),
    ],
)
def test_a_malformed_endpoint_is_refused_at_once(endpoint, message):
    """It names the value and what would do; Zenoh would try in vain until the timeout."""
    with pytest.raises(BadOptions, match=message):
        open_client(SessionOptions(connect=(endpoint,), timeout=PATIENCE))


def test_an_address_that_is_not_ours_is_refused():
    """Listening on another host's address is not reported as a taken port."""
    with pytest.raises(BadOptions, match=r"192.0.2.1:7447.*[Cc]an.*ot assign"):
        open_server(SessionOptions(listen=("tcp/192.0.2.1:7447",)))


def test_a_client_can_not_listen():
    """Zenoh would ignore it silently."""
    with pytest.raises(BadOptions, match=r"mode 'client' can't listen on tcp/127.0.0.1:0"):
        open_client(SessionOptions(listen=ANY_PORT, mode="client"))


def test_an_unknown_mode_is_refused():
    """It comes from an environment variable, say."""
    with pytest.raises(BadOptions, match=r"'klient'.*expected one of `router`, `peer`, `client`"):
        open_client(SessionOptions(mode="klient"))  # type: ignore[arg-type]


def test_a_timeout_must_be_positive():
    """Zero would mean no try at all, to Zenoh."""
    with pytest.raises(BadOptions, match="--timeout must be positive, got 0 s"):
        open_client(SessionOptions(timeout=0))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("missing.json5", None, "No such file"),
        ("broken.json5", "{mode: }", "not a Zenoh configuration"),
        ("unknown.json5", "{no_such_field: 1}", "no_such_field"),
        ("mode.json5", '{mode: "klient"}', "klient"),
        ("file.txt", "{}", "Unsupported file type"),
        ("endpoint.json5", '{connect: {endpoints: ["garbage"]}}', "garbage"),
    ],
)
def test_a_bad_configuration_file_is_named(tmp_path: Path, name, text, message):
    """The error has the file and what is wrong, in one line."""
    file = tmp_path / name
    if text is not None:
        file.write_text(text)

    with pytest.raises(
        BadOptions, match=rf"{name}: not a Zenoh configuration: .*{message}|{name}: {message}"
    ) as caught:
        open_client(SessionOptions(zenoh_config=file))

    assert "\n" not in str(caught.value)


def test_a_configuration_file_says_where_to_connect(tmp_path: Path):
    """What the options leave open is the file's."""
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    file = tmp_path / "zenoh.json5"
    file.write_text(f'{{mode: "client", connect: {{endpoints: ["{endpoint}"]}}}}')
    with server, open_client(SessionOptions(zenoh_config=file)) as client:
        assert client.info.routers_zid() == [server.zid()]


def test_options_come_before_the_configuration_file(tmp_path: Path, free_endpoint):
    """An endpoint on the command line replaces the file's."""
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    file = tmp_path / "zenoh.json5"
    file.write_text(f'{{connect: {{endpoints: ["{free_endpoint}"]}}}}')
    with server, open_client(SessionOptions(zenoh_config=file, connect=(endpoint,))) as client:
        assert client.info.routers_zid() == [server.zid()]

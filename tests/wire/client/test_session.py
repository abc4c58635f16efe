"""Opening sessions, and errors in one line when that fails."""

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


def test_port_zero_is_replaced_by_a_free_one():
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    with server, open_client(SessionOptions(connect=(endpoint,))) as client:
        assert server.zid() in client.info.routers_zid()


def test_port_zero_keeps_the_brackets_of_ipv6():
    server, (endpoint,) = open_server(SessionOptions(listen=("tcp/[::1]:0",)))
    with server, open_client(SessionOptions(connect=(endpoint,))):
        assert endpoint.startswith("tcp/[::1]:")


def test_no_simulator_is_an_error_within_the_timeout(free_endpoint):
    with pytest.raises(SimulatorNotFound, match=f"no answer from {free_endpoint}; start `hmrsim run WORLD`"):
        open_client(SessionOptions(connect=(free_endpoint,), timeout=0.3))


def test_a_client_waits_for_a_simulator_that_starts_late(free_endpoint):
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
    """Return an endpoint that accepts connections and never sends anything."""
    with socket.create_server(("127.0.0.1", 0)) as mute:
        yield f"tcp/127.0.0.1:{mute.getsockname()[1]}"


@pytest.mark.parametrize("mode", ["client", "peer"])
@pytest.mark.parametrize("before", ["free_endpoint", "mute_endpoint"])
@pytest.mark.parametrize("live_is_first", [False, True])
def test_one_live_endpoint_is_enough(request, mode, before, live_is_first):
    """The order of live and mute endpoints does not matter."""
    server, (live,) = open_server(SessionOptions(listen=ANY_PORT))
    silent = request.getfixturevalue(before)
    connect = (live, silent) if live_is_first else (silent, live)

    with server, open_client(SessionOptions(connect=connect, mode=mode, timeout=PATIENCE)) as client:
        assert [server.zid()] == client.info.routers_zid()


@pytest.mark.parametrize("mode", ["client", "peer"])
def test_no_simulator_at_several_endpoints_names_all_of_them(free_endpoint, mute_endpoint, mode):
    with pytest.raises(SimulatorNotFound, match=f"no answer from {mute_endpoint}, {free_endpoint}; start"):
        open_client(SessionOptions(connect=(mute_endpoint, free_endpoint), mode=mode, timeout=0.6))


def test_a_client_of_several_endpoints_waits_for_one_that_starts_late(free_endpoint, mute_endpoint):
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


def test_a_taken_port_is_named_with_the_options_that_help():
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    with server, pytest.raises(PortTaken, match=rf"{endpoint} is in use.*--listen.*--connect"):
        open_server(SessionOptions(listen=(endpoint,)))


def test_a_simulator_that_connects_does_not_listen():
    router, endpoints = open_server(SessionOptions(listen=ANY_PORT))
    with router:
        simulator, listening = open_server(SessionOptions(connect=endpoints))
        with simulator:
            assert (listening, simulator.info.routers_zid()) == ((), [router.zid()])


def test_a_simulator_that_finds_no_router_gives_up(free_endpoint):
    with pytest.raises(SimulatorNotFound, match=r"no answer from .*; start a Zenoh router"):
        open_server(SessionOptions(connect=(free_endpoint,), timeout=0.2))


def test_a_tool_can_listen():
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
    """Zenoh would try in vain until the timeout."""
    with pytest.raises(BadOptions, match=message):
        open_client(SessionOptions(connect=(endpoint,), timeout=PATIENCE))


def test_another_hosts_address_is_not_reported_as_a_taken_port():
    with pytest.raises(BadOptions, match=r"192.0.2.1:7447.*[Cc]an.*ot assign"):
        open_server(SessionOptions(listen=("tcp/192.0.2.1:7447",)))


def test_a_client_can_not_listen():
    """Zenoh would ignore the option silently."""
    with pytest.raises(BadOptions, match=r"mode 'client' can't listen on tcp/127.0.0.1:0"):
        open_client(SessionOptions(listen=ANY_PORT, mode="client"))


def test_an_unknown_mode_is_refused():
    with pytest.raises(BadOptions, match=r"'klient'.*expected one of `router`, `peer`, `client`"):
        open_client(SessionOptions(mode="klient"))  # type: ignore[arg-type]


def test_a_timeout_must_be_positive():
    """Zenoh would make no attempt with a timeout of zero."""
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
    file = tmp_path / name
    if text is not None:
        file.write_text(text)

    with pytest.raises(
        BadOptions, match=rf"{name}: not a Zenoh configuration: .*{message}|{name}: {message}"
    ) as caught:
        open_client(SessionOptions(zenoh_config=file))

    assert "\n" not in str(caught.value)


def test_a_configuration_file_can_give_the_endpoint(tmp_path: Path):
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    file = tmp_path / "zenoh.json5"
    file.write_text(f'{{mode: "client", connect: {{endpoints: ["{endpoint}"]}}}}')
    with server, open_client(SessionOptions(zenoh_config=file)) as client:
        assert client.info.routers_zid() == [server.zid()]


def test_options_override_the_configuration_file(tmp_path: Path, free_endpoint):
    server, (endpoint,) = open_server(SessionOptions(listen=ANY_PORT))
    file = tmp_path / "zenoh.json5"
    file.write_text(f'{{connect: {{endpoints: ["{free_endpoint}"]}}}}')
    with server, open_client(SessionOptions(zenoh_config=file, connect=(endpoint,))) as client:
        assert client.info.routers_zid() == [server.zid()]

"""``hmrsim view`` and ``hmrsim run --view``, as processes."""

from __future__ import annotations

import json
import signal
import socket

import pytest

from hmrsim.cli import main
from tests import processes
from tests.wire.view.pages import fetched, opened


@pytest.fixture
def start():
    """Return the function that starts hmrsim as a process, which is killed at the end of the test."""
    with processes.killed_at_the_end() as run:
        yield run


@pytest.fixture
def taken():
    """Return a port that is in use."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield str(server.getsockname()[1])


def test_no_simulator_exits_with_3(capsys):
    code = main(["view", "--port", "0", "--connect", "tcp/127.0.0.1:1", "--timeout", "0.3"])

    assert 3 == code
    assert "hmrsim run WORLD" in capsys.readouterr().err


def test_a_simulator_of_another_prefix_exits_with_3(simulator, capsys):
    code = main(["view", "--port", "0", "--connect", *simulator.connect, "--prefix", "other", "--timeout", "0.3"])

    assert 3 == code
    assert "'other/_world/alive'" in capsys.readouterr().err


def test_a_taken_port_exits_with_2(simulator, taken, capsys):
    code = main(["view", "--port", taken, "--connect", *simulator.connect])

    assert 2 == code
    assert (
        f"hmrsim: 127.0.0.1:{taken} is in use; give another with --port, 0 for a free one\n" == capsys.readouterr().err
    )


def test_a_malformed_port_exits_with_2(capsys):
    code = main(["view", "--port", "70000"])

    assert 2 == code
    assert "'70000' is not a port; expected a whole number from 0 to 65535" in capsys.readouterr().err


@pytest.mark.parametrize("content", [None, b"", b"no recording\n"])
def test_a_file_that_is_not_a_recording_exits_with_2(tmp_path, content, capsys):
    path = tmp_path / "shift.mcap"
    if content is not None:
        path.write_bytes(content)
    code = main(["view", str(path), "--port", "0"])

    complaint = capsys.readouterr().err
    assert 2 == code
    assert (1, True) == (len(complaint.splitlines()), str(path) in complaint)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_with_an_open_page_exits_with_0_silently(start, simulator, number):
    process = start("view", "--port", "0", "--connect", *simulator.connect)
    word, url = process.stdout.readline().split()
    with opened(url) as page:
        page.get("_world/info")
        process.send_signal(number)
        out, err = process.communicate()

    assert ("ready", 0, "", "") == (word, process.returncode, out, err)


def test_ready_as_json(start, simulator):
    process = start("view", "--port", "0", "--json", "--connect", *simulator.connect)
    ready = json.loads(process.stdout.readline())

    assert ready["ready"] is True
    assert 200 == fetched(ready["url"], "/source")[0]


def test_the_page_of_a_run_is_ready_and_ends_with_it(start):
    process = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0", "--view", "0", "--json")
    url = json.loads(process.stdout.readline())["view"]
    with opened(url) as page:
        seen = page.get("_world/info")["replies"][0][1]["world"]["name"]
        process.terminate()
        _, err = process.communicate()

    assert ("scenario 1", 0, True) == (seen, process.returncode, url in err)
    with pytest.raises(OSError, match="refused"):
        fetched(url, "/source")


def test_a_taken_port_of_the_page_ends_the_run_at_once(start, taken):
    process = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0", "--view", taken, "--log-level", "error")
    out, err = process.communicate()

    assert (2, "") == (process.returncode, out)
    assert f"hmrsim: --view: 127.0.0.1:{taken} is taken; name another with --view, 0 for a free one\n" == err

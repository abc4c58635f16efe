"""``run --record`` and ``hmrsim record``, as processes."""

from __future__ import annotations

import json
import signal
import struct
from contextlib import suppress

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader, breakup_chunk

from hmrsim.actions import registry
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.recording import Recording
from hmrsim_zenoh.wire.session import SessionOptions
from tests.patience import PATIENCE

FREE_PORT = ("--listen", "tcp/127.0.0.1:0")
WALL_E = {"pose": {"pose": {"position": {"x": 512.0, "y": 215.0}}}}


@pytest.fixture
def simulator(start):
    """Return the function that starts a simulator and returns the process and its endpoint."""

    def run(*arguments, world="scenario1"):
        process = start("run", world, *FREE_PORT, *arguments)
        return process, process.stdout.readline().split()[1]

    return run


@pytest.fixture
def recorder(start):
    """Return the function that starts a recorder and waits until it records."""

    def run(path, endpoint, *arguments):
        process = start("record", path, "--connect", endpoint, *arguments)
        assert process.stderr.readline() == f"recording to {path}\n"
        return process

    return run


def end(process, number=None):
    """Send a signal if one is given, wait for the end, and return exit code, output and errors."""
    if number is not None:
        process.send_signal(number)
    out, err = process.communicate()
    return process.returncode, out, err


def drive(client):
    """Drive wall_e somewhere, as far as it gets."""
    goal = NavigateToPose.Goal.model_validate(WALL_E)
    client.action_client("wall_e", registry()["navigate_to_pose"]).send_goal(goal).result(PATIENCE)


def connected(endpoint, **options):
    return Client(SessionOptions(connect=(endpoint,)), **options)


def statuses(path):
    """Return time and bytes of all status lists."""
    with path.open("rb") as file:
        read = make_reader(file).iter_messages()
        return [(one.log_time, one.data) for _, channel, one in read if channel.topic.endswith("/status")]


def chunks(path):
    """Yield the chunks of a possibly truncated file, as mcap's reader finds them."""
    with path.open("rb") as file, suppress(McapError, struct.error):
        yield from (one for one in StreamReader(file, emit_chunks=True).records if isinstance(one, Chunk))


def channels(path):
    """Return encoding, type and definition of each channel."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    schemas = summary.schemas
    return {
        one.topic: (one.message_encoding, schemas[one.schema_id].name, schemas[one.schema_id].data, one.metadata)
        for one in summary.channels.values()
    }


def test_recordings_of_the_simulator_and_over_the_network_agree(simulator, recorder, tmp_path):
    inside, outside = tmp_path / "inside.mcap", tmp_path / "outside.mcap"
    process, endpoint = simulator("--real-time-factor", "10", "--record", inside)
    listening = recorder(outside, endpoint)
    with connected(endpoint) as client:
        drive(client)
        client.sleep(1.0)
    code, _, _ = end(listening, signal.SIGINT)
    end(process, signal.SIGTERM)

    assert 0 == code
    assert list(Recording(inside).events()) == list(Recording(outside).events())
    assert statuses(inside) == statuses(outside)
    assert channels(inside) == channels(outside)


def test_lockstep_makes_the_same_file_twice(simulator, tmp_path):
    """The files are equal although messages arrive over the network at other times."""
    paths = [tmp_path / "one.mcap", tmp_path / "two.mcap"]
    for path in paths:
        process, endpoint = simulator("--clock", "lockstep", "--record", path)
        with connected(endpoint, clock="lockstep") as client:
            drive(client)
            client.sleep(20.0)
        end(process, signal.SIGTERM)

    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert 20_000_000_000 <= Recording(paths[0]).end


def test_a_recording_is_readable_after_a_kill(simulator, tmp_path):
    path = tmp_path / "killed.mcap"
    process, endpoint = simulator("--real-time-factor", "10", "--record", path)
    with connected(endpoint) as client:
        client.sleep(60.0)
    end(process, signal.SIGKILL)
    recording = Recording(path)
    whole = [one for chunk in chunks(path) for one in breakup_chunk(chunk, validate_crc=True)]

    assert recording.truncated
    assert 20_000_000_000 < recording.end == whole[-1].log_time


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_recording_with_its_index(simulator, recorder, tmp_path, number):
    path = tmp_path / "run.mcap"
    _, endpoint = simulator("--real-time-factor", "10")
    process = recorder(path, endpoint, "--json")
    code, out, _ = end(process, number)
    said = json.loads(out)
    with path.open("rb") as file:
        counted = make_reader(file).get_summary().statistics.message_count

    assert (0, counted, path.stat().st_size, 0) == (code, said["messages"], said["bytes"], said["lost"])
    assert not Recording(path).truncated


def test_a_deleted_recording_is_reported_in_one_line(simulator, tmp_path):
    path = tmp_path / "folder" / "run.mcap"
    path.parent.mkdir()
    process, _ = simulator("--record", path)
    path.unlink()
    path.parent.rmdir()
    code, _, err = end(process, signal.SIGTERM)

    assert (0, True) == (code, f"but {path} is no longer there" in err)
    assert "Traceback" not in err


def test_a_recording_ends_after_its_duration(simulator, recorder, tmp_path):
    path = tmp_path / "run.mcap"
    _, endpoint = simulator("--real-time-factor", "10")
    code, _, err = end(recorder(path, endpoint, "--duration", "5"))
    recording = Recording(path)

    assert 0 == code
    assert pytest.approx(5.0, abs=0.2) == (recording.end - recording.begin) / 1e9
    assert err.endswith(f"in {path}\n")
    assert any(f"recorded {seconds} s: " in err for seconds in ("5.0", "5.1"))


def test_the_recorder_ends_with_the_simulator(simulator, recorder, tmp_path):
    path = tmp_path / "run.mcap"
    process, endpoint = simulator("--real-time-factor", "10")
    listening = recorder(path, endpoint)
    end(process, signal.SIGKILL)
    code, _, err = end(listening)

    assert (0, "the simulator is gone") == (code, err.splitlines()[0])
    assert not Recording(path).truncated


def test_a_restarted_simulator_is_recorded_after_a_mark(simulator, recorder, start, tmp_path):
    path = tmp_path / "run.mcap"
    process, endpoint = simulator("--real-time-factor", "10")
    listening = recorder(path, endpoint)
    with connected(endpoint) as client:
        client.sleep(10.0)
    end(process, signal.SIGKILL)
    again = start("run", "scenario1", "--listen", endpoint, "--real-time-factor", "10")
    again.stdout.readline()
    with connected(endpoint) as client:
        client.sleep(30.0)
        drive(client)
    end(listening, signal.SIGINT)
    kinds = [event["kind"] for event in Recording(path).events()]
    worlds = [time for time, key, _ in Recording(path).samples() if key == "_world/world"]

    assert ["simulator_returned", "goal"] == [kind for kind in kinds if kind in ("simulator_returned", "goal")]
    assert 2 == len(worlds)
    assert 5_000_000_000 < worlds[1] - worlds[0]


def test_without_a_simulator_the_recorder_exits_with_3_and_leaves_no_file(start, tmp_path):
    path = tmp_path / "run.mcap"
    code, _, err = end(start("record", path, "--connect", "tcp/127.0.0.1:1", "--timeout", "0.5"))

    assert (3, 1) == (code, len(err.splitlines()))
    assert not path.exists()


def test_an_unwritable_file_exits_with_2_before_serving(start, tmp_path):
    code, out, err = end(start("run", "scenario1", *FREE_PORT, "--record", tmp_path))

    assert (2, "", f"hmrsim: {tmp_path}: can't be written: is a directory\n") == (code, out, err)


def test_a_full_disk_exits_with_1_and_one_line(start):
    code, _, err = end(start("run", "scenario1", *FREE_PORT, "--record", "/dev/full", "--log-level", "error"))

    assert 1 == code
    # Which comes first, the disk's error or the news that the simulator is ready, is a matter of chance.
    told = [line for line in err.splitlines() if line != "recording to /dev/full"]
    assert ["hmrsim: /dev/full: can't be written: no space left on device"] == told

"""Reading of complete, truncated, damaged, foreign and malicious recordings."""

from __future__ import annotations

import io
import json
import random
import struct
from collections import Counter

import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from hmrsim.errors import RecordingError
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import SendGoal
from hmrsim_zenoh.recording import Recording
from hmrsim_zenoh.recording.reader import MAX_UNPACKED, Budget, records, unpacked
from tests.calls import calls_of
from tests.simulation import SMALL_WORLD
from tests.unit.hmrsim_zenoh.recording.conftest import record_to


def wait(at):
    """Return a command and its time: a goal that takes one second."""
    return at, SendGoal("wall_e", "wait", Wait.Goal.model_validate({"time": {"sec": 1}}), None)


@pytest.fixture(scope="module")
def minute(tmp_path_factory):
    """Return the bytes of a recording of a minute, with a goal every 2 s."""
    path = tmp_path_factory.mktemp("minute") / "run.mcap"
    return record_to(path, *(wait(float(at)) for at in range(0, 60, 2)), until=60.0).read_bytes()


@pytest.fixture
def path(minute, tmp_path):
    """Return a recording of a minute, with a goal every 2 s."""
    path = tmp_path / "run.mcap"
    path.write_bytes(minute)
    return path


def chunks(path):
    return [
        one for one in StreamReader(io.BytesIO(path.read_bytes()), emit_chunks=True).records if isinstance(one, Chunk)
    ]


def written(path, topics, **options):
    """Write a recording like another tool: one message for each topic, at 7 ns."""
    with path.open("wb") as file:
        writer = Writer(file, **options)
        writer.start()
        schema = writer.register_schema("any", "jsonschema", b"{}")
        for topic, data in topics.items():
            writer.add_message(writer.register_channel(topic, "json", schema), 7, data, 7)
        writer.finish()
    return path


def test_a_complete_recording_says_so(path):
    recording = Recording(path)

    assert (1, 60_000_000_000, False) == (recording.begin, recording.end, recording.truncated)


def test_the_world_is_as_in_its_file(path):
    recording = Recording(path)

    assert SMALL_WORLD["lanes"][0] == recording.world["lanes"][0]
    assert "small" == recording.info["world"]["name"]


def test_events_come_in_order(path):
    kinds = Counter(event["kind"] for event in Recording(path).events())

    assert {"goal": 30, "status": 90} == kinds


def test_samples_are_what_the_page_needs(path):
    samples = list(Recording(path).samples())

    assert ["_world/world", "_world/info", "_world/scene", "_world/events"] == [key for _, key, _ in samples[:4]]
    assert [time for time, _, _ in samples] == sorted(time for time, _, _ in samples)


def test_batteries_are_among_the_samples(record):
    world = {**SMALL_WORLD, "robot_types": {"nurse": {"components": {"battery": {"capacity": 100.0}}}}}
    samples = Recording(record(until=1.0, world=world)).samples()
    (level,) = (state["percentage"] for _, key, state in samples if key == "eve/battery_state")

    assert pytest.approx(0.99) == level


def test_what_was_cut_off_can_be_read_up_to_there(path):
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    recording = Recording(path)

    assert recording.truncated
    assert 60 < sum(1 for _ in recording.events()) < 120


def test_a_damaged_chunk_costs_its_own_messages(path):
    data, damaged = path.read_bytes(), chunks(path)[5].data
    path.write_bytes(data.replace(damaged, bytes(len(damaged))))
    recording = Recording(path)
    times = [event["stamp"]["sec"] for event in recording.events()]

    assert recording.truncated
    assert (0, 59) == (times[0], times[-1])


def test_a_text_is_not_a_recording(tmp_path):
    path = tmp_path / "notes.mcap"
    path.write_text("not much")

    with pytest.raises(RecordingError, match=r"notes\.mcap: not a recording: not an MCAP file"):
        Recording(path)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RecordingError, match=r"none\.mcap: can't be read: no such file or directory"):
        Recording(tmp_path / "none.mcap")


def test_others_recordings_lack_our_events(tmp_path):
    path = written(tmp_path / "other.mcap", {"/chatter": b"{}"})

    with pytest.raises(RecordingError, match=r"there are no messages on /_world/events; make one with `hmrsim run"):
        Recording(path)


def test_a_recording_without_a_world_says_so(tmp_path):
    path = written(tmp_path / "events.mcap", {"/_world/events": b"{}"})

    with pytest.raises(RecordingError, match="there are no messages on /_world/world"):
        Recording(path)


@pytest.mark.parametrize("compression", CompressionType)
def test_it_may_have_been_packed_anew(tmp_path, compression):
    """Other tools, such as `mcap`, may drop our metadata and use another compression."""
    event = {"kind": "reset", "stamp": {"sec": 0, "nanosec": 7}}
    topics = {"/_world/world": b"{}", "/_world/info": b"{}", "/_world/events": json.dumps(event).encode()}
    path = written(tmp_path / "again.mcap", topics, compression=compression)

    assert [event] == list(Recording(path).events())


def test_it_may_have_no_chunks(tmp_path):
    topics = {
        "/_world/world": b"{}",
        "/_world/info": b"{}",
        "/_world/events": b'{"kind":"a","stamp":{"sec":0,"nanosec":7}}',
    }
    path = written(tmp_path / "plain.mcap", topics, use_chunking=False)

    assert ["a"] == [event["kind"] for event in Recording(path).events()]


@pytest.mark.parametrize("data", [b"[1]", b"{", b"[" * 100_000, b'{"kind":"a"}'])
def test_an_event_that_is_none_is_named(tmp_path, data):
    path = written(tmp_path / "bad.mcap", {"/_world/world": b"{}", "/_world/info": b"{}", "/_world/events": data})

    with pytest.raises(RecordingError, match=r"bad\.mcap: /_world/events at 0\.000 s: not "):
        list(Recording(path).events())


@pytest.mark.parametrize(("topic", "most"), [("/_world/world", 5_000_000), ("/_world/info", 1_000_000)])
def test_a_message_of_too_many_values_is_not_parsed(tmp_path, topic, most):
    """A few megabytes of JSON text could take a gigabyte as values."""
    topics = {"/_world/world": b"{}", "/_world/info": b"{}", "/_world/events": b"{}"}
    path = written(tmp_path / "many.mcap", {**topics, topic: b'{"x":[' + b"0," * most + b"0]}"})

    with pytest.raises(RecordingError, match=rf"many\.mcap: {topic} at 0\.000 s: more than {most} values$"):
        Recording(path)


@pytest.mark.parametrize("claimed", [10, 1 << 27, 1 << 60])
def test_a_bomb_is_not_unpacked(claimed):
    """128 MiB of zeros are rejected, for any claimed size."""
    packer = zstandard.ZstdCompressor().compressobj(size=1 << 27)
    data = b"".join(packer.compress(bytes(1 << 20)) for _ in range(1 << 7)) + packer.flush()

    with pytest.raises(ValueError, match="a chunk of"):
        list(unpacked(Chunk("zstd", data, 0, 0, 0, claimed), Budget(1 << 30)))


class _Small(io.BytesIO):
    """A file that fails for reads of more than a mebibyte."""

    def read(self, size=-1, /):
        """Read, or raise a MemoryError."""
        if size > 1 << 20:
            raise MemoryError
        return super().read(size)


def test_a_text_that_claims_four_gigabytes_ends_the_file():
    """A claimed size beyond the memory ends reading; earlier records count."""
    header = b"\1" + (8).to_bytes(8, "little") + bytes(8)
    schema = b"\3" + (8).to_bytes(8, "little") + bytes(2) + b"\xff\xff\xff\xff" + bytes(2)

    assert ["Header"] == [type(one).__name__ for one in records(_Small(MCAP0_MAGIC + header + schema), 1 << 20)]


def test_a_record_longer_than_its_chunk_is_none():
    """The record ends the chunk."""
    data = b"\5" + (1 << 62).to_bytes(8, "little")

    with pytest.raises(ValueError, match="longer than its chunk"):
        list(unpacked(Chunk("", data, 0, 0, 0, len(data)), Budget(1 << 30)))


def test_our_chunks_are_far_from_the_limit(path):
    """Chunks have a mebibyte and at most one message more."""
    assert max(chunk.uncompressed_size for chunk in chunks(path)) < MAX_UNPACKED // 8


def _record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def _packed(data: bytes) -> bytes:
    """Return a chunk, compressed."""
    packed = zstandard.ZstdCompressor(level=19).compress(data)
    head = struct.pack("<QQQI", 0, 10, len(data), 0) + struct.pack("<I", 4) + b"zstd"
    return _record(Opcode.CHUNK, head + struct.pack("<Q", len(packed)) + packed)


_TINY = _record(Opcode.MESSAGE, struct.pack("<HIQQ", 999, 0, 5, 5))


@pytest.mark.uncovered
@pytest.mark.parametrize(
    ("chunk", "error"),
    [
        (_TINY * 20_000, "it has more than a message for each 2 bytes"),
        (_record(0x90, bytes(8 << 20)), "it unpacks to more than 100 times its size"),
    ],
)
def test_a_small_file_of_much_is_refused(path, chunk, error):
    whole = path.read_bytes()
    path.write_bytes(whole[: whole.rindex(_record(Opcode.DATA_END, bytes(4)))] + _packed(chunk) * 150)

    def read():
        with pytest.raises(RecordingError, match=error):
            list(Recording(path).samples())

    assert calls_of(read) < 4_000_000


def test_a_recording_of_nothing_but_time_is_read(tmp_path):
    """The most compressible real recording is far below the limit."""
    path = record_to(tmp_path / "idle.mcap", until=60.0)

    assert 500 < sum(1 for _ in Recording(path)._messages(lambda _topic: True))


@pytest.mark.parametrize("seed", range(25))
def test_noise_is_read_or_refused(path, seed):
    """Changed, missing and additional bytes lead to a result or to a RecordingError."""
    rng = random.Random(seed)
    data = bytearray(path.read_bytes())
    for _ in range(rng.randrange(1, 40)):
        at = rng.randrange(len(data))
        match rng.randrange(3):
            case 0:
                data[at] = rng.randrange(256)
            case 1:
                del data[at : at + rng.randrange(30)]
            case _:
                data[at:at] = rng.randbytes(rng.randrange(30))
    path.write_bytes(data)
    recording = refusal = None
    try:
        recording = Recording(path)
        read = sum(1 for _ in recording.samples())
    except RecordingError as error:
        refusal, read = str(error), 0

    assert read <= 123
    assert recording or refusal.startswith(str(path))

"""Files of each kind to be damaged: shipped worlds and trees, and traces and recordings of small runs."""

from __future__ import annotations

import io
import json
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from bt_controller.core.blackboards import Board
from bt_controller.coverage import TreeCoverage
from bt_controller.loading.trees import load
from hmrsim.actions import registry as actions
from hmrsim.cli.record import rosout
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.time import TimeState
from hmrsim.world.route_graph import to_geojson
from hmrsim.world.writing import to_json
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writer import RecordingFile
from tests.paths import ROOT, TESTS
from tests.shipped import shipped
from tests.simulation import simulate

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from tests.simulation import Run

_STATE = TimeState(0.0, "realtime", 1.0, False, 0, (), (), 0.0)

_SETTINGS = b"""\
seed: 3
clock: lockstep
participants: [nurses, porters]
participant_timeout: 10
real_time_factor: 2.5
step_size: 0.05
duration: 60
feedback_rate: 5
result_timeout: -1
keep_results: 10
trace: run.jsonl
robot: ["wall_e@3,4:nurse"]
ros2: true
ros_domain_id: 7
ros_distro: [jazzy, kilted]
connect: [tcp/127.0.0.1:7447]
prefix: site/a
timeout: 2.5
log_level: info
"""


_PROPERTIES = b"""\
properties:
  arrives: {eventually: {item: medicine, at: ward_a, carried: false}, within: 600}
  charged: {always: {battery: "*", above: 0.05}}
  in_time: {whenever: {event: order_placed}, then: {event: order_delivered, where: {order: $order}}, within: 900}
  retries: {whenever: {goal: aborted, robot: "*", action: wait}, then: {goal: accepted, robot: $robot}, within: 30}
  either: {sometimes: {any: [{door: gate, is: open}, {all: [{lane: [a, b], is: closed}, {not: {fault: slip}}]}]}}
  rounds: {patrolling: [ward_a, ward_b], robot: eve, every: 300}
  visits: {strict_ordered_visit: [pharmacy, ward_a], robot: wall_e, within: 60}
  few: {upper_restricted_avoidance: {robot: eve, at: lab, is: idle}, count: 3}
  waits: {wait: {order: pills_1, is: waiting}, until: {item: pills_1, carried_by: eve}}
  react: {instantaneous_reaction: {event: fault_began, where: {fault: slip}}, then: {robot: $robot, is: stopped}}
  formula: {formula: {always: {if: {robot: eve, is: busy}, then: {eventually: {robot: eve, is: idle}, within: [0, 9]}}}}
built_in: {no_deadlock: 30, no_vain_goals: 3, mission_ends: false, goals_end: true}
"""


@dataclass(frozen=True)
class Sample:
    """A valid file, to be damaged.

    Attributes:
        kind: Its reader: ``world``, ``tree``, ``coverage``, ``trace``, ``recording``, ``settings`` or
            ``properties``.
        name: Its name, with the suffix that readers look at.
    """

    kind: str
    name: str
    content: bytes


@cache
def samples() -> tuple[Sample, ...]:
    """Return all files, smaller ones of a kind first."""
    found = [*_worlds(), *_trees(), *_traces(), *_recordings(), _coverage()]
    found += [Sample("settings", "settings.yaml", _SETTINGS), Sample("properties", "properties.yaml", _PROPERTIES)]
    return tuple(sorted(found, key=lambda sample: (sample.kind, len(sample.content), sample.name)))


def _worlds() -> list[Sample]:
    files = [*(ROOT / "maps").glob("**/*.yaml"), *(ROOT / "examples").glob("*.yaml")]
    files += [path for path in (TESTS / "unit" / "hmrsim" / "world" / "data").iterdir() if path.is_file()]
    found = [Sample("world", path.name, path.read_bytes()) for path in files if path.name != "warehouse.yaml"]
    for name in ("scenario1", "hospital"):
        world = shipped(name).world
        found.append(Sample("world", f"{name}.json", to_json(world).encode()))
        found.append(Sample("world", f"{name}.geojson", json.dumps(to_geojson(world)).encode()))
    return found


def _trees() -> list[Sample]:
    folders = [ROOT / "examples", TESTS / "system", TESTS / "unit" / "bt_controller" / "loading" / "data"]
    files = [path for folder in folders for path in folder.glob("*.xml")]
    return [Sample("tree", path.name, path.read_bytes()) for path in files]


def _coverage() -> Sample:
    coverage = TreeCoverage()
    for path in sorted((ROOT / "examples").glob("*.xml")):
        with Board().in_use:
            coverage.watch(path.name, load(str(path)).build())
    return Sample("coverage", "seen.json", json.dumps(coverage.to_json()).encode())


def _eventful(**options: Any) -> Run:
    """Return a run with goals of most kinds, a cancel, a fault, a spawned robot and a pause."""
    run = simulate(strict=False, **options)
    run.ask("inject_fault", {"type": "breakdown", "robot": "cart", "at": 1.0, "duration": 2.0})
    goal = {name: each.goal.model_validate for name, each in actions().items()}
    drive = goal["navigate_to_pose"]({"pose": {"pose": {"position": {"x": 9.0, "y": 2.0}}}})
    back = goal["navigate_to_pose"]({"pose": {"pose": {"position": {"x": 0.0, "y": 0.0}}}})
    commands = [
        (0.0, SendGoal("wall_e", "navigate_to_pose", drive, "1" * 32)),
        (0.5, SendGoal("eve", "wait", goal["wait"]({"time": {"sec": 1}}), None, "r")),
        (2.0, SendGoal("eve", "spin", goal["spin"]({"target_yaw": 1.5}), "2" * 32)),
        (2.5, CancelGoal("wall_e", "navigate_to_pose", "1" * 32)),
        (3.0, SendGoal("wall_e", "navigate_to_pose", back, "3" * 32)),
    ]
    run(*commands, until=6.0)
    run.ask(
        "spawn_entity", {"name": "new", "uri": "robot_type:nurse", "initial_pose": {"pose": {"position": {"x": 5.0}}}}
    )
    run.ask("reset_simulation", {})
    run(until=8.0)
    run.ask("set_simulation_state", {"state": {"state": 2}})
    return run


def _traces() -> list[Sample]:
    found = [Sample("trace", "eventful.jsonl", "".join(_eventful(traced=True).lines()).encode())]
    for name in ("corridor_swap", "door", "lift", "charger_queue"):
        run = simulate(shipped(str(ROOT / "maps" / "zoo" / f"{name}.yaml")).world, traced=True)
        run.simulator.run_scripts(60.0)
        found.append(Sample("trace", f"{name}.jsonl", "".join(run.lines()).encode()))
    return found


def _recordings() -> list[Sample]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        with RecordingFile(path, reproducible=True) as file:
            made: list[RecordingSink] = []

            def watch(simulator: Simulator) -> list[RecordingSink]:
                made.append(RecordingSink(simulator, Recorder(file, rosout), lambda: _STATE, clock_rate=1.0))
                return made

            _eventful(watchers=watch, clock_rate=1.0, odom_rate=1.0, feedback_rate=1.0)
            made[0].close()
        packed = path.read_bytes()
    return [Sample("recording", "run.mcap", packed), Sample("recording", "raw.mcap", _unpacked(packed))]


def _unpacked(packed: bytes) -> bytes:
    """Return a recording without compression and checksums, so that damage reaches its contents."""
    raw = io.BytesIO()
    writer = Writer(raw, chunk_size=4_000, compression=CompressionType.NONE, enable_crcs=False)
    reader = make_reader(io.BytesIO(packed))
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    writer.start(profile="ros2", library="torture")
    for schema, channel, message in reader.iter_messages():
        if schema is None:
            raise AssertionError
        if schema.id not in schemas:
            schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
        if channel.id not in channels:
            encoding, known = channel.message_encoding, schemas[schema.id]
            channels[channel.id] = writer.register_channel(channel.topic, encoding, known, channel.metadata)
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
    for metadata in reader.iter_metadata():
        writer.add_metadata(metadata.name, metadata.metadata)
    writer.finish()
    return raw.getvalue()

"""Events of a plug-in, which are published, recorded and reported like built-in ones."""

from __future__ import annotations

import dataclasses
import json
import logging
from functools import partial
from importlib.metadata import EntryPoint, EntryPoints

import pytest
from mcap.reader import make_reader

from hmrsim import events, plugins
from hmrsim.actions import registry as actions
from hmrsim.cli.event_log import EventLog
from hmrsim.cli.record import rosout
from hmrsim.faults import registry as faults
from hmrsim.protocol.time import TimeState
from hmrsim.report import of_recording, of_trace, report_of
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks.loading import world_of
from hmrsim_zenoh.recording import Recording
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writer import RecordingFile
from hmrsim_zenoh.wire import encoding
from tests.simulation import Log
from tests.unit.hmrsim.events.cleaning import FloorCleaned

NOW = TimeState(0.0, "realtime", 1.0, False, 0, (), (), 0.0)
WORLD = {
    "bounds": [0, 0, 9, 9],
    "robots": {"eve": {"at": [1, 1], "script": ["Wait 2"]}},
    "faults": [{"type": "worn_brush", "robot": "eve", "at": 1.0}],
}


def _clean(robot, goal, report):
    result = yield from actions()["wait"].process(robot, goal, report)
    robot.publish(lambda: FloorCleaned(robot.name, "lobby", 24.0))
    return result


CACHES = (events.groups, events.registry, faults)


@pytest.fixture
def simulator(monkeypatch):
    entries = [("cleaning", "hmrsim.events"), ("worn_brush", "hmrsim.faults")]
    found = EntryPoints(EntryPoint(name, f"tests.unit.hmrsim.events.{name}", group) for name, group in entries)
    monkeypatch.setattr(plugins, "_installed", lambda: found)
    for cache in CACHES:
        cache.cache_clear()
    clean = dataclasses.replace(actions()["wait"], process=_clean)
    yield partial(Simulator, world_of(WORLD, "test"), actions={"wait": clean})
    for cache in CACHES:
        cache.cache_clear()


def test_events_are_published(simulator):
    log = Log()
    log.simulator = simulator(sinks=[log])
    log.simulator.run_scripts()
    (cleaned,) = [event for _, event in log.events if getattr(event, "kind", "") == "floor_cleaned"]

    stamp = {"sec": 2, "nanosec": 0}
    assert {"stamp": stamp, "kind": "floor_cleaned", "robot": "eve", "room": "lobby", "area": 24.0} == json.loads(
        encoding.event_payload(cleaned)
    )
    assert [(1.0, {"robot": "eve"})] == log.happened("brush_worn")


def test_events_are_traced_and_reported(simulator):
    """A report also counts them without the plug-in."""
    written = []
    trace = Trace(Header.of(world_of(WORLD, "test"), RunSettings()), written.append)
    run = simulator(sinks=[trace])
    run.run_scripts()
    trace.close(run.now)
    lines = "".join(written).splitlines(keepends=True)

    (line,) = [line for line in lines if "floor_cleaned" in line]
    assert FloorCleaned("eve", "lobby", 24.0) == events.from_json(json.loads(line))
    report = report_of(of_trace(lambda: lines)[0])
    assert (1, 1) == (report.events["floor_cleaned"], report.events["brush_worn"])


def test_events_are_recorded(simulator, tmp_path):
    path = tmp_path / "run.mcap"
    with RecordingFile(path) as file:
        made = []

        def recording(run):
            made.append(RecordingSink(run, Recorder(file, rosout), lambda: NOW, clock_rate=1.0))
            return made

        simulator(watchers=recording).run_scripts()
        made[0].close()

    with path.open("rb") as file:
        log = [message.data for _, _, message in make_reader(file).iter_messages(topics=["/rosout"])]
    assert any("has cleaned 24 m² of lobby".encode() in data for data in log)
    assert any(b"has a worn brush" in data for data in log)
    assert 1 == report_of(of_recording(Recording(path))).events["floor_cleaned"]


def test_events_are_logged(simulator, caplog):
    with caplog.at_level(logging.INFO):
        simulator(sinks=[EventLog()]).run_scripts()

    found = [(record.levelname, record.message) for record in caplog.records]
    assert ("WARNING", "sim 1.000 | eve has a worn brush") in found
    assert ("INFO", "sim 2.000 | eve has cleaned 24 m² of lobby") in found


@pytest.mark.usefixtures("simulator")
def test_the_page_has_the_texts_of_events():
    assert {
        "group": "cleaning",
        "severity": "info",
        "subject": ("robot",),
        "text": "has cleaned {area} m² of {room}",
    } == events.texts()["floor_cleaned"]
    assert {"waiting", "goal", "status"} <= events.texts().keys()

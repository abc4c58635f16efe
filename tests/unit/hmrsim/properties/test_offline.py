"""Checks of finished runs, from a trace or a recording, find the same as during the run."""

from __future__ import annotations

import json
from functools import cache
from types import SimpleNamespace

import pytest

from hmrsim.errors import TraceError
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.properties import check_recording, check_trace, properties_of
from hmrsim.report.sink import ReportSink
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.testing import simulation
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks import load_world
from tests.watching import watch

TREE = "bt_controller.examples.hospital:mission"
SAID = {
    "properties": {
        "arrives": {"eventually": {"item": "medicine", "at": "ward_a", "carried": False}, "within": 60},
        "stays_out": {"never": {"robot": "eve", "at": "lab"}},
        "charged": {"always": {"battery": "*", "above": 0.95}},
        "not_long": {"whenever": {"event": "waiting"}, "then": {"robot": "$robot", "is": "driving"}, "within": 2},
        "door_used": {"sometimes": {"event": "door_opened"}},
        "order": {"ordered_visit": ["pharmacy", "ward_a"], "robot": "wall_e"},
    }
}


@cache
def traced() -> str:
    """Return the trace of the hospital's mission."""
    with simulation("hospital", tree=TREE) as run:
        run.to_the_end()
        return run.trace


def lines(text=None):
    """Return the function that returns the lines of a trace."""
    return lambda: iter((traced() if text is None else text).splitlines(keepends=True))


def told(monitor):
    """Return the violations of a monitor, with rounded times."""
    return [(round(each.at / 1e9, 3), each.property, each.subject, each.reason) for each in monitor.violations]


def test_a_trace_has_the_violations_of_its_run():
    live = watch("hospital", TREE, SAID)

    assert told(live) == told(check_trace(lines(), properties_of(SAID)).monitor) != []


def test_a_recording_has_the_violations_of_its_run():
    samples = []

    def keep(happened):
        stamp = Time.from_nanoseconds(happened.at).model_dump()
        fields = getattr(happened.event, "fields", None)
        if fields is not None:
            samples.append((happened.at, "_world/scene", {**fields, "stamp": stamp}))
        elif hasattr(happened.event, "kind"):
            event = {**happened.event.to_json(), "kind": happened.event.kind, "stamp": stamp}
            samples.append((happened.at, "_world/events", json.loads(json.dumps(event))))

    world = load_world("scenario1").world
    simulator = Simulator(world, RunSettings(), watchers=lambda each: [ReportSink(each, keep)])
    simulator.run_scripts()
    said = {"properties": {"stays": {"never": {"not": {"robot": next(iter(world.robots)), "is": "idle"}}}}}
    recording = SimpleNamespace(
        world=world.model_dump(mode="json", by_alias=True, exclude_defaults=True),
        end=samples[-1][0],
        truncated=False,
        samples=lambda: iter(samples),
    )

    assert [] == told(check_recording(recording, properties_of(said)).monitor)


@pytest.mark.parametrize(
    ("end", "found"), [(6_000_000_000, [(4.0, "x", "", "not within 4 s: picked")]), (2**63, []), (3_000_000_000, [])]
)
def test_deadlines_after_the_last_event_of_a_recording_count(end, found):
    """A damaged file may have an invalid end."""
    world = load_world("scenario1").world
    recording = SimpleNamespace(
        world=world.model_dump(mode="json", by_alias=True, exclude_defaults=True),
        end=end,
        truncated=False,
        samples=lambda: iter(()),
    )
    said = {"properties": {"x": {"eventually": {"event": "picked"}, "within": 4}}}

    assert found == told(check_recording(recording, properties_of(said)).monitor)


def test_invalid_events_of_a_recording_are_skipped_and_reported():
    stamp = {"sec": 1, "nanosec": 0}
    motion = {"kind": "motion", "stamp": stamp, "robot": "wall_e", "from": [0, 0, 0], "to": [1, 0, 0], "duration": -1.0}
    samples = [(0, "_world/events", {**motion, "lane": None}), (0, "_world/events", {"kind": "picked", "stamp": stamp})]
    world = load_world("scenario1").world
    robot, place = next(iter(world.robots)), next(iter(world.waypoints))
    recording = SimpleNamespace(
        world=world.model_dump(mode="json", by_alias=True, exclude_defaults=True),
        end=0,
        truncated=True,
        samples=lambda: iter(samples),
    )

    said = {"properties": {"x": {"sometimes": {"robot": robot, "at": place}}}}
    checked = check_recording(recording, properties_of(said))

    assert (
        "The recording is truncated: later events are missing.",
        "2 events are ignored, as this version can't read them.",
    ) == checked.notes


def test_a_trace_that_can_not_be_replayed_is_read():
    """A trace of another contract still has ends of goals and openings of doors."""
    header, *rest = traced().splitlines(keepends=True)
    text = "".join([json.dumps({**json.loads(header), "contract": 99}) + "\n", *rest])

    checked = check_trace(lines(text), properties_of({"properties": {"door": {"never": {"event": "door_opened"}}}}))

    assert (13, True) == (
        len(checked.monitor.violations),
        "(this version can't replay it (line 1: a trace of contract 99;" in checked.notes[0],
    )


def test_a_truncated_trace_leaves_open_obligations_undecided():
    text = "".join(traced().splitlines(keepends=True)[:60])
    said = {"properties": {"never_comes": {"eventually": {"event": "run_reported"}}}}

    checked = check_trace(lines(text), properties_of(said))

    assert ([], "undecided", ("The trace is truncated: later events are missing.",)) == (
        checked.monitor.violations,
        checked.monitor.verdicts()[0].state,
        checked.notes,
    )


def test_a_file_that_is_no_trace_is_an_error():
    with pytest.raises(TraceError, match="no header of a trace"):
        check_trace(lines("hello\n"), properties_of({}))


def test_a_trace_with_only_a_header_is_an_empty_run():
    header = Header.of(load_world("scenario1").world, RunSettings())
    text = []
    Trace(header, text.append).flush()

    assert [] == check_trace(lines("".join(text)), properties_of({})).monitor.violations


def test_missing_names_end_the_check_before_the_run_is_read():
    read = []

    def counted():
        for line in traced().splitlines(keepends=True):
            read.append(line)
            yield line

    def refuse(findings):
        raise LookupError(findings[0].message)

    with pytest.raises(LookupError, match="nowhere"):
        check_trace(counted, properties_of({"properties": {"x": {"never": {"robot": "eve", "at": "nowhere"}}}}), refuse)

    assert 1 == len(read)

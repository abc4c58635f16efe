"""Limits that keep work in proportion to the size of a world."""

from __future__ import annotations

import gc
import json
import time
from typing import Any

import pytest

from hmrsim.errors import WorldError
from hmrsim.geometry import crosses
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import MAX_RIDES, MAX_STOPS
from hmrsim.world_checks.loading import world_of
from hmrsim.world_checks.resolved import resolved
from tests.calls import calls_of


def _line(count: int) -> dict[str, Any]:
    lanes = [[f"w{i}", f"w{i + 1}"] for i in range(count - 1)]
    return {"waypoints": {f"w{i}": [2.0 * i, 0.0] for i in range(count)}, "lanes": lanes}


def _closing(lane: list[str], at: float) -> dict[str, Any]:
    return {"type": "lane_closed", "lane": lane, "at": at, "until": at + 1.0}


def _door(x: float) -> dict[str, Any]:
    return {"at": [[x, -1.0], [x, 1.0]]}


SHAPES = {
    "faults one after the other": lambda n: {"faults": [_closing(["w0", "w1"], float(i)) for i in range(n)]},
    "faults at one instant": lambda n: {"faults": [_closing([f"w{i}", f"w{i + 1}"], 1.0) for i in range(n - 1)]},
    "doors on one lane": lambda n: {"doors": {f"d{i}": _door(0.5 + i / n) for i in range(n)}},
    "doors on many lanes": lambda n: {"doors": {f"d{i}": _door(2.0 * i + 1.0) for i in range(n)}},
    "robots before doors": lambda n: {
        "robots": {f"r{i}": {"at": f"w{i}"} for i in range(n)},
        "doors": {f"d{i}": _door(2.0 * i + 1.0) for i in range(n)},
    },
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_eight_times_the_parts_are_not_sixty_four_times_the_work(shape):
    def cost(number: int) -> int:
        world = _line(number) | shape(number)
        return calls_of(lambda: Simulator(world_of(world, "test"), RunSettings(), []).advance(10.0))

    assert cost(600) < 30 * cost(75)


CHECKED = {
    "orders and items": lambda n: (
        _line(2)
        | {
            "items": {f"i{i}_1": {"at": "w0"} for i in range(n)},
            "demand": [{"name": f"d{i}", "at": "w0", "to": "w1", "arrives": 1} for i in range(n)],
        }
    ),
    "a door for many robots": lambda n: (
        _line(2)
        | {
            "robots": {f"r{i}": {"at": "w0"} for i in range(3 * n)},
            "doors": {"door": {**_door(1.0), "opens_for": [f"r{i}" for i in range(3 * n)]}},
        }
    ),
    "docks for any robot": lambda n: (
        _line(2)
        | {"robots": {f"r{i}": {"at": "w0"} for i in range(n)}, "docks": {f"d{i}": {"at": "w1"} for i in range(n)}}
    ),
    "robots on lanes": lambda n: (
        _line(n)
        | {
            "robots": {f"r{i + 1}": {"at": [2.0 * i + 1.0, 0.0]} for i in range(n - 1)},
            "traffic": {"policy": "reserve"},
        }
    ),
}


@pytest.mark.uncovered
@pytest.mark.parametrize("shape", CHECKED.values(), ids=CHECKED)
def test_names_are_not_compared_with_all_others(shape):
    """Comparisons are no calls, so that this is processor time, of eight times the names by that of one."""

    def seconds(number: int) -> float:
        world = shape(number)
        gc.disable()
        began = time.process_time()
        world_of(world, "test")
        ended = time.process_time()
        gc.enable()
        return ended - began

    assert min(seconds(8_000) for _ in range(2)) < 30 * min(seconds(1_000) for _ in range(2))


def test_a_lift_has_a_maximum_of_stops():
    stops = [f"w{i}" for i in range(MAX_STOPS + 1)]
    with pytest.raises(WorldError) as caught:
        world_of(_line(MAX_STOPS + 1) | {"lifts": {"lift": {"stops": stops}}}, "test")

    assert [f"test: lifts.lift.stops: {MAX_STOPS + 1} stops are more than the maximum of {MAX_STOPS}"] == [
        str(problem) for problem in caught.value.problems
    ]


def test_all_lifts_have_a_maximum_of_rides():
    lifts = {f"l{i}": {"stops": [f"w{j}" for j in range(MAX_STOPS)]} for i in range(3)}
    with pytest.raises(WorldError, match=f"rides from stop to stop are more than the maximum of {MAX_RIDES}"):
        world_of(_line(MAX_STOPS) | {"lifts": lifts}, "test")


def test_lanes_through_a_door_are_those_that_cross_it():
    at = [((1, -1), (1, 1)), ((2, 0), (2, 5)), ((0.5, 0), (9.5, 0)), ((4, 1), (6, 1)), ((3, -1e6), (3, 1e6))]
    world = world_of(
        _line(10) | {"doors": {f"d{i}": {"at": list(map(list, ends))} for i, ends in enumerate(at)}}, "test"
    )
    points = world.points

    assert [
        [(lane.from_, lane.to) for lane in world.lanes if crosses(points[lane.from_], points[lane.to], *door.at)]
        for door in world.doors.values()
    ] == [door["lanes"] for door in resolved(world)["doors"]]


def test_long_names_are_cut_in_messages():
    with pytest.raises(WorldError) as caught:
        world_of(json.loads(json.dumps({"x" * 300_000: 1, "lanes": [["y" * 300_000, "z"]]})), "test")

    assert max(len(str(problem)) for problem in caught.value.problems) < 2_000


def test_names_of_ended_faults_are_reused():
    world = world_of(_line(2) | {"faults": [_closing(["w0", "w1"], float(at)) for at in (1, 2, 9)]}, "test")
    simulator = Simulator(world, RunSettings(), [])
    before = [*simulator.fault_injector.known]
    simulator.advance(5.0)

    assert ["lane_closed_1", "lane_closed_2", "lane_closed_3"] == before
    assert ["lane_closed_3"] == [*simulator.fault_injector.known]

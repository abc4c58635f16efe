"""Random parts of a world, which are the same for each controller under one seed."""

from __future__ import annotations

from typing import Any

import pytest

from hmrsim.distributions import Distribution
from hmrsim.engine.chance import Chance
from hmrsim.events.facilities import DoorOpened, DoorOpening
from hmrsim.events.faults import FaultBegan, FaultEnded
from hmrsim.events.robots import Docked
from hmrsim.protocol.outputs import EventStamped
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.reset import reset
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks.loading import world_of

WORLD: dict[str, Any] = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "d": [20, 5]},
    "lanes": [{"from": "a", "to": "b", "speed_factor": {"uniform": {"low": 0.5, "high": 1}}}, ["b", "c"]],
    "doors": {"x": {"at": [[15, -1], [15, 1]], "opening_time": {"uniform": {"low": 1, "high": 6}}}},
    "lifts": {"l": {"stops": ["c", "d"], "travel_time": {"lognormal": {"mean": 5, "stddev": 3}}}},
    "docks": {"k": {"at": "b", "docking_time": {"exponential": {"mean": 3}}}},
    "items": {"i": {"at": "b"}},
    "robot_types": {
        "nurse": {"components": {"claw": {"handling_time": {"triangular": {"low": 1, "mode": 2, "high": 4}}}}}
    },
    "robots": {"w": {"at": "a", "type": "nurse", "script": ["Go b", "Grab i", "Go d", "Go b", "Dock k", "Go a"]}},
    "faults": [
        {
            "type": "slip",
            "robot": "w",
            "factor": {"uniform": {"low": 0.3, "high": 0.6}},
            "at": {"uniform": {"low": 3, "high": 8}},
            "duration": {"exponential": {"mean": 3}},
        }
    ],
}


class Story:
    """Keeps the events of a run."""

    def __init__(self) -> None:
        self.events: list[tuple[float, Any]] = []

    def wants(self, _topic: object) -> bool:
        return True

    def emit(self, output: object) -> None:
        if isinstance(output, EventStamped):
            self.events.append((output.stamp / 1e9, output.event))

    def times(self, kind: type) -> list[float]:
        """Return when events of a kind happened."""
        return [at for at, event in self.events if isinstance(event, kind)]


def run(seed: int, **changes: Any) -> tuple[Simulator, Story]:
    """Return a run of the world, and its events."""
    story = Story()
    simulator = Simulator(world_of({**WORLD, **changes}, "world"), RunSettings(seed=seed), [story])
    simulator.run_scripts()
    return simulator, story


def test_a_seed_determines_everything_and_another_seed_differs() -> None:
    ends = [run(seed)[0].now for seed in (1, 1, 2)]
    assert ends[0] == ends[1] != ends[2]


def test_a_reset_restarts_the_random_numbers() -> None:
    simulator, _ = run(3)
    first = simulator.now
    reset(simulator)
    simulator.run_scripts()
    assert simulator.now == first


def test_the_times_of_a_door_are_drawn_per_occurrence_and_independent_of_robots() -> None:

    def openings(script: list[str]) -> list[float]:
        robots = {"w": {"at": "a", "type": "nurse", "script": script}}
        _, story = run(5, robots=robots, faults=[])
        return [
            round(opened - opening, 6)
            for opening, opened in zip(story.times(DoorOpening), story.times(DoorOpened), strict=True)
        ]

    there_and_back = openings(["Go c", "Wait 10", "Go b", "Wait 10", "Go c"])
    assert len({*there_and_back}) == 3
    assert openings(["Wait 3", "Go b", "Grab i", "Go c", "Wait 50", "Go b"]) == there_and_back[:2]


def test_a_fault_draws_its_time_its_duration_and_its_effect() -> None:
    _, story = run(7)
    (began,), (ended,) = story.times(FaultBegan), story.times(FaultEnded)
    settings = next(event for _, event in story.events if isinstance(event, FaultBegan)).settings
    assert 3 <= began <= 8
    assert settings["at"] == pytest.approx(began)
    assert 0.3 <= settings["factor"] <= 0.6
    assert ended - began == pytest.approx(settings["duration"])


def test_the_duration_of_docking_is_drawn() -> None:

    def docked(docking_time: float) -> float:
        _, story = run(1, docks={"k": {"at": "b", "docking_time": docking_time}}, faults=[])
        return story.times(Docked)[0]

    assert docked(4.0) - docked(0.0) == pytest.approx(4.0)


def test_a_lane_slows_a_trip_by_one_factor_also_after_a_stop() -> None:
    lanes = [{"from": "a", "to": "b", "speed_factor": 0.5}]
    world = {
        "doors": {},
        "lifts": {},
        "docks": {},
        "items": {},
        "waypoints": {"a": [0, 0], "b": [10, 0]},
        "lanes": lanes,
    }
    robots = {"w": {"at": "a", "script": ["Go b"]}}
    slip = {"type": "slip", "robot": "w", "factor": 0.5, "at": 4, "duration": 4}
    assert run(1, **world, robots=robots, faults=[])[0].now == pytest.approx(20.0)
    assert run(1, **world, robots=robots, faults=[slip])[0].now == pytest.approx(22.0)


def test_a_ride_takes_as_long_for_the_robot_as_for_the_lift() -> None:
    _, story = run(11, faults=[])
    kinds = [event.kind for _, event in story.events]
    assert kinds.count("lift_departed") == kinds.count("lift_arrived")


def test_streams_of_different_subjects_and_uses_are_independent() -> None:
    chance, value = Chance(), Distribution.model_validate({"uniform": {"low": 0, "high": 1}})
    chance.begin(1)
    drawn = [chance.draw(value, *of) for of in (("a", "x"), ("a", "x"), ("b", "x"), ("a", "y"))]
    assert len({*drawn}) == 4
    chance.begin(1)
    assert [chance.draw(value, "a", "y"), chance.draw(value, "a", "x")] == [drawn[3], drawn[0]]
    assert chance.drawn(value, "a", "x", 2) == drawn[1]
    assert chance.draw(2.5, "a", "x") == 2.5

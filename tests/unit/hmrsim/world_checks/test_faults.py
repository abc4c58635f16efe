"""Faults that make no sense, each reported with the field and a remedy."""

from __future__ import annotations

import json

import pytest

from hmrsim.diagnostics import dotted
from hmrsim.world import World
from hmrsim.world_checks.checks import check
from hmrsim.world_checks.loading import load_world
from tests.simulation import SMALL_WORLD


def problems(*faults, **keys):
    world = World.model_validate({**SMALL_WORLD, **keys, "faults": [*faults]})
    return [(dotted(one.path), one.message) for one in check(world) if one.path[0] == "faults"]


def test_valid_faults_have_no_problems():
    reported = problems(
        {"type": "lane_closed", "lane": ["home", "door"], "at": 30, "until": 60},
        {"type": "lane_closed", "lane": ["island", "far"], "name": "wet"},
        {"type": "claw_misses", "robot": "eve", "mean_time_between": 10, "mean_duration": 5},
        {"type": "claw_drops", "robot": "eve", "mean_time_between": 10},
    )

    assert [] == reported


@pytest.mark.parametrize(
    ("fault", "path", "message"),
    [
        ({"type": "slipp"}, "faults.0.type", "no fault type 'slipp'; did you mean 'slip'?"),
        ({"type": "slip", "robot": "eve"}, "faults.0.factor", "is missing"),
        ({"type": "slip", "robot": "eve", "factor": 0}, "faults.0.factor", "must be greater than 0, got 0"),
        ({"type": "slip", "robot": "eva", "factor": 1}, "faults.0.robot", "no robot 'eva'; did you mean 'eve'?"),
        ({"type": "breakdown", "robot": "eve", "att": 1}, "faults.0.att", "unknown key 'att'; did you mean 'at'?"),
        ({"type": "breakdown", "robot": "eve", "at": 5, "until": 5}, "faults.0", "until 5 s is not after at 5 s"),
        ({"type": "breakdown", "robot": "eve", "at": -1}, "faults.0.at", "must be at least 0, got -1"),
        (
            {"type": "breakdown", "robot": "eve", "at": 1, "mean_time_between": 5},
            "faults.0",
            "at and mean_time_between are both given; leave one of them out",
        ),
        (
            {"type": "breakdown", "robot": "eve", "until": 5, "mean_time_between": 5},
            "faults.0",
            "until is given for a fault that recurs; give duration or mean_duration",
        ),
        (
            {"type": "claw_drops", "robot": "eve", "until": 5},
            "faults.0.until",
            "unknown key 'until'; there are name, at, mean_time_between, when, robot, probability",
        ),
        ({"type": "claw_drops", "robot": "cart"}, "faults.0.robot", "cart has no claw; there are none"),
        (
            {"type": "sensor_blind", "robot": "eve", "sensor": "camera"},
            "faults.0.sensor",
            "eve has no sensor 'camera'; there are none",
        ),
        (
            {"type": "lane_closed", "lane": ["home", "doors"]},
            "faults.0.lane",
            "no lane 'home-doors'; did you mean 'home-door'?",
        ),
        ({"type": "lane_closed", "lane": ["home"]}, "faults.0.lane", "expected at least 2 values, got 1"),
        ({"type": "door_jammed", "door": "gate"}, "faults.0.door", "no door 'gate'; there are none"),
    ],
)
def test_an_invalid_value_is_reported(fault, path, message):
    assert [(path, message)] == problems(fault)


def test_a_cell_that_the_battery_lacks_is_an_error():
    robots = {"eve": {"at": "home", "components": {"battery": {"cells": 4}}}}
    reported = problems({"type": "battery_cell", "robot": "eve", "cell": 4}, robots=robots, remap={})

    assert [("faults.0.cell", "eve has no cell 4; its battery has 4, from 0 on")] == reported


def test_two_faults_of_one_name_are_an_error():
    fault = {"type": "breakdown", "robot": "eve", "name": "ouch"}

    assert [("faults.1.name", "there is a fault 'ouch' already; give another name")] == problems(fault, fault)


def test_errors_that_follow_from_others_are_omitted(tmp_path):
    world = {"robots": {"eve": {"at": [0]}}, "faults": [{"type": "breakdown", "robot": "eve"}]}
    path = tmp_path / "world.json"
    path.write_text(json.dumps(world))

    with pytest.raises(Exception, match=r"robots\.eve\.at") as raised:
        load_world(str(path))

    assert "faults" not in str(raised.value)

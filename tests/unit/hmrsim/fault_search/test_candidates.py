"""The candidates of a search, and the moments at which they can begin."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from hmrsim.fault_search.candidates import Candidates, Timeline, expanded
from hmrsim.fault_search.check import Space
from hmrsim.fault_search.kinds import Draw
from hmrsim.fault_search.schedule import Injection, Moment
from hmrsim.world_checks.loading import world_of
from tests.porters import WORLD

MOMENTS = (
    Moment(0.0, "executing", "", "porter", "navigate_to_pose", 1),
    Moment(10.0, "ended", "", "porter", "navigate_to_pose", 1, 10.0),
    Moment(10.0, "executing", "", "porter", "pickup", 1),
    Moment(10.0, "", "picked", "porter", "", 1),
    Moment(10.0, "ended", "", "porter", "pickup", 1),
)


@pytest.fixture(scope="module")
def world():
    """Return the world of the porters."""
    return world_of(dict(WORLD), "world")


def candidates(world, draw=None, **space):
    """Return the candidates of a world; *draw* is the battery draw of the porter."""
    return Candidates(world, Space.model_validate(space), MOMENTS, {"porter": draw} if draw else None)


def powered(units="m", docks=None, **battery):
    """Return the world of the porters, with batteries."""
    components = {"claw": {}, "battery": {"capacity": 100.0, **battery}}
    robots = {name: {**robot, "components": components} for name, robot in WORLD["robots"].items()}
    return world_of({**WORLD, "robots": robots, "units": units, "docks": docks or {}}, "world")


def changed(world, draw):
    """Return the values of the candidates that change the porter, by the last step of their paths."""
    entries = candidates(world, draw, families=["changes"]).entries
    spec = [candidate.injection.spec["change"] for candidate in entries]
    return sorted((path.rpartition(".")[2], value) for each in spec for path, value in each.items())


def test_only_robots_that_the_controller_uses_have_faults(world):
    robots = {
        candidate.injection.spec["robot"]
        for candidate in candidates(world).entries
        if "robot" in candidate.injection.spec
    }

    assert robots == {"porter"}


def test_changes_name_the_demand():
    demand = [{"name": name, "at": "home", "to": "home", "arrives": 9} for name in ("bread", "crate")]
    entries = candidates(world_of({**WORLD, "demand": demand}, "world"), families=["changes"]).entries
    paths = {path for candidate in entries for path in candidate.injection.spec["change"] if "demand" in path}

    assert paths == {"demand.bread.arrives", "~demand.bread", "demand.crate.arrives", "~demand.crate"}


def test_component_faults_need_the_component(world):
    kinds = {candidate.injection.kind for candidate in candidates(world).entries}

    assert {"claw_misses", "claw_drops", "breakdown", "slip", "lane_closed", "controller_killed", "speed"} <= kinds
    assert not {"battery_cell", "battery_drop", "sensor_blind", "door_jammed", "capacity"} & kinds


def test_goals_of_each_used_action_are_aborted(world):
    aborted = [candidate.injection.spec for candidate in candidates(world, only=["goals_aborted"]).entries]

    assert {(spec.get("action"), spec.get("count")) for spec in aborted} >= {
        ("navigate_to_pose", 1),
        ("navigate_to_pose", 3),
        ("pickup", 1),
    }


def test_space_excludes_kinds_families_and_spared_objects(world):
    assert {candidate.injection.kind for candidate in candidates(world, only=["slip", "breakdown"]).entries} == {
        "slip",
        "breakdown",
    }
    assert "slip" not in {candidate.injection.kind for candidate in candidates(world, without=["slip"]).entries}
    assert {candidate.injection.family for candidate in candidates(world, families=["changes"]).entries} == {"change"}
    assert not [
        candidate for candidate in candidates(world, spare=["porter"]).entries if candidate.injection.spec.get("robot")
    ]


def test_some_disturbances_are_opt_in(world):
    assert "second_controller" not in {candidate.injection.kind for candidate in candidates(world).entries}
    assert "second_controller" in {
        candidate.injection.kind for candidate in candidates(world, also=["second_controller"]).entries
    }


def test_injection_of_a_robot_begins_at_its_moments_and_mid_goal(world):
    candidate = next(each for each in candidates(world, only=["claw_drops"]).entries)

    anchors = candidate.anchors_in(Timeline(MOMENTS))

    assert {"goal": "executing", "robot": "porter", "action": "navigate_to_pose", "after": 5.0} in anchors
    assert {"event": "picked", "robot": "porter"} in anchors
    assert len(anchors) == len(MOMENTS) + 1


def test_each_candidate_has_a_single_before_any_has_two(world):
    """A short search thus tries every candidate, and a longer one every moment."""
    whole = candidates(world)
    singles = whole.singles(MOMENTS, random.Random(1)).in_order
    first = [single.candidate.injection.key for single in singles[: len(whole.entries)]]

    assert len(set(first)) == len(whole.entries)
    assert len(singles) == sum(
        (len(candidate.anchors_in(Timeline(MOMENTS))) or 1) + candidate.starts for candidate in whole.entries
    )


def test_singles_know_their_injections(world):
    """An injection that a file gives is one of them if the search would propose it, too."""
    also = [{"type": "slip", "robot": "porter", "factor": 0.5, "duration": 5.0, "at": at} for at in (0.0, 1.0)]
    singles = candidates(world, only=["slip", "speed"], further=also).singles(MOMENTS, random.Random(1))
    injections = {single.injection.key: single.injection for single in singles.in_order}

    assert len(singles) == len(injections) < len(singles.in_order)
    assert all(injection in singles for injection in injections.values())
    assert Injection({"type": "slip", "robot": "porter", "factor": 0.5, "duration": 5.0, "at": 2.0}) not in singles


def test_each_fault_is_tried_from_the_start_once(world):
    """Error codes of goals and a robot out of reach are left out."""
    singles = [single.injection for single in candidates(world).singles(MOMENTS, random.Random(1)).in_order]
    starts = [injection for injection in singles if injection.at_start]

    faults = {injection.kind for injection in singles if injection.family == "type"}
    assert {injection.kind for injection in starts} == faults - {"messages_lost"}
    assert len({injection.key for injection in starts}) == len(starts) < len(singles) / 5
    assert not any("error_code" in injection.spec for injection in starts)


def test_some_random_faults_hold_from_the_start(world):
    whole, rng = candidates(world), random.Random(1)
    drawn = [whole.any(MOMENTS, rng) for _ in range(1000)]

    assert 10 < sum(injection.at_start for injection in drawn) < 100


@pytest.mark.parametrize(("units", "far"), [("m", 0.5), ("px", 40.0)])
def test_localization_jumps_by_a_positive_distance(units, far):
    (spec,) = [
        candidate.injection.spec
        for candidate in candidates(powered(units), only=["localisation_jump"], durations=[5.0]).entries
    ]

    assert spec["dx"] == far


CHARGER = {"charger": {"at": [0, 1], "type": "charger"}}


@pytest.mark.parametrize(
    ("docks", "whole", "shares"),
    [(CHARGER, 0.6, [0.2, 0.3]), ({}, 0.1, [0.2, 0.3]), ({}, 0.4, [0.6]), ({}, 0.8, [])],
)
def test_battery_drops_leave_enough_for_the_mission(docks, whole, shares):
    """Batteries drop to low and a little above; without a charger, enough is left for the mission."""
    entries = candidates(powered(docks=docks), Draw(whole, 0.1), only=["battery_drop"]).entries

    assert [candidate.injection.spec["share"] for candidate in entries] == shares


QUICK = ("speed", 1e4)


@pytest.mark.parametrize(
    ("docks", "draw", "battery", "expected"),
    [
        ({}, Draw(0.1, 0.1), {}, [("capacity", 50.0), ("speed", 0.3), QUICK]),
        ({}, Draw(0.4, 0.1), {}, [("capacity", 60.0), ("speed", 0.6), QUICK]),
        ({}, Draw(0.7, 0.1), {}, [QUICK]),
        (
            {},
            Draw(0.2, 0.1),
            {"initial_charge": 50.0},
            [("capacity", 60.0), ("initial_charge", 30.0), ("speed", 0.6), QUICK],
        ),
        (CHARGER, Draw(0.7, 0.05), {}, [("capacity", 50.0), ("speed", 0.375), QUICK]),
        (CHARGER, Draw(0.7, 0.1), {}, [("capacity", 75.0), ("speed", 0.75), QUICK]),
        (CHARGER, Draw(0.7, 0.1), {"low": 0.5}, [("capacity", 50.0), ("speed", 0.3), QUICK]),
        (CHARGER, Draw(0.7, 0.3), {"low": 0.5}, [("capacity", 90.0), ("speed", 0.9), QUICK]),
    ],
)
def test_changes_leave_enough_battery_for_the_mission(docks, draw, battery, expected):
    """With a charger, the battery has to last for the longest goal only."""
    assert changed(powered(docks=docks, **battery), draw) == expected


def test_weight_makes_a_kind_more_frequent(world):
    rng = random.Random(1)
    weighted = candidates(world, only=["slip", "claw_drops"], weights={"claw_drops": 10}, durations=[5.0])
    drawn = Counter(weighted.any(MOMENTS, rng).kind for _ in range(300))

    assert drawn["claw_drops"] > 4 * drawn["slip"] > 0


def test_template_expands_to_each_combination():
    """A robot ``*`` stands for each robot, and a lane is one value."""
    template = {"type": "slip", "robot": "*", "factor": [0.1, 0.5], "duration": 5.0}

    assert len(expanded(template, ["eve", "wall_e"])) == 4
    assert expanded({"type": "lane_closed", "lane": ["a", "b"]}, []) == [{"type": "lane_closed", "lane": ["a", "b"]}]


def test_custom_injections_are_candidates(world):
    own = {"type": "slip", "robot": "other", "factor": 0.01, "at": 3.0}

    assert Injection(own) in [candidate.injection for candidate in candidates(world, further=[own]).entries]

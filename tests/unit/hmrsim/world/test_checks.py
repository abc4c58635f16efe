"""The checks across the fields of a world."""

from __future__ import annotations

import pytest

from hmrsim.diagnostics import dotted
from hmrsim.errors import WorldError
from hmrsim.world import World
from hmrsim.world_checks.checks import check
from hmrsim.world_checks.loading import world_of

MAP = {
    "bounds": [0, 0, 10, 10],
    "waypoints": {"home": [1, 1], "door": [5, 1], "shelf": [9, 1]},
    "lanes": [["home", "door"], ["door", "shelf"]],
    "places": {"table": {"at": [9, 2]}},
    "robots": {"wall_e": {"type": "fetcher", "at": "home"}},
}


def problems(**fields):
    merged = {key: {**MAP.get(key, {}), **value} if isinstance(value, dict) else value for key, value in fields.items()}
    world = World.model_validate({**MAP, **merged})
    return [(finding.severity, dotted(finding.path), finding.message) for finding in check(world)]


def test_the_map_of_these_tests_is_valid():
    assert problems() == []


BOX = {"solid": [[0, 0], [2, 0], [2, 2], [0, 2]]}

ERRORS = [
    ({"bounds": [0, 0, 0, 10]}, "bounds", "least x 0 must be below greatest x 0"),
    ({"lanes": [["home", "dor"]]}, "lanes.0.to", "no waypoint 'dor'; did you mean 'door'?"),
    ({"lanes": [["zz", "door"]]}, "lanes.0.from", "no waypoint 'zz'; there are home, door, shelf"),
    ({"lanes": [["home", "home"]]}, "lanes.0", "leads from 'home' to itself"),
    ({"waypoints": {"gate": [1, 1]}, "lanes": [["home", "gate"]]}, "lanes.0", "has no length"),
    ({"lanes": [["home", "door"], ["door", "home"]]}, "lanes.1", "are joined by lanes.0 already"),
    ({"robots": {"eve": {"at": "hme"}}}, "robots.eve.at", "no waypoint, place or dock 'hme'; did you mean"),
    ({"robots": {"eve": {"at": [11, 1]}}}, "robots.eve.at", "(11, 1) is outside the map, which spans (0, 0) to"),
    ({"robots": {"eve": {"at": [1, 1.5]}}, "walls": [BOX]}, "robots.eve.at", "(1, 1.5) is inside an obstacle"),
    ({"robots": {"eve": {"at": [1, 1], "type": "fetchr"}}}, "robots.eve.type", "did you mean 'fetcher'?"),
    ({"robots": {"eve": {"at": [1, 1], "components": {"clw": {}}}}}, "robots.eve.components.clw", "no component"),
    (
        {"robots": {"eve": {"at": [1, 1], "components": {"claw": {"reach": "far"}}}}},
        "robots.eve.components.claw.reach",
        "expected a number, got 'far'",
    ),
    (
        {"robot_types": {"nurse": {"components": {"claw": {"reach": -1}}}}},
        "robot_types.nurse.components.claw.reach",
        "must be greater than 0, got -1",
    ),
    ({"items": {"cup": {"at": "nowhere"}}}, "items.cup.at", "no waypoint, place or dock 'nowhere'"),
    ({"places": {"home": {"at": [3, 3]}}}, "places.home.at", "(3, 3) is another point than waypoints.home"),
    ({"remap": {"grab": "wall_e/pickup"}}, "remap.grab", "must be two words with a slash between"),
    ({"remap": {"_world/time": "wall_e/pickup"}}, "remap._world/time", "must be two words with a slash between"),
    ({"remap": {"a/b": "wall_e.pickup"}}, "remap.a/b", "must be <robot>/<action>"),
    ({"remap": {"a/b": "wally/pickup"}}, "remap.a/b", "no robot 'wally' for 'wally/pickup'; did you mean 'wall_e'?"),
    (
        {"remap": {"wall_e/place": "wall_e/pickup", "a/b": "wall_e/place"}},
        "remap.wall_e/place",
        "is the name of an action already",
    ),
    ({"docks": {"charger": {"at": [5, -2]}}}, "docks.charger.at", "(5, -2) is outside the map, which spans (0, 0)"),
    ({"docks": {"charger": {"at": "hme"}}}, "docks.charger.at", "no waypoint or place 'hme'; did you mean 'home'?"),
    ({"docks": {"charger": {"at": "pad"}, "pad": {"at": [1, 2]}}}, "docks.charger.at", "no waypoint or place 'pad'"),
    (
        {"docks": {"charger": {"at": "home", "reserved_for": ["walle"]}}},
        "docks.charger.reserved_for.0",
        "no robot or robot type 'walle'; did you mean 'wall_e'?",
    ),
    (
        {"robots": {"eve": {"at": "home", "components": {"battery": {"drain": {"actions": {"wat": 1}}}}}}},
        "robots.eve.components.battery.drain.actions.wat",
        "no action 'wat'; did you mean 'wait'?",
    ),
    (
        {"robots": {"eve": {"at": "home", "components": {"battery": {"low": 0.1, "critical": 0.5}}}}},
        "robots.eve.components.battery",
        "critical 0.5 is more than low 0.1",
    ),
    ({"doors": {"gate": {"at": [[5, 1], [5, 1]]}}}, "doors.gate.at", "has no length: name both its jambs"),
    (
        {"doors": {"gate": {"at": [[3, 0], [3, 2]], "opens_for": ["fetcher", "walle"]}}},
        "doors.gate.opens_for.1",
        "no robot or robot type 'walle'; did you mean 'wall_e'?",
    ),
    ({"doors": {"gate": {"at": [[1, 0], [1, 2]]}}}, "robots.wall_e.at", "(1, 1) is in the closed door 'gate'; start"),
    ({"doors": {"wall_e": {"at": [[3, 0], [3, 2]]}}}, "doors.wall_e", "robots.wall_e has this name already"),
    ({"lifts": {"lift": {"stops": ["home", "shlf"]}}}, "lifts.lift.stops.1", "no waypoint 'shlf'; did you mean"),
    ({"lifts": {"lift": {"stops": ["home", "shelf", "home"]}}}, "lifts.lift.stops", "'home' is listed 2 times"),
    ({"lifts": {"lift": {"stops": ["home", "door"]}}}, "lifts.lift.stops", "'door' and 'home' are joined by lanes.0"),
    (
        {"lifts": {"lift": {"stops": ["home", "shelf"], "at": "door"}}},
        "lifts.lift.at",
        "'door' is not one of its stops",
    ),
    (
        {"waypoints": {"attic": [9, 1]}, "lifts": {"lift": {"stops": ["shelf", "attic"]}}},
        "lifts.lift.stops",
        "'shelf' and 'attic' are the same point; draw levels beside each other",
    ),
    (
        {"robots": {"eve": {"at": [1.4, 1], "base": {"radius": 0.5}}}, "traffic": {"policy": "reserve"}},
        "robots.eve.at",
        "starts 0.4 from 'wall_e'; under 'reserve' keep 0.5 away",
    ),
    (
        {"robots": {"eve": {"at": "home"}}, "traffic": {"policy": "priority"}},
        "robots.eve.at",
        "starts where 'wall_e' does; under 'priority' keep 1e-06 away",
    ),
    (
        {"robots": {"eve": {"at": [2, 1]}, "mo": {"at": [4, 1]}}, "traffic": {"policy": "reserve"}},
        "robots.mo.at",
        "is one robot too many on lane home-door, which has room for 1 under 'reserve'",
    ),
    ({"traffic": {"policy": "reserves"}}, "traffic.policy", "no traffic policy 'reserves'; did you mean 'reserve'?"),
    ({"traffic": {"policy": "reserve", "patience": 0}}, "traffic.patience", "must be greater than 0, got 0"),
    ({"traffic": {"colour": "red"}}, "traffic.colour", "unknown key 'colour'"),
]


@pytest.mark.parametrize(("fields", "path", "message"), ERRORS, ids=[path for _, path, _ in ERRORS])
def test_error_names_the_field_the_value_and_the_remedy(fields, path, message):
    errors = [(where, text) for severity, where, text in problems(**fields) if severity == "error"]

    assert [(path, True)] == [(where, message in text) for where, text in errors], errors


WARNINGS = [
    ({"places": {"yard": {"at": [50, 2]}}}, "places.yard.at", "(50, 2) is outside the map"),
    ({"items": {"cup": {"at": [-1, 2]}}}, "items.cup.at", "(-1, 2) is outside the map"),
    ({"waypoints": {"far": [50, 1]}, "lanes": [*MAP["lanes"], ["shelf", "far"]]}, "waypoints.far", "outside"),
    ({"walls": [[[7, 0], [7, 2]]]}, "lanes.1", "'door'-'shelf' crosses walls.0; a drawn lane is open all the same"),
    ({"waypoints": {"alone": [5, 5]}}, "waypoints.alone", "no lane leads here"),
    (
        {"waypoints": {"a": [5, 5], "b": [6, 5]}, "lanes": [*MAP["lanes"], ["a", "b"]]},
        "lanes",
        "are 2 parts that no lane connects, with 'home', 'a'",
    ),
    (
        {"docks": {"charger": {"at": [5, 5]}}, "walls": [[[0, 3], [20, 3]]]},
        "docks.charger.at",
        "no way leads to 'charger' at (5, 5) for wall_e; join it with their lanes",
    ),
    ({"doors": {"gate": {"at": [[3, 4], [3, 5]]}}}, "doors.gate.at", "no lane leads through it"),
    (
        {"doors": {"gate": {"at": [[3, 0], [3, 2]], "type": "slidng"}}},
        "doors.gate.type",
        "unusual type 'slidng'; did you mean 'sliding'?",
    ),
    ({"walls": [BOX]}, "robots.wall_e.at", "is inside an obstacle; only its lane leads out"),
]


@pytest.mark.parametrize(("fields", "path", "message"), WARNINGS, ids=[path for _, path, _ in WARNINGS])
def test_unusual_values_are_warnings(fields, path, message):
    found = problems(**fields)

    assert {severity for severity, _, _ in found} == {"warning"}
    assert (path, True) in [(where, message in text) for _, where, text in found]


@pytest.mark.parametrize("kind", ["sliding", "hinged", "door", "swing", "folding", "fire door"])
def test_any_other_type_of_door_is_no_warning(kind):
    assert problems(doors={"gate": {"at": [[3, 0], [3, 2]], "type": kind}}) == []


def test_lanes_in_opposite_directions_are_no_duplicates():
    lanes = [
        {"from": "home", "to": "door", "one_way": True},
        {"from": "door", "to": "home", "one_way": True},
        ["door", "shelf"],
    ]

    assert problems(lanes=lanes) == []


def test_lifts_connect_levels():
    attic = {"waypoints": {"attic": [5, 9]}, "lifts": {"lift": {"stops": ["shelf", "attic"]}}}

    assert problems(**attic) == []


def test_an_error_of_a_type_is_reported_once():
    kind = {"components": {"claw": {"reach": -1}}}
    robot = {"type": "nurse", "at": "home", "components": {"claw": {"max_weight": 1.0}}}

    assert [path for _, path, _ in problems(robot_types={"nurse": kind}, robots={"eve": robot})] == [
        "robot_types.nurse.components.claw.reach"
    ]


@pytest.mark.parametrize("fault", ["claw_misses", "sensor_blind", "slip"])
def test_an_unknown_component_of_a_robot_with_a_fault_is_the_error(fault):
    more = {"factor": 0.5} if fault == "slip" else {}
    with pytest.raises(WorldError) as error:
        world_of(
            {
                "waypoints": {"a": [0, 0]},
                "robots": {"eve": {"at": "a", "components": {"clw": {}}}},
                "faults": [{"type": fault, "robot": "eve", "at": 1, **more}],
            },
            "world.yaml",
        )

    assert ["robots.eve.components.clw"] == [problem.path for problem in error.value.problems]


SCRIPTED = """\
waypoints: {{home: [1, 2], shelf: [9, 2]}}
lanes: [[home, shelf]]
items: {{parcel: {{at: shelf}}}}
robots:
  wall_e:
    at: home
    type: fetcher
    script:
      - Go {place}
      - {second}
"""


def test_every_order_is_checked_with_its_line(errors_of):
    first, second = errors_of(SCRIPTED.format(place="shelv", second="Fly home"))

    assert "9: robots.wall_e.script.0: no waypoint, place or dock 'shelv'; did you mean 'shelf'?" == first
    assert second.startswith("10: robots.wall_e.script.1: no order begins with 'Fly'; there are: Back DISTANCE [SPEED]")


def test_a_robot_needs_the_component_of_an_order(errors_of):
    text = SCRIPTED.format(place="shelf", second="Grab parcel").replace("fetcher", "carrier")

    assert ["10: robots.wall_e.script.1: 'Grab parcel' takes a claw, which wall_e does not have"] == errors_of(text)


def test_errors_that_may_follow_from_others_are_omitted(errors_of):
    text = SCRIPTED.format(place="attic", second="Grab parcel").replace("shelf: [9, 2]", "shelf: [9, 2], attic: [x, 2]")

    assert ["1: waypoints.attic.0"] == [error[: error.index(": expected")] for error in errors_of(text)]

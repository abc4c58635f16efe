"""Loading worlds: finding files, formats, includes, and reporting all errors."""

from __future__ import annotations

import json
import os

import jsonschema
import pytest
import yaml

from hmrsim.errors import WorldError
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world.files import shipped_maps
from hmrsim.world.formats import choose
from hmrsim.world.overlays.overlay import setting
from hmrsim.world_checks import load_world, world_hash
from hmrsim.world_checks.schema import world_schema
from tests.paths import ROOT
from tests.shipped import shipped

MANY = """\
name: many
colour: blue
waypoints: {home: [0, 0], door: [2, x], shelf: [4, 0]}
lanes:
  - [home, door]
  - {from: home, to: shelv, speed_limit: -1}
robots:
  wall_e: {type: nurze, at: home, base: {speed: fast}}
  eve: {at: [0, 0], components: {claw: {reach: -2}}}
seed: 7
seed: 8
"""

KEYS = "name, units, bounds, include, overlay, waypoints, lanes, walls"


def test_all_errors_are_reported_at_once_with_their_lines(errors_of):
    assert errors_of(MANY) == [
        f"2: colour: unknown key 'colour'; there are {KEYS} and 12 more",
        "3: waypoints.door.1: expected a number, got 'x'",
        "6: lanes.1.speed_limit: must be greater than 0, got -1",
        "6: lanes.1.to: no waypoint 'shelv'; did you mean 'shelf'?",
        "8: robots.wall_e.base.speed: expected a number, got 'fast'",
        "8: robots.wall_e.type: no robot type 'nurze'; there are carrier, fetcher",
        "9: robots.eve.components.claw.reach: must be greater than 0, got -2",
        "11: seed: key 'seed' is there twice, first in line 10; keep one",
    ]


def test_invalid_entries_hide_no_errors_of_others(errors_of):
    """Of each kind of entry, one is invalid; its other parts and the other entries are checked all the same."""
    assert errors_of("""\
        waypoints: {a: [0, 0], b: [5, 0], c: [x, 0]}
        lanes: [[a, b], [b, c], [a, d]]
        docks: {dock: {at: [1], reserved_for: [auto]}}
        robots:
          eve: {at: 5, type: fecher, script: [Go d]}
          m_o: {at: a, base: {speed: fast}, script: [Go c, Grab box]}
          vaq: {at: b, script: [Grab box]}
          bob: {at: b, base: {radius: 0.3}}
        items: {box: {at: a, weight: heavy}, bag: {at: d}}
        faults:
          - {type: breakdown, robot: auto, at: soon}
          - {type: claw_drops, robot: m_o}
          - {type: claw_drops, robot: vaq}
          - {type: item_lost, item: mail_1}
        demand:
          - {name: mail, at: d, to: c, arrives: -1}
        traffic: {policy: reserve}
        """) == [
        "1: waypoints.c.0: expected a number, got 'x'",
        "2: lanes.2.to: no waypoint 'd'; there are a, b",
        "3: docks.dock.at: expected [x, y], got 1",
        "3: docks.dock.reserved_for.0: no robot or robot type 'auto'; there are eve, m_o, vaq, bob, carrier, fetcher",
        "5: robots.eve.at: expected [x, y] or a name, got 5",
        "5: robots.eve.type: no robot type 'fecher'; did you mean 'fetcher'?",
        "5: robots.eve.script.0: no waypoint, place or dock 'd'; there are a, b, dock",
        "6: robots.m_o.base.speed: expected a number, got 'fast'",
        "7: robots.vaq.script.0: 'Grab box' takes a claw, which vaq does not have",
        "9: items.box.weight: expected a number, got 'heavy'",
        "9: items.bag.at: no waypoint, place or dock 'd'; there are a, b, dock",
        "11: faults.0.at: expected a number, got 'soon'",
        "11: faults.0.robot: no robot 'auto'; there are eve, m_o, vaq, bob",
        "13: faults.2.robot: vaq has no claw; there are none",
        "16: demand.0.arrives: must be greater than 0, got -1",
        "16: demand.0.at: no waypoint, place or dock 'd'; there are a, b, dock",
    ]


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("robots: {eve: {at: 5}}", "1: robots.eve.at: expected [x, y] or a name, got 5"),
        ("robots: {eve: {}}", "1: robots.eve.at: is missing; expected [x, y] or a name"),
        ("robots: {eve: {at: [1]}}", "1: robots.eve.at: expected [x, y], got 1"),
        ("robots: {eve: {at: [1, 2, 3]}}", "1: robots.eve.at: expected 2 values, got 3"),
        (
            "robots: {-eve: {at: [1, 2]}}",
            "1: robots.-eve: '-eve' is not a ROS name; use a letter, then letters, digits and _; in an overlay, ~rob",
        ),
        ("robots: {_eve: {at: [1, 2]}}", "1: robots._eve: '_eve' is not a ROS name; use a letter, then letters,"),
        ("robots: {eve: {at: [1, 2], sped: 1}}", "1: robots.eve.sped: unknown key 'sped'"),
        ("robots: {eve: {at: [1, 2], base: {sped: 1}}}", "1: robots.eve.base.sped: unknown key 'sped'; did"),
        ("robots: {eve: {at: [1, 2], components: {claw: }}}", ""),
        ("walls: [5]", "1: walls.0: expected a list, got 5"),
        ("walls: [[[0, 0]]]", "1: walls.0: expected at least 2 values, got 1"),
        ("walls: [[[0, 0], [0, 0]]]", "1: walls.0: all its points are (0.0, 0.0)"),
        ("walls: [{solid: [[0, 0], [1, 1]]}]", "1: walls.0.solid: expected at least 3 values, got 2"),
        ("lanes: 5", "1: lanes: expected a list, got 5"),
        ("lanes: [[a]]", "1: lanes.0: a lane is [from, to], got 1 names"),
        ("lanes: [[1, 2]]", "1: lanes.0.from: expected text, got 1; put it in quotes"),
        ("units: feet", "1: units: expected 'm' or 'px', got 'feet'"),
        ("bounds: [0, 0, 1]", "1: bounds: expected [least x, least y, greatest x, greatest y], got 3"),
        ("waypoints:", "1: waypoints: expected a mapping, got nothing"),
        ("waypoints: {a: [1.0e+8, 0]}", "1: waypoints.a.0: must be at most 1e+07, got 100000000.0"),
        ("name: ''", "1: name: is empty; give it a name"),
        ("faults: [{}]", "1: faults.0.type: is missing"),
    ],
)
def test_no_error_mentions_pydantic(write, text, error):
    path = write(text)
    try:
        load_world(path)
        first = ""
    except WorldError as caught:
        first = str(caught.problems[0]).removeprefix(f"{path}:")

    assert first.startswith(error)


@pytest.mark.uncovered
@pytest.mark.parametrize("name", sorted(shipped_maps()))
def test_shipped_worlds_load_without_warnings(name):
    loaded = shipped(name)

    assert loaded.warnings == ()
    jsonschema.validate(yaml.safe_load(loaded.path.read_text(encoding="utf-8")), world_schema())


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nowhere", "nowhere: no such file, and no shipped world of that name; there are cafe, "),
        ("zoo/crossin", "zoo/crossin: no such file, and no shipped world of that name; did you mean 'zoo/crossing'?"),
        ("/nowhere/x", "/nowhere/x: no such file"),
        ("x" * 300, "x" * 300 + ": can't be read: file name too long"),
    ],
)
def test_a_name_that_is_neither_a_file_nor_a_shipped_world_is_an_error(name, message):
    with pytest.raises(WorldError) as error:
        load_world(name)
    assert str(error.value).startswith(message)


def test_file_that_cannot_be_read_is_one_problem(tmp_path):
    (tmp_path / "bytes.yaml").write_bytes(b"name: a\nx: \xff\n")
    (tmp_path / "unknown.txt").write_text("hello", encoding="utf-8")
    os.mkfifo(tmp_path / "pipe.yaml")
    found = {}
    for name in ("missing.yaml", ".", "bytes.yaml", "unknown.txt", "pipe.yaml", "nul\0.yaml"):
        with pytest.raises(WorldError) as caught:
            load_world(tmp_path / name)
        (problem,) = caught.value.problems
        found[name] = (problem.line, problem.message.partition("; ")[0])

    assert found == {
        "missing.yaml": (None, "no such file"),
        ".": (None, "is a folder"),
        "bytes.yaml": (2, "is not UTF-8: byte 0xff"),
        "unknown.txt": (None, "is of no known format"),
        "pipe.yaml": (None, "is not a regular file"),
        "nul\0.yaml": (None, "can't be read: its name has a null character"),
    }


def test_file_that_is_too_large_is_rejected(tmp_path):
    path = tmp_path / "large.yaml"
    with path.open("wb") as stream:
        stream.truncate(16 * 1024 * 1024 + 1)

    with pytest.raises(WorldError, match="is larger than 16 MiB"):
        load_world(path)


def test_equal_worlds_have_one_hash(load):
    one = load("seed: 1\nwaypoints: {a: [0, 0], b: [1, 0]}\n", "one.yaml").hash
    same = load('{"waypoints": {"b": [1.0, 0], "a": [0, 0]}, "seed": 1}', "same.json").hash
    other = load("seed: 2\nwaypoints: {a: [0, 0], b: [1, 0]}\n", "other.yaml").hash

    assert (len(one), one == same, one == other) == (64, True, False)


def test_worlds_of_one_file_share_what_no_overlay_changes(write):
    """Data that is derived from the same fields, such as the road map, is then derived once."""
    path = write("waypoints: {a: [0, 0], b: [1, 0]}\nlanes: [[a, b]]\nrobots: {eve: {at: a}}\n")
    plain = load_world(path).world
    moved, _, again = (load_world(path, overlays=[setting(f"robots.eve.at={at}")]).world for at in ("b", "a", "b"))

    assert moved.lanes is plain.lanes is again.lanes
    assert (plain.robots["eve"].at, moved.robots["eve"].at, again.robots["eve"].at) == ("a", "b", "b")
    assert world_hash(moved) == world_hash(again) != world_hash(plain)


def test_the_hash_depends_on_faults(load):
    text = "waypoints: {a: [0, 0], b: [1, 0]}\nlanes: [[a, b]]\nrobots: {eve: {at: a}}\n"
    reported = "{type: slip, robot: eve, factor: 0.5, at: 1.0}"
    plain, faulty = load(text, "plain.yaml"), load(f"{text}faults: [{reported}]\n", "plain.yaml")
    before = plain.hash
    added = plain.world.model_copy(update={"faults": faulty.world.faults})

    assert world_hash(added) == faulty.hash != before == world_hash(plain.world)


def test_a_misspelled_key_is_the_only_error(errors_of):
    errors = errors_of("""\
        waypoint: {a: [0, 0], b: [5, 0]}
        lanes: [[a, b]]
        robots: {eve: {at: a, script: [Go b]}}
        """)
    assert errors == ["1: waypoint: unknown key 'waypoint'; did you mean 'waypoints'?"]

    errors = errors_of("includes: [cafe]\nrobots: {eve: {at: hall, type: waiter}}\n")
    assert errors == ["1: includes: unknown key 'includes'; did you mean 'include'?"]


def test_a_dock_at_an_unknown_place_is_the_only_error(errors_of):
    assert errors_of("""\
        waypoints: {a: [0, 0], b: [5, 0]}
        lanes: [[a, b]]
        docks: {charger: {at: c}}
        robots: {eve: {at: charger, script: [Go charger, Dock charger]}}
        items: {box: {at: charger}}
        demand: [{name: mail, at: charger, to: a, arrives: 5}]
        """) == ["3: docks.charger.at: no waypoint or place 'c'; there are a, b"]


def test_included_files_are_united(write):
    write("name: floor\nseed: 1\nwaypoints: {a: [0, 0], b: [1, 0]}\nlanes: [[a, b]]\n", "parts/floor.yaml")
    path = write("seed: 2\ninclude: [parts/floor.yaml]\nwaypoints: {c: [2, 0]}\nlanes: [[b, c]]\n")

    world = load_world(path).world

    assert (world.name, world.seed, sorted(world.waypoints)) == ("floor", 2, ["a", "b", "c"])
    assert [(lane.from_, lane.to) for lane in world.lanes] == [("b", "c"), ("a", "b")]


def test_error_in_an_included_file_names_that_file_and_its_line(write):
    floor = write("waypoints: {a: [0, 0]}\nlanes:\n  - [a, nowhere]\n", "floor.yaml")
    path = write("include: [floor.yaml]\nwaypoints: {b: [1, 1]}\nlanes: [[a, b]]\n")

    with pytest.raises(WorldError) as caught:
        load_world(path)

    assert str(caught.value.problems[0]) == f"{floor}:3: lanes.0.to: no waypoint 'nowhere'; there are b, a"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("world.yaml", "'world.yaml' includes this file in turn"),
        ("../outside.yaml", "'../outside.yaml' is outside the folder of this file"),
        ("/etc/hostname", "'/etc/hostname' is outside the folder of this file"),
        ("link.yaml", "'link.yaml' is outside the folder of this file"),
        ("loop.yaml", "'world.yaml' includes this file in turn"),
        ("twice.yaml", "'a' is in "),
        ("missing.yaml", "no such file"),
        ("hospita", "'hospita' is neither a file nor a shipped world; did you mean 'hospital'?"),
        ("../beside", "'../beside' is outside the folder of this file"),
        ("pixels.yaml", "'px' can't be joined with 'm'"),
        ("broken.yaml", "is not valid YAML"),
    ],
)
def test_impossible_includes_are_rejected(write, name, message):
    outside = write("name: outside\n", "outside.yaml")
    write("include: [world.yaml]\n", "inside/loop.yaml")
    write("waypoints: {a: [0, 0]}\n", "inside/twice.yaml")
    write("units: px\n", "inside/pixels.yaml")
    write("name: [", "inside/broken.yaml")
    path = write(f"units: m\ninclude: [{name}]\nwaypoints: {{a: [0, 0]}}\n", "inside/world.yaml")
    (path.parent / "link.yaml").symlink_to(outside)

    with pytest.raises(WorldError) as caught:
        load_world(path)

    assert [message in str(problem) for problem in caught.value.problems] == [True]


def test_a_shipped_world_is_included_by_its_name(write):
    path = write("include: [cafe]\nrobots: {flat_white: {type: waiter, at: hall}}\n")

    assert ["flat_white", "mocha", "latte", "chai"] == [*load_world(path).world.robots]
    write("waypoints: {a: [0, 0]}", "cafe/beside.yaml")
    with pytest.raises(WorldError, match=r":1: include\.0: .*cafe: is a folder"):
        load_world(path)


def test_a_world_includes_100_files_at_most(write):
    for number in range(100):
        write("{}", f"part{number}.yaml")
        write(f"include: [link{number + 1}.yaml]\n", f"link{number}.yaml")
    many = write(f"include: [{', '.join(f'part{number}.yaml' for number in range(100))}]\n", "many.yaml")
    deep = write("include: [link0.yaml]\n", "deep.yaml")
    missing = write(f"include: [{', '.join(['nothing'] * 101)}]\n", "missing.yaml")

    for path, message in (
        (many, "exceeds the maximum of 100 files"),
        (deep, "deep; at most 10"),
        (missing, r"^.*:1: include: names 101 files; a world includes at most 100$"),
    ):
        with pytest.raises(WorldError, match=message):
            load_world(path)


@pytest.mark.parametrize(
    ("include", "message"),
    [
        ("[floor.yaml]", "include.0: FOLDER/floor.yaml: no such file"),
        ("floor.yaml", "include: expected a list of files, got 'floor.yaml'"),
    ],
)
def test_an_invalid_include_is_the_only_error(errors_of, tmp_path, include, message):
    """The missing file might define the names that other files and overlays use."""
    errors = errors_of(f"""\
        units: m
        include: {include}
        lanes: [[a, b]]
        robots: {{eve: {{at: a, type: nurse}}}}
        overlay: {{robot_types.nurse.base.speed: 2, lanes.7.speed_limit: 1, ~docks.*: null}}
        """)

    assert errors == [f"2: {message}".replace("FOLDER", str(tmp_path))]


def test_robots_and_items_can_be_added(write):
    path = write("waypoints: {a: [0, 0]}\n")

    world = load_world(path, add_robots=["eve@1,2", "wall_e@-1.5,1e1:fetcher"], add_items=["cup@1,2:0.5"]).world

    assert [(name, robot.at, robot.type) for name, robot in world.robots.items()] == [
        ("eve", (1.0, 2.0), "carrier"),
        ("wall_e", (-1.5, 10.0), "fetcher"),
    ]
    assert [(name, item.at, item.weight) for name, item in world.items.items()] == [("cup", (1.0, 2.0), 0.5)]


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ("eve", "--robot eve: expected NAME@X,Y or NAME@X,Y:TYPE"),
        ("eve@1;2", "--robot eve@1;2: expected NAME@X,Y or NAME@X,Y:TYPE"),
        ("eve@1,2:nurse", "--robot eve@1,2:nurse: robots.eve.type: no robot type 'nurse'; there are carrier, fetcher"),
        ("wall_e@1,2", "--robot wall_e@1,2: robots.wall_e: 'wall_e' is in "),
        ("e-v@1,2", "--robot e-v@1,2: robots.e-v: 'e-v' is not a ROS name"),
    ],
)
def test_robot_that_cannot_be_added_is_rejected(write, robot, message):
    path = write("robots: {wall_e: {at: [0, 0]}}\n")

    with pytest.raises(WorldError) as caught:
        load_world(path, add_robots=[robot])

    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("name", "start", "legs"),
    [
        ("scenario1", (515.0, 80.0), [((512.0, 215.0), 532), ((100.0, 180.0), 617)]),
        ("scenario2", (78.0, 86.0), [((450.0, 330.0), 616)]),
    ],
)
def test_scenarios_can_be_driven(name, start, legs):
    world = shipped(name).world
    graph, here = WaypointGraph(world), world.point(world.robots["wall_e"].at)

    assert start == here
    for goal, length in legs:
        assert length == round(graph.plan(here, goal, 300.0).length)
        here = goal


def test_each_item_of_the_hospital_is_in_reach_of_a_place():
    world = shipped("hospital").world
    places = [place.at for place in world.places.values()]

    reach = [min(abs(complex(*item.at) - complex(*place)) for place in places) for item in world.items.values()]
    assert max(reach) < 0.9


def test_the_schema_in_the_repository_is_up_to_date():
    path = ROOT / "schemas" / "world.schema.json"

    assert json.loads(path.read_text(encoding="utf-8")) == world_schema()


NOTHING = {
    "drawio": "<mxGraphModel><root/></mxGraphModel>",
    "geojson": '{"features": [],\n "type" :\n"FeatureCollection"}',
    "rmf_building": "name: office\nlevels:\n  L1:\n    lanes: []\n",
    "lif": '{"metaInformation": {"projectIdentification": "p", "lifVersion": "1.0.0"}, "layouts": []}',
    "movingai": "type octile\nheight 1\nwidth 2\nmap\n..\n",
    "native": "name: office\n",
}


@pytest.mark.parametrize("name", ["world.json", "world.yaml", "world.map", "world.geojson", "world.txt"])
@pytest.mark.parametrize("kind", NOTHING)
def test_the_content_decides_on_the_format(kind, name):
    assert kind == choose(name, NOTHING[kind]).name


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("a.building.yaml", "rmf_building"),
        ("a.lif.json", "lif"),
        ("A.LIF.JSON", "lif"),
        ("a.geojson", "geojson"),
        ("a.map", "movingai"),
        ("a.drawio", "drawio"),
        ("a.yaml", "native"),
    ],
)
def test_the_longest_suffix_decides_if_the_content_does_not(name, kind):
    assert kind == choose(name, "?").name


def test_native_file_is_not_taken_for_another(load):
    text = "name: levels\nplaces: {FeatureCollection: {at: [0, 0]}, layouts: {at: [1, 1]}}\n"

    assert "levels" == load(text, "office.building.yaml").world.name


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "latin-1"])
def test_other_encodings_are_reported_with_a_remedy(tmp_path, encoding):
    path = tmp_path / "world.yaml"
    path.write_bytes("name: \u00e4".encode(encoding))

    with pytest.raises(WorldError, match=r"is not UTF-8: byte 0x[0-9a-f]{2}; save it as UTF-8$"):
        load_world(path)


def test_empty_name_is_reported():
    with pytest.raises(WorldError, match=r"^the name of the world is empty; expected a file, or the name of a shipped"):
        load_world("")

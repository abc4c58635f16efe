"""Changes of a world by path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from hmrsim.errors import WorldError
from hmrsim.world.overlays.overlay import overlay_of, overlays_of, read_overlay, setting
from hmrsim.world_checks import load_world
from hmrsim.world_checks.loading import world_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.world import World

TWO = {
    "waypoints": {"home": [0, 0], "shelf": [10, 0], "ward.1": [20, 0]},
    "lanes": [["home", "shelf"], ["shelf", "ward.1"]],
    "items": {"box": {"at": "shelf"}},
    "docks": {"charger": {"at": "home", "type": "charger", "capacity": 2}},
    "robot_types": {"nurse": {"components": {"battery": {"capacity": 100}, "claw": {}}}},
    "robots": {"eve": {"at": "home", "type": "nurse"}, "wall_e": {"at": "shelf"}},
    "faults": [{"type": "slip", "robot": "eve", "factor": 0.5, "at": 3}],
}


def laid(*changes: dict[str, object]) -> World:
    """Return the world after applying overlays."""
    return world_of(TWO, "two.yaml", [overlay_of(each, f"overlay {i}") for i, each in enumerate(changes)])


def problems(*changes: dict[str, object]) -> list[str]:
    with pytest.raises(WorldError) as error:
        laid(*changes)
    return [str(problem) for problem in error.value.problems]


def test_a_path_changes_one_value_and_a_pattern_several() -> None:
    world = laid({"robots.eve.base.speed": 0.5, "robots.*.yaw": 1.5})
    assert (world.robots["eve"].base.speed, world.robots["wall_e"].base.speed) == (0.5, None)
    assert {robot.yaw for robot in world.robots.values()} == {1.5}


def test_a_mapping_continues_the_path_and_keeps_other_entries() -> None:
    world = laid({"robots": {"eve": {"components": {"battery.initial_charge": 0.3}}}})
    assert world.robot_type(world.robots["eve"]).components["battery"] == {"capacity": 100, "initial_charge": 0.3}


def test_entries_are_added_and_removed() -> None:
    world = laid(
        {
            "items.second": {"at": "home", "weight": 1.0},
            "~robots.wall_e": None,
            "faults.+": [{"type": "breakdown", "robot": "eve", "at": 9}],
            "lanes.+": {"from": "home", "to": "ward.1"},
            "~faults.0": None,
        }
    )
    assert [*world.items] == ["box", "second"]
    assert [*world.robots] == ["eve"]
    assert [fault.type for fault in world.faults] == ["breakdown"]
    assert len(world.lanes) == 3


def test_a_path_can_lead_into_short_forms() -> None:
    world = laid({"lanes.*.speed_limit": 0.4, "waypoints.home.capacity": 3, "waypoints.'ward.1'.capacity": 1})
    assert {lane.speed_limit for lane in world.lanes} == {0.4}
    assert (world.lanes[1].from_, world.points["ward.1"]) == ("shelf", (20.0, 0.0))


def test_a_later_overlay_wins_and_the_base_is_unchanged() -> None:
    assert laid({"seed": 1}, {"seed": 2}).seed == 2
    laid({"robots.*.yaw": 1.0, "faults.0.factor": 0.1})
    assert TWO["robots"] == {"eve": {"at": "home", "type": "nurse"}, "wall_e": {"at": "shelf"}}
    assert TWO["faults"] == [{"type": "slip", "robot": "eve", "factor": 0.5, "at": 3}]


def test_each_repeats_its_entries() -> None:
    world = laid(
        {
            "each 1..3": {"items.box$i": {"at": "home", "weight": "${i / 2}"}},
            "each robot in eve, wall_e": {"robots.$robot.tags": ["is $robot", "$$"]},
        }
    )
    assert {name: item.weight for name, item in world.items.items()} == {"box": 0, "box1": 0.5, "box2": 1, "box3": 1.5}
    assert world.robots["wall_e"].tags == ("is wall_e", "$")


def test_an_entry_of_a_list_can_be_given_by_its_name() -> None:
    order = {"at": "a", "to": "b", "arrives": 10}
    world = world_of(
        {"waypoints": {"a": [0, 0], "b": [1, 0]}, "demand": [{"name": name, **order} for name in ("x", "y", "z")]},
        "orders.yaml",
        [overlay_of({"~demand.x": None, "demand.z.weight": 2}, "one")],
    )
    assert {demand.name: demand.weight for demand in world.demand} == {"y": 0, "z": 2}


def test_a_distribution_replaces_another_value_as_a_whole() -> None:
    world = world_of(
        {"doors": {"d": {"at": [[0, 0], [1, 0]]}}},
        "doors.yaml",
        [
            overlay_of({"doors.d.opening_time": {"uniform": {"low": 1, "high": 2}}}, "one"),
            overlay_of({"doors.*.opening_time": {"exponential": {"mean": 3}}}, "two"),
        ],
    )
    assert world.doors["d"].opening_time.model_dump(exclude_defaults=True) == {"exponential": {"mean": 3.0}}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robots.evv.yaw": 1}, "there is no 'evv' among the robots; did you mean 'eve'?"),
        ({"robots.x*.yaw": 1}, "robots has nothing that x* stands for; it has eve, wall_e"),
        ({"lanes.7.speed_limit": 1}, "lanes is a list of 2, in which '7' is no index or name; expected 0 to 1, a name"),
        ({"faults.x.at": 1}, "faults is a list of 1, in which 'x' is no index or name"),
        ({"~items.vase": None}, "items has no 'vase' to take away; it has box"),
        ({"~items.box": 1}, "takes an entry away, so that it has no value; got 1"),
        ({"robots..yaw": 1}, "'robots..yaw' is no path"),
        ({"robots.eve.base.speed": "fast"}, "robots.eve.base.speed: expected a number, got 'fast'"),
        ({"robots.eve.base.sped": 1}, "robots.eve.base.sped: unknown key 'sped'; did you mean 'speed'?"),
        ({"robots.new": {"type": "nurse"}}, "robots.new.at: is missing"),
        ({"each 3..1": {"seed": 1}}, "3..1 runs over nothing"),
        ({"each 1..2": 5}, "expected a mapping to repeat, got 5"),
        ({"seed": "${levels.a}"}, "${levels.a}: there is no 'levels'"),
        ({"seed": "${1 / 0}"}, "division by zero"),
        ({"seed": "${open('x')}"}, "'open' is called, but an expression has no functions"),
        ({"seed": "${1 if 2 else 3}"}, "is more than names, keys, numbers"),
        ({"seed": "${1 +}"}, "is no expression"),
        ({"items.box.at": "nowhere"}, "items.box.at: no waypoint, place or dock 'nowhere'"),
    ],
)
def test_errors_name_the_overlay(change: dict[str, object], message: str) -> None:
    found = problems({"name": "fine"}, change)
    assert len(found) == 1
    assert found[0].startswith("overlay 1: ")
    assert message in found[0]


def test_all_errors_are_reported_at_once() -> None:
    assert len(problems({"robots.evv.yaw": 1, "seed": "x"}, {"~items.vase": None})) == 3


def test_a_file_takes_values_from_tables(tmp_path: Path) -> None:
    (tmp_path / "levels.csv").write_text("level,charge,skills\nlow,0.2,a\nhigh,0.9,b\n", encoding="utf-8")
    (tmp_path / "places.json").write_text('["shelf", "home"]', encoding="utf-8")
    (tmp_path / "over.yaml").write_text(
        "tables: {levels: levels.csv, places: places.json}\n"
        "robots.eve.components.battery.initial_charge: ${levels.high.charge}\n"
        "items.box.at: ${places[1]}\n"
        "each level in ${levels}:\n"
        "  robots.eve.tags.+: ${levels[level].skills}\n",
        encoding="utf-8",
    )
    (tmp_path / "two.yaml").write_text(str(TWO).replace("'", '"'), encoding="utf-8")
    world = load_world(tmp_path / "two.yaml", overlays=[read_overlay(tmp_path / "over.yaml")]).world
    assert world.robots["eve"].components["battery"] == {"initial_charge": 0.9}
    assert (world.items["box"].at, world.robots["eve"].tags) == ("home", ("a", "b"))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("a,b\nx,1\nx,2\n", "levels.csv:3: there is a row 'x' already"),
        ("a,b\nx,1,2\n", "levels.csv:2: the row has 3 fields, the first line 2"),
        ("", "levels.csv:1: is empty"),
        (None, "levels.csv: no such file"),
    ],
)
def test_errors_of_a_table_have_their_line(tmp_path: Path, table: str | None, message: str) -> None:
    if table is not None:
        (tmp_path / "levels.csv").write_text(table, encoding="utf-8")
    (tmp_path / "over.yaml").write_text("seed: 1\ntables: {levels: levels.csv}\n", encoding="utf-8")
    with pytest.raises(WorldError) as error:
        read_overlay(tmp_path / "over.yaml")
    assert str(error.value).startswith(f"{tmp_path / 'over.yaml'}:2: tables.levels: ")
    assert message in str(error.value)


def test_an_option_sets_or_removes_one_entry() -> None:
    changes = [setting("robots.eve.base={speed: 0.5, radius: 0.2}"), setting("~robots.wall_e"), setting("name=x=y")]
    world = world_of(TWO, "two.yaml", changes)
    assert (world.robots["eve"].base.speed, [*world.robots], world.name) == (0.5, ["eve"], "x=y")


@pytest.mark.parametrize("text", ["", "seed", "=3", "~seed=3", "seed=[1", "seed={a: 1, a: 2}"])
def test_all_invalid_options_are_reported(text: str) -> None:
    with pytest.raises(WorldError) as error:
        overlays_of(["/nowhere/over.yaml"], ["seed=1", text])
    assert [problem.file for problem in error.value.problems] == ["/nowhere/over.yaml", f"--set {text}"]


def test_a_file_applies_its_overlay_to_its_includes(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text(str(TWO).replace("'", '"'), encoding="utf-8")
    (tmp_path / "mid.yaml").write_text("include: [base.yaml]\noverlay: {seed: 1, name: mid}\n", encoding="utf-8")
    (tmp_path / "top.yaml").write_text("include: [mid.yaml]\noverlay:\n  name: top\n  ~items.*:\n", encoding="utf-8")
    world = load_world(tmp_path / "top.yaml", overlays=[setting("faults=[]")]).world
    assert (world.seed, world.name, dict(world.items), world.faults) == (1, "top", {}, ())
    (tmp_path / "top.yaml").write_text("include: [mid.yaml]\noverlay:\n  robots.nobody.yaw: 1\n", encoding="utf-8")
    with pytest.raises(WorldError, match=r"top\.yaml:3: robots\.nobody\.yaw: there is no 'nobody'"):
        load_world(tmp_path / "top.yaml")
    (tmp_path / "top.yaml").write_text("include: [mid.yaml]\noverlay: 3\n", encoding="utf-8")
    with pytest.raises(WorldError, match=r"top\.yaml:2: overlay: expected a mapping"):
        load_world(tmp_path / "top.yaml")


TIMES = "each i in 1..10000"
WIDE = {f"places.p{i}": {"at": [i, 0], "tags": ["a"] * 20} for i in range(1_000)}


@pytest.mark.parametrize(
    "change",
    [
        {TIMES: {"each j in 1..10000": {"waypoints.w_${i}_${j}": [0, 1]}}},
        {TIMES: {"each j in 1..10000": {}}},
        {TIMES: {"each j in 1..10000": {"waypoints.w_${i}_${j}.at": [0, 1]}}},
        WIDE | {TIMES: {"places.*.at": [0, 1]}},
        WIDE | {TIMES: {"~places.*z": None}},
        WIDE | {TIMES: {"pl*.*.at": [0, 1]}},
        WIDE | {"places.*.tags": ["b"] * 1_000},
        {TIMES: {"lanes.+": [["home", "shelf"]] * 1_000}},
        {TIMES: {"name": "x" * 100_000}},
        {TIMES: {f"each name in {'x' * 900}": {"name": "$name" * 10}}},
        {TIMES: {f"each name in {'x' * 900}": {"items." + "$name" * 10: {"at": "home"}}}},
    ],
    ids=["each", "nothing", "errors", "pattern", "remove", "nested", "copies", "append", "text", "names", "keys"],
)
def test_repetitions_are_limited(change: dict[str, object]) -> None:
    """A client could send a hundred bytes that ask for a hundred million waypoints."""
    *_, problem = problems(change)

    assert "the overlays of a world ask for more than 1,000,000 changes in all" in problem


def test_lanes_that_are_added_one_by_one_count_once_each() -> None:
    world = laid({"each i in 1..2000": {"waypoints.w${i}": ["$i", 1], "lanes.+": [["home", "w${i}"]]}})

    assert 2_002 == len(world.lanes)


def test_the_limit_counts_all_overlays_together() -> None:
    many = {f"places.p{i}": {"at": [i, 0]} for i in range(1_000)}
    half = {"each i in 1..150": {"places.*.at": [0, "$i"]}}

    laid(many, half)
    assert "overlay 2" in problems(many, half, half)[0]


def test_a_path_has_a_maximum_of_steps() -> None:
    deep: dict[str, object] = {"x": 1}
    for _ in range(50):
        deep = {"x": deep}

    assert "leads through 1001 entries; at most 50" in problems({"a." * 1_000 + "b": 1})[0]
    assert "leads through 51 entries; at most 50" in problems(deep)[0]


@pytest.mark.parametrize(
    ("path", "why"),
    [
        ("lanes.0.from", "lanes.0.to: is missing"),
        ("faults.0.at.mean", "faults.0.type: is missing"),
        ("name.x", "name: "),
    ],
)
def test_a_path_through_a_value_without_entries_replaces_it(path: str, why: str) -> None:
    flat = {**TWO, "lanes": [5, ["home", "shelf"]], "faults": [True]}
    with pytest.raises(WorldError) as error:
        world_of(flat, "flat.yaml", [overlay_of({path: "home"}, "overlay")])

    assert why in str(error.value)


def test_the_length_of_expanded_text_is_limited() -> None:
    assert (
        "becomes a text of more than 10,000 characters" in problems({f"each i in {'x' * 600}": {"name": "$i" * 20}})[0]
    )


def test_errors_name_the_last_change_of_a_value() -> None:
    inner, outer = {"robots.eve.yaw": "north"}, {"robots.eve": {"at": "home", "yaw": "north"}}
    assert [["overlay 1"], ["overlay 1"]] == [
        [problem.split(":")[0] for problem in problems(*order)] for order in ((inner, outer), (outer, inner))
    ]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (f"seed=${{{'9' * 400}*1}}", "int too large to convert to float"),
        (f"seed=${{{'~' * 490}1}}", "is nested deeper than 100"),
        ("seed=${a\udcff}", "has bytes that are no text in UTF-8: '\\udcff'"),
    ],
)
def test_an_expression_without_a_value_is_an_error_with_its_place(text: str, why: str) -> None:
    with pytest.raises(WorldError) as error:
        world_of(TWO, "two.yaml", [setting(text)])
    (problem,) = error.value.problems
    assert (f"--set {text}", True) == (problem.file, why in problem.message)


def test_an_invalid_step_of_a_path_is_an_error_of_the_overlay() -> None:
    assert problems({"robots.eve.bse.speed": 2}) == [
        "overlay 0: robots.eve.bse: unknown key 'bse'; did you mean 'base'?"
    ]

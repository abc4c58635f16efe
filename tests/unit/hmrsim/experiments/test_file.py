"""The file of an experiment: designs, seeds and errors."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING, Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import ExperimentError
from hmrsim.experiments.checking import check_file
from hmrsim.experiments.model import ExperimentFile
from hmrsim.experiments.plan import scenarios_of
from hmrsim.experiments.reading import read_plan

if TYPE_CHECKING:
    from pathlib import Path

FILE: dict[str, Any] = {
    "name": "pace",
    "world": "zoo/crossing",
    "factors": {"speed": [0.5, 1.0], "load": ["none", "some", "much"]},
    "treatments": {"go": {"tree": "bt_controller.examples.hospital:mission"}},
    "measures": {"time": "end.at"},
}


GO = FILE["treatments"]["go"]


def written(folder: Path, **changes: Any) -> Path:
    """Return the path of a written experiment file."""
    path = folder / "pace.yaml"
    content = {key: value for key, value in {**FILE, **changes}.items() if value is not None}
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path


def problems(path: Path) -> list[str]:
    """Return the errors of a file, without its name."""
    with pytest.raises(ExperimentError) as error:
        check_file(path)
    return [str(problem).removeprefix(f"{path}:") for problem in error.value.problems]


def test_list_in_place_of_a_mapping_is_an_error_of_the_world(tmp_path: Path) -> None:
    (tmp_path / "shop.yaml").write_text("waypoints: {a: [0, 0]}\nplaces: {shelf: [10, 1.2]}\nrobots: {r: {at: a}}\n")
    path = written(tmp_path, world="shop.yaml", factors={})

    with pytest.raises(ExperimentError) as error:
        check_file(path)
    (problem,) = error.value.problems
    assert "places.shelf: expected a mapping, got [10, 1.2] (scenario 0)" in str(problem)


def test_a_name_with_a_space(tmp_path: Path) -> None:
    path = written(tmp_path, name="second waiter")

    assert ["1: name: 'second waiter' is not a ROS name; use a letter, then letters, digits and _"] == problems(path)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"ends": {"served": {"orders": "served"}}}, 1),
        ({"ends": {"served": {"orders": "served"}}, "successes": ["served"]}, 0),
        ({"ends": {"success": {"orders": "served"}}}, 0),
        ({"ends": {"flat": {"event": "battery_empty"}}, "successes": ["succeeded"]}, 0),
        ({}, 0),
    ],
)
def test_warns_if_no_ending_is_a_success(tmp_path: Path, changes: dict[str, Any], told: int) -> None:
    changes["world"] = "warehouse_orders"
    path = written(tmp_path, factors={}, **changes)

    said = f"{path}: ends: a run that ends as served is no success; if it should be one, add successes: [served]"
    assert [said] * told == [str(problem) for problem in check_file(path)[1]]


TREE = {"tree": "bt_controller.examples.hospital:mission", "set": {"speed": "$speed"}}
TWO = {"a": TREE, "b": TREE}
FACTORS = {"speed": [1, 2, 3]}
UNTIL = {"measure": "time", "decided": True}


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"factors": {"speed": [1], "load": [1]}, "overlay": {"robots.*.base.speed": "${speed * load}"}}, []),
        (
            {"factors": {"speed": [1], "load": [1, 2]}, "overlay": {"robots.*.base.speed": "$speed"}},
            ["factors.load: nothing asks for $load, so that its levels differ by chance alone; use it in the overlay"],
        ),
        (
            {"treatments": TWO, "factors": FACTORS, "replications": {"max": 9, "until": UNTIL}},
            ["replications.max: nothing is decided before 30 pairs of runs, unless time is 0 or 1; make it 10 or more"],
        ),
        ({"treatments": TWO, "factors": FACTORS, "replications": {"max": 10, "until": UNTIL}}, []),
        (
            {"factors": {"load": [1]}, "variants": {"odd": {"robots.*.base.speed": "${1 +}"}}},
            [],
        ),
        (
            {"factors": {}, "measures": {"m": "robots.marvin.energy"}},
            ["measures.m: robots has no 'marvin'; it has eastbound, northbound, southbound, westbound"],
        ),
        (
            {
                "factors": {},
                "measures": {
                    "energy": "1 / energy",
                    "lead": "orders.lead_time.mean",
                    "traffic": "orders.delay.traffic",
                    "told": "reported.rounds",
                    "docked": "report.events.dock_docked",
                    "first": "report.robots[0].distance",
                    "crashed": "ends.crashed",
                },
            },
            [],
        ),
    ],
)
def test_warns_of_unused_factors_and_unknown_robots(tmp_path: Path, changes: dict[str, Any], said: list[str]) -> None:
    """A robot may be spawned during a run."""
    path = written(tmp_path, **changes)

    assert [f"{path}: {each}" for each in said] == [str(problem) for problem in check_file(path)[1]]


def scenarios(**changes: Any) -> list[dict[str, Any]]:
    """Return the scenarios of a file."""
    return scenarios_of(ExperimentFile.model_validate({**FILE, **changes}))


def test_a_full_design_has_all_combinations() -> None:
    found = scenarios()
    assert len(found) == 6
    assert found[:2] == [{"speed": 0.5, "load": "none"}, {"speed": 0.5, "load": "some"}]


def test_one_at_a_time_varies_each_factor_from_the_first_levels() -> None:
    assert scenarios(design="one_at_a_time") == [
        {"speed": 0.5, "load": "none"},
        {"speed": 1.0, "load": "none"},
        {"speed": 0.5, "load": "some"},
        {"speed": 0.5, "load": "much"},
    ]


def test_without_factors_there_is_one_scenario() -> None:
    assert scenarios(factors={}) == [{}]


@given(count=st.integers(1, 60), seed=st.integers(0, 99))
def test_a_latin_hypercube_takes_each_part_of_each_range_once(count: int, seed: int) -> None:
    factors = {"a": {"low": 2.0, "high": 4.0}, "b": {"low": 1, "high": count, "whole": True}, "c": ["x", "y"]}
    found = scenarios(factors=factors, design={"latin_hypercube": count}, seed=seed) if count > 1 else []
    if not found:
        return
    assert sorted(int((each["a"] - 2.0) / 2.0 * count) for each in found) == [*range(count)]
    assert sorted(each["b"] for each in found) == [*range(1, count + 1)]
    counts = Counter(each["c"] for each in found)
    assert abs(counts["x"] - counts["y"]) <= 1
    assert found == scenarios(factors=factors, design={"latin_hypercube": count}, seed=seed)


def test_a_list_is_rows_of_a_table(tmp_path: Path) -> None:
    (tmp_path / "trials.csv").write_text("load,speed,more\nnone,0.7,1\nmuch,0.9,2\n", encoding="utf-8")
    plan = read_plan(written(tmp_path, design={"list": "trials.csv"}))
    assert plan.scenarios == [{"speed": 0.7, "load": "none"}, {"speed": 0.9, "load": "much"}]
    rows = [{"speed": 1, "load": "none"}]
    assert read_plan(written(tmp_path, design={"list": rows})).scenarios == rows


def test_treatments_share_seeds_and_nothing_else_decides_them(tmp_path: Path) -> None:
    tree = FILE["treatments"]["go"]
    plan = read_plan(written(tmp_path, treatments={"a": tree, "b": tree}, replications=3))
    runs = [plan.run_of(number) for number in range(36)]
    assert plan.run_of(36) is None
    assert [run.number for run in runs if run] == [*range(36)]
    seeds = {(run.scenario, run.replication): set() for run in runs if run}
    for run in runs:
        if run:
            seeds[run.scenario, run.replication].add(run.seed)
    assert {len(each) for each in seeds.values()} == {1}
    assert len({next(iter(each)) for each in seeds.values()}) == 18
    alone = read_plan(written(tmp_path, replications=9))
    assert alone.run(4, "go", 2).seed == plan.run(4, "b", 2).seed
    other = read_plan(written(tmp_path, seed=1))
    assert other.run(4, "go", 0).seed != alone.run(4, "go", 0).seed


def test_overlays_take_levels_tables_and_variants(tmp_path: Path) -> None:
    (tmp_path / "levels.json").write_text(json.dumps({"load": {"none": 0, "some": 2, "much": 9}}), encoding="utf-8")
    path = written(
        tmp_path,
        levels="levels.json",
        overlay={"robots.*.base.speed": "$speed", "items.box": {"at": [0, 0], "weight": "${levels.load[load]}"}},
        variants={"heavy": {"items.box.weight": 99}},
    )
    plan = read_plan(path)
    worlds = [plan.world(i).world for i in range(6)]
    assert [next(iter(world.robots.values())).base.speed for world in worlds] == [0.5] * 3 + [1.0] * 3
    assert [world.items["box"].weight for world in worlds[:3]] == [0, 2, 9]
    heavy = read_plan(path, ["heavy"])
    assert heavy.world(0).world.items["box"].weight == 99
    assert heavy.hash != plan.hash


def test_reports_all_errors_of_form_with_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "pace.yaml"
    path.write_text(
        "name: a b\n"
        "wrld: hospital\n"
        "treatments:\n"
        "  a: {tre: x}\n"
        "  b: {tree: x, command: y}\n"
        "replications: {min: 5, max: 2}\n"
        "limits: {wall: -1, memory: lots}\n"
        "ends: {done: {item: x}}\n"
        "measures: {time: {valu: end.at}}\n"
        "keep: {traces: some}\n",
        encoding="utf-8",
    )
    found = problems(path)
    assert [int(each.partition(":")[0]) for each in found] == sorted(int(each.partition(":")[0]) for each in found)
    said = "\n".join(found)
    for expected in (
        "1: name: ",
        "2: wrld: unknown key 'wrld'; did you mean 'world'?",
        "world: is missing",
        "4: treatments.a.tre: unknown key 'tre'; did you mean 'tree'?",
        "5: treatments.b: expected one of tree, python and command",
        "6: replications: min 5 is more than max 2",
        "7: limits.wall: must be greater than 0, got -1",
        "7: limits.memory: expected a whole number, got 'lots'",
        "8: ends.done: item needs a place: at",
        "9: measures.time.valu: unknown key 'valu'; did you mean 'value'?",
        "10: keep.traces: expected 'none', 'failed' or 'all', got 'some'",
    ):
        assert expected in said, said


def test_worlds_are_checked_without_invalid_factors(tmp_path: Path) -> None:
    """Changes that use a factor are left out, so that none is reported for lack of it."""
    changes = {
        "factors": {"speed": 5},
        "overlay": {"robots.*.base.speed": "$speed", "robots.nobody.yaw": 1},
        "ends": {"e": {"item": "x"}},
        "successes": ["e", "f"],
    }
    found = problems(written(tmp_path, **changes))

    said = [each.split(": ", 1)[1] for each in found]
    assert [
        "factors.speed: expected a list, got 5",
        "robots.nobody.yaw: there is no 'nobody' among the robots",
        "ends.e: item needs a place: at",
        "successes.1: no run ends as 'f', as there is no such ending",
    ] == [each.partition(";")[0] for each in said]


def test_errors_of_form_hide_no_others(tmp_path: Path) -> None:
    changes = {
        "keep": {"traces": "some"},
        "overlay": {"robots.eastbound.base.speed": "fast"},
        "treatments": {"a": {"tre": "x"}, "b": {"tree": "nowhere:tree"}},
        "measures": {"m": {"valu": "end.at"}, "n": "enrgy"},
        "ends": {"e": {"event": "dockd"}, "f": {"item": "x"}},
        "successes": ["e", "f"],
        "replications": {"min": 2, "max": 9, "until": {"measure": "m", "error": 0.1}},
    }
    found = problems(written(tmp_path, **changes))

    said = "\n".join(each.split(": ", 1)[1] for each in found)
    for expected in (
        "keep.traces: expected 'none', 'failed' or 'all', got 'some'",
        "robots.eastbound.base.speed: expected a number, got 'fast'",
        "treatments.a.tre: unknown key 'tre'; did you mean 'tree'?",
        "treatments.b.tree: nowhere:tree: no module 'nowhere'",
        "measures.m.valu: unknown key 'valu'; did you mean 'value'?",
        "measures.n: there is no 'enrgy'; did you mean 'energy'?",
        "ends.e.event: there is no kind of event 'dockd'",
        "ends.f: item needs a place: at",
    ):
        assert expected in said, said
    assert 9 == len(found), said  # `m` has no value either, but is not reported as an unknown measure


def test_each_error_of_a_tree_is_an_error(tmp_path: Path) -> None:
    tree = '<root BTCPP_format="4"><BehaviorTree ID="Main">\n<Pickup item="box"/>\n</BehaviorTree></root>'
    (tmp_path / "tree.xml").write_text(tree, encoding="utf-8")
    told = problems(written(tmp_path, treatments={"go": {"tree": "tree.xml"}}))

    assert [line.partition("tree.xml:")[2][:20] for line in told] == ["2: <Pickup>: unknown", "2: <Pickup>: port 't"]


def test_checks_a_controller_without_expressions(tmp_path: Path) -> None:
    """Without valid factors, only a controller with expressions is skipped."""
    treatments = {"a": {"tree": "nowhere:tree"}, "b": {"tree": "${speed}:tree"}}
    found = problems(written(tmp_path, factors={"speed": 5}, treatments=treatments))

    assert ["factors.speed: expected a list, got 5", "treatments.a.tree: nowhere:tree: no module 'nowhere'"] == [
        each.split(": ", 1)[1].partition(" here")[0] for each in found
    ]


def test_invalid_design_does_not_affect_its_factors(tmp_path: Path) -> None:
    factors = {"speed": {"low": 1.0, "high": 2.0}}
    (problem,) = problems(written(tmp_path, factors=factors, design={"latin_hypercub": 3}, overlay={"seed": "$speed"}))
    assert "design.latin_hypercub: unknown key 'latin_hypercub'; did you mean 'latin_hypercube'?" in problem


@pytest.mark.parametrize("key", ["name", "world", "factors", "treatments", "measures", "ends", "tables", "overlay"])
def test_reports_no_consequences_of_an_invalid_part(tmp_path: Path, key: str) -> None:
    changes: dict[str, Any] = {
        "tables": {"fast": {"some": 1.0}},
        "factors": {"speed": ["some"]},
        "overlay": {"robots.*.base.speed": "${fast[speed]}"},
        "treatments": {"a": {"tree": "bt_controller.examples.hospital:mission", "set": {"x": "${fast[speed]}"}}},
        "measures": {"m": "ends.done"},
        "ends": {"done": {"event": "picked"}},
        "successes": ["done"],
        "replications": {"min": 2, "max": 9, "until": {"measure": "m", "error": 0.1}},
    }
    assert check_file(written(tmp_path, **changes))[1] == []

    (problem,) = problems(written(tmp_path, **{**changes, key: 5}))
    assert f"{key}: expected " in problem


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"factors": {"seed": [1]}}, "factors.seed: 'seed' is a column of the results already; give another name"),
        ({"factors": {"time": [1]}}, "measures.time: 'time' is one of the factors already"),
        ({"factors": {"a": {"low": 1, "high": 2}}}, "design: a is a range, which only a latin_hypercube draws from"),
        ({"factors": {"a": {"low": 2, "high": 1}}}, "factors.a: low 2 is not less than high 1"),
        ({"factors": {"a": {"low": 2, "hgh": 3}}}, "factors.a.hgh: unknown key 'hgh'; did you mean 'high'?"),
        ({"factors": {"a": [[1]]}}, "factors.a.0: expected a number, a text, true or false, got [1]"),
        ({"factors": {"a": 5}}, "factors.a: expected a list, got 5"),
        ({"design": "fll"}, "design: expected 'full' or 'one_at_a_time', got 'fll'"),
        ({"design": {"latin_hypercube": -3}}, "design.latin_hypercube: must be at least 1, got -3"),
        (
            {"treatments": {"a": GO, "b": {**GO, "overlay": {"robots.eastbound.base.speed": "fast"}}}},
            "base.speed: expected a number, got 'fast' (scenario 0: speed=0.5, load=none, treatment b)",
        ),
        ({"variants": {"far": {"set": {"x": [1]}}}}, "variants.far.set.x: expected a number, a text, true or false"),
        (
            {"ends": {"e": {"robot": "${executor}", "at": "west"}}},
            "ends.e.robot: there is no 'executor'; an ending",
        ),
        ({"ends": {"e": {"robot": "${1 +}", "at": "west"}}}, "ends.e.robot: there is no '${1 +}'; an ending may only"),
        ({"ends": {"e": {"robot": "${reported.r}", "at": "wst"}}}, "ends.e.at: no waypoint, place or dock 'wst'"),
        ({"successes": ["served"]}, "successes.0: no run ends as 'served', as there is no such ending; there are"),
        (
            {"successes": ["timeout", "serve"], "ends": {"served": {"orders": "served", "count": 2}}},
            "successes.1: no run ends as 'serve', as there is no such ending; did you mean 'served'?; define it under",
        ),
        ({"measures": {"m": "max(end.at, 3)"}}, "measures.m: 'max' is called, but an expression has no functions"),
        (
            {"measures": {"m": {"value": "max(end.at", "3)": None}}},
            "measures.m.3): unknown key '3)'; within { } a comma begins another key; put the text before it",
        ),
        ({"factors": {"a": []}}, "factors: a has no levels"),
        ({"factors": {"a": []}, "design": {"latin_hypercube": 3}}, "factors: a has no levels"),
        ({"factors": None, "overlay": None, "design": {"latin_hypercube": 3}}, "design: a latin_hypercube needs"),
        ({"treatments": {"go": {"python": "$speed"}}}, "treatments.go.python: '0.5' is not a function; expected"),
        ({"treatments": {"go": {"tree": "$speed"}}}, "treatments.go.tree: '0.5' is not a tree; expected FILE.xml"),
        ({"design": {"list": "nowhere.csv"}}, "nowhere.csv: no such file"),
        ({"design": {"list": [{"speed": 1}]}}, "design: row 1 has no 'load'; it has speed"),
        ({"tables": {"t": "nowhere.yaml"}}, "tables.t: "),
        ({"replications": {"min": 2, "max": 9, "until": {"measure": "tme", "error": 0.1}}}, "did you mean 'time'?"),
        ({"world": "hospitl"}, "did you mean 'hospital'?"),
        ({"overlay": {"robots.*.base.speed": "$sped"}}, "robots.*.base.speed: $sped: there is no 'sped'"),
        (
            {"overlay": {"robots.*.base.speed": "$load"}},
            "expected a number, got 'none' (scenario 0: speed=0.5, load=none)",
        ),
        ({"treatments": {"a": {"tree": "nowhere:tree"}}}, "treatments.a.tree: nowhere:tree: no module 'nowhere'"),
        ({"treatments": {"a": {"python": "${lod}"}}}, "treatments.a.python: ${lod}: there is no 'lod'"),
        ({"measures": {"m": "ends.success +"}}, "measures.m: is no expression"),
        ({"measures": {"m": "enrgy"}}, "measures.m: there is no 'enrgy'; did you mean 'energy'?"),
        ({"measures": {"m": "1 / orders.latte"}}, "measures.m: orders has no 'latte'; did you mean 'late'?"),
        (
            {"measures": {"m": "orders.delay.trafic"}},
            "measures.m: orders.delay has no 'trafic'; did you mean 'traffic'?",
        ),
        ({"measures": {"m": "ends.suceeded"}}, "measures.m: ends has no 'suceeded'; did you mean 'succeeded'?"),
        ({"measures": {"m": "report.summary.distnce"}}, "report.summary has no 'distnce'; did you mean 'distance'?"),
        ({"ends": {"e": {"event": "dockd"}}}, "ends.e.event: there is no kind of event 'dockd'"),
        ({"ends": {"e": {"robot": "x", "at": "nowhere"}}}, "ends.e.at: no waypoint, place or dock 'nowhere'"),
        ({"ends": {"e": [{"item": "x", "at": "a"}, {"orders": "served"}]}}, "ends.e.1.orders: the world has no demand"),
    ],
    ids=str,
)
def test_reports_other_errors_before_any_run(tmp_path: Path, changes: dict[str, Any], said: str) -> None:
    assert said in "\n".join(problems(written(tmp_path, **changes)))


@pytest.mark.parametrize(
    ("text", "said"),
    [("", "is empty"), ("a: [", "is not valid YAML"), ("- 1\n", "expected a mapping with name, world")],
)
def test_rejects_files_that_are_no_experiments(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "e.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ExperimentError, match=said):
        read_plan(tmp_path / "e.yaml")
    with pytest.raises(ExperimentError, match="no such file"):
        read_plan(tmp_path / "nowhere.yaml")


def test_objects_of_one_treatment_are_known(tmp_path: Path) -> None:
    """Endings and measures may use them, although the worlds of the other treatments lack them."""
    more = {"robots.new": {"at": "near_west"}, "items.box": {"at": "east"}}
    path = written(
        tmp_path,
        factors={},
        treatments={"a": GO, "b": {**GO, "overlay": more}},
        ends={"there": {"robot": "new", "at": "east"}, "brought": {"item": "box", "at": "west"}},
        successes=["there"],
        measures={"x": "robots.new.x"},
    )

    assert [] == check_file(path)[1]
    plan = read_plan(path)
    assert ["new" in plan.world(0, name).world.robots for name in ("", "a", "b")] == [False, False, True]


def test_rejects_an_unknown_variant(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match="there is no variant 'flky'; did you mean 'flaky'"):
        read_plan(written(tmp_path, variants={"flaky": {}}), ["flky"])

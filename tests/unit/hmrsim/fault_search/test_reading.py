"""The reader of check files, which reports all errors at once, with lines and suggested fixes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
import yaml

from hmrsim.errors import CheckError
from hmrsim.fault_search.reading import read_check, read_repro
from tests.porters import HERE, WORLD

if TYPE_CHECKING:
    from pathlib import Path

FILE: dict[str, Any] = {"world": "world.yaml", "controller": {"python": "porters.py:careful"}}


def written(folder: Path, text: str | None = None, **changes: Any) -> Path:
    """Return the path of a written check file."""
    (folder / "world.yaml").write_text(yaml.safe_dump(WORLD), encoding="utf-8")
    (folder / "porters.py").write_text((HERE / "porters.py").read_text("utf-8"), encoding="utf-8")
    path = folder / "check.yaml"
    path.write_text(text or yaml.safe_dump({**FILE, **changes}, sort_keys=False), encoding="utf-8")
    return path


def problems(path: Path, read=read_check) -> list[str]:
    """Return the errors of a file, without its name."""
    with pytest.raises(CheckError) as error:
        read(path)
    return [str(problem).removeprefix(f"{path}") for problem in error.value.problems]


def test_world_and_controller_are_enough(tmp_path):
    check = read_check(written(tmp_path))

    assert check.name == "porters"
    assert check.file.budget.time == 600.0


def test_reports_all_errors_with_their_lines(tmp_path):
    text = """\
world: world.yaml
controler: {python: "porters.py:careful"}
budget: soon
space:
  at_most: 0
  durations: []
"""
    told = problems(written(tmp_path, text))

    assert [line.split(":")[1] for line in told if line.startswith(":")] == ["1", "2", "3", "5", "6"]
    assert any("controler" in line and "did you mean 'controller'?" in line for line in told)


def test_unknown_kinds_and_names_get_suggestions(tmp_path):
    told = problems(written(tmp_path, space={"only": ["brekdown"], "spare": ["portr"], "weights": {"slp": 2}}))

    assert [line.partition(": ")[2] for line in told] == [
        "space.only.0: no kind 'brekdown'; did you mean 'breakdown'?",
        "space.spare.0: nothing is called 'portr'; did you mean 'porter'?",
        "space.weights.slp: no kind 'slp'; did you mean 'slip'?",
    ]


def test_an_unlike_kind_gets_all_kinds(tmp_path):
    """No other place lists them."""
    (told,) = problems(written(tmp_path, space={"without": ["slow"]}))

    assert "no kind 'slow'; there are battery_cell, " in told
    assert all(f", {kind}" in told for kind in ("slip", "speed", "absent", "controller_killed", "simulation_reset"))


def test_each_error_of_a_tree_is_an_error(tmp_path):
    tree = '<root BTCPP_format="4"><BehaviorTree ID="Main">\n<Pickup item="box"/>\n</BehaviorTree></root>'
    (tmp_path / "tree.xml").write_text(tree, encoding="utf-8")
    told = problems(written(tmp_path, controller={"tree": "tree.xml"}))

    assert [line.partition("tree.xml:")[2][:20] for line in told] == ["2: <Pickup>: unknown", "2: <Pickup>: port 't"]


def test_custom_injections_are_checked_in_every_expansion(tmp_path):
    slips = {"type": "slip", "robot": ["porter", "portr"], "factor": [0.1, 0.5], "duration": 20}
    told = problems(written(tmp_path, space={"further": [slips, {"type": "slp", "robot": "*"}]}))

    assert [line.partition(": ")[2] for line in told] == [
        "space.further.0.robot: no robot 'portr'; did you mean 'porter'?",
        "space.further.1.type: no fault type 'slp'; did you mean 'slip'?",
    ]


def test_tree_needs_a_robot(tmp_path):
    tree = {"tree": "bt_controller.examples.hospital:mission"}
    (told,) = problems(written(tmp_path, world={"waypoints": {"home": [0, 0]}}, controller=tree))

    assert told.endswith("controller: the world has no robot for a tree; add one, or check a function or a command")


def test_reports_a_missing_controller(tmp_path):
    (told,) = problems(written(tmp_path, controller={"python": "porters.py:carful"}))

    assert "controller" in told
    assert "carful" in told


def test_reports_errors_of_world_and_check_together(tmp_path):
    path = written(tmp_path, controller={"python": "porters.py:nobody"})
    (tmp_path / "world.yaml").write_text("waypoints: {a: [0]}\n", encoding="utf-8")

    told = problems(path)

    assert any("world.yaml" in line for line in told)
    assert any("nobody" in line for line in told)


def test_reports_flaws_of_a_schedule_at_their_injections(tmp_path):
    repro = {"repro": 1, "failure": {"property": "mission_ends", "reason": "timeout"}}
    schedule = [{"type": "slipp", "robot": "porter"}, {"change": {"robots.nobody.yaw": 1}}]
    path = written(tmp_path, **repro, schedule=schedule)

    (told,) = problems(path, read_repro)

    assert "no fault type 'slipp'; did you mean 'slip'?" in told
    (tmp_path / "check.yaml").write_text(path.read_text("utf-8").replace("slipp", "breakdown"), encoding="utf-8")
    (told,) = problems(path, read_repro)
    assert "nobody" in told


@pytest.mark.parametrize("text", ["", "[1, 2]", "world: [", "world: a\nworld: b\n"])
def test_rejects_files_that_are_no_checks(tmp_path, text):
    path = tmp_path / "check.yaml"
    path.write_text(text, encoding="utf-8")

    assert problems(path)


def test_reports_properties_of_missing_objects(tmp_path):
    """Unknown names are errors; a property of something that can't happen is a warning."""
    wrong = {"properties": {"there": {"eventually": {"item": "bx", "at": "shelf"}}}}
    vain = {"properties": {"doors": {"sometimes": {"event": "door_opened"}}}}

    (told,) = problems(written(tmp_path, properties=wrong))
    check = read_check(written(tmp_path, properties=vain))

    assert told.startswith(":")
    assert "did you mean 'box'?" in told
    assert ["doors" in str(warning) for warning in check.warnings] == [True]


def test_properties_come_from_a_file_beside_the_check(tmp_path):
    (tmp_path / "properties.yaml").write_text("properties: {there: {eventualy: {item: box}}}\n", encoding="utf-8")

    (told,) = problems(written(tmp_path, properties="properties.yaml"))

    assert "properties.yaml:1" in told
    assert "did you mean 'eventually'?" in told


def test_errors_of_form_hide_no_others(tmp_path):
    """The errors of the file, of names in the world, of the properties and of the controller come together."""
    properties = {"a": {"always": {"robot": "nobody", "at": "shelf"}}, "b": {"never": {"robot": "porter", "att": "x"}}}
    changes = {
        "controller": {"python": "nowhere.py:careful"},
        "properties": {"properties": properties},
        "space": {"at_mos": 2, "without": ["jum"], "spare": ["bx"]},
        "limits": {"simulated": -1},
    }

    told = "\n".join(each.partition(": ")[2] for each in problems(written(tmp_path, **changes)))

    for expected in (
        "controller: nowhere.py:careful: no such file",
        "properties.properties.a.always.robot: no robot 'nobody'",
        "properties.properties.b.never.att: unknown key 'att'; did you mean 'at'?",
        "space.at_mos: unknown key 'at_mos'; did you mean 'at_most'?",
        "space.without.0: no kind 'jum'",
        "space.spare.0: nothing is called 'bx'; did you mean 'box'?",
        "limits.simulated: must be greater than 0, got -1",
    ):
        assert expected in told, told


def test_the_other_parts_are_checked_without_a_world(tmp_path):
    path = written(tmp_path, "controller: {python: 'nowhere.py:careful'}\nproperties: {propertis: {}}\n")

    assert [
        ":1: world: is missing",
        ":1: controller: nowhere.py:careful: no such file: nowhere.py",
        ":2: properties.propertis: unknown key 'propertis'; did you mean 'properties'?",
    ] == problems(path)


def test_an_invalid_overlay_has_its_line(tmp_path):
    text = yaml.safe_dump(FILE, sort_keys=False) + "overlay:\n  robots.porter.base.sped: 2\n"

    (told,) = problems(written(tmp_path, text))

    assert told.startswith(":5: robots.porter.base.sped: unknown key 'sped'")


def test_an_invalid_world_in_a_check_has_its_lines(tmp_path):
    world = "world:\n  waypoints: {a: [0, 0]}\n  robots:\n    porter: {at: b}\n"

    (told,) = problems(written(tmp_path, f"{world}controller: {{python: 'porters.py:careful'}}\n"))

    assert told.startswith(":4: robots.porter.at: no waypoint, place or dock 'b'")

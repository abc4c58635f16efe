"""Loading of trees by name."""

from __future__ import annotations

import sys

import pytest
from py_trees.blackboard import Blackboard

from bt_controller.core.blackboards import Board
from bt_controller.errors import TreeError
from bt_controller.examples import go_to_pose
from bt_controller.loading.trees import load

MODULE = """
from py_trees.behaviours import Success
from py_trees.blackboard import Blackboard

def plain():
    return Success("plain")

def for_robot(robot):
    return Success(robot)

def for_whom(name):
    return Success(name)

def with_default(robot="nobody"):
    return Success(robot)

def with_speed(speed=1.0):
    return Success(str(speed))

def of_given():
    return Success(Blackboard.get("/given"))

def overwrites():
    Blackboard.set("given", "mine")
    return Success("tree")

def too_much(robot, map):
    return Success("no")

def keyword(*, map):
    return Success("no")

def no_tree():
    return 42

def broken():
    return 1 / 0

a_number = 42
"""


@pytest.fixture(autouse=True)
def missions(tmp_path, monkeypatch):
    """Make a folder with trees the current one."""
    (tmp_path / "bt_test_missions.py").write_text(MODULE)
    (tmp_path / "bt_test_unreadable.py").write_text("def tree(:\n")
    (tmp_path / "bt_test_importer.py").write_text("import bt_test_nowhere\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    yield
    for name in [name for name in sys.modules if name.startswith("bt_test_")]:
        del sys.modules[name]


def test_the_example_is_found_by_name():
    plan = load("bt_controller.examples:go_to_pose")

    assert (plan.function, plan.confirmed) == (go_to_pose, True)


@pytest.mark.parametrize(
    ("function", "name"),
    [
        ("plain", "plain"),
        ("for_robot", "wall_e"),
        ("for_whom", "wall_e"),
        ("with_default", "wall_e"),
        ("with_speed", "1.0"),
    ],
)
def test_a_function_takes_the_robots_name_or_nothing(function, name):
    assert load(f"bt_test_missions:{function}").build("wall_e").name == name


@pytest.mark.parametrize("begin", ["<root>", "\n <root>"])
def test_a_file_is_known_by_how_it_begins(tmp_path, begin):
    (tmp_path / "a:b").write_text(f'{begin}<BehaviorTree ID="A"><AlwaysSuccess name="x"/></BehaviorTree></root>')

    assert load("a:b").build("wall_e").name == "x"


def test_values_are_there_while_a_function_builds_its_tree():
    with Board().in_use:
        assert load("bt_test_missions:of_given", values={"given": "kitchen"}).build("wall_e").name == "kitchen"


def test_values_win_over_what_a_function_sets():
    with Board().in_use:
        load("bt_test_missions:overwrites", values={"given": "yours"}).build("wall_e")

        assert Blackboard.get("given") == "yours"


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("bt_test_missions", "'bt_test_missions' is not a tree; expected FILE.xml, MODULE:FUNCTION"),
        ("tree.xml", "^tree.xml: no such file$"),
        (":plain", "':plain' is not a tree; expected FILE.xml, MODULE:FUNCTION"),
        ("bt_test_absent:plain", r"bt_test_absent:plain: no module 'bt_test_absent' here \(.*\) or installed"),
        (
            "bt_test_importer:tree",
            r"ModuleNotFoundError: No module named 'bt_test_nowhere' \(.*bt_test_importer.py:1\)",
        ),
        ("bt_test_unreadable:tree", r"SyntaxError: .* \(.*bt_test_unreadable\.py:1\)"),
        ("bt_test_missions:plane", "module 'bt_test_missions' has no 'plane'; did you mean 'plain'?"),
        ("bt_test_missions:zzz", "has no 'zzz'; it has plain, for_robot"),
        ("bt_test_missions:a_number", "is 42, which is not a tree"),
        ("bt_test_missions:too_much", "requires robot, map; a tree's function takes the robot's name, or nothing"),
        ("bt_test_missions:keyword", "requires map; a tree's function takes the robot's name, or nothing"),
    ],
)
def test_a_value_that_is_not_a_tree_is_refused_in_one_line(name, error):
    with pytest.raises(TreeError, match=error) as caught:
        load(name)

    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("function", "error"),
    [
        ("no_tree", "bt_test_missions:no_tree returned 42; expected the root of a tree, a py_trees Behaviour"),
        ("broken", r"bt_test_missions:broken: ZeroDivisionError: division by zero \(.*bt_test_missions\.py:37\)"),
    ],
)
def test_a_function_that_builds_no_tree_is_refused_in_one_line(function, error):
    with pytest.raises(TreeError, match=error):
        load(f"bt_test_missions:{function}").build("wall_e")


def test_a_file_is_as_good_as_a_module_and_parameters_are_given_by_name(tmp_path):
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / "bt_test_missions.py").write_text(MODULE.replace("plain", "simple"))
    (folder / "beside.py").write_text("WORD = 'beside'\n")
    (folder / "with_import.py").write_text(
        "import beside\nfrom py_trees.behaviours import Success\n"
        "def it(robot, word=None):\n    return Success(word or beside.WORD)\n"
    )
    load("bt_test_missions:plain")

    assert "simple" == load(f"{folder}/bt_test_missions.py:simple").build().name
    assert "beside" == load(f"{folder}/with_import.py:it").build("wall_e").name
    assert "7" == load("bt_test_missions.py:with_speed(speed=7)").build().name
    assert "it" == load(f"{folder}/with_import.py:it(word='it')").build("wall_e").name


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("bt_test_missions:with_speed(sped=3)", "it takes no 'sped'; did you mean 'speed'?"),
        ("bt_test_missions:with_speed(3)", "'3' has no name; write NAME=3"),
        ("bt_test_missions:with_speed(speed=open('x'))", "is not NAME=VALUE"),
        ("bt_test_missions:with_speed(speed=fast)", "a text or a list; quote the text: speed='fast'"),
        ("bt_test_missions:with_speed(speed=", "is not a tree; expected"),
        ("nowhere.py:plain", "no such file: nowhere.py"),
        ("bt_test_missions.py:plane", "file 'bt_test_missions.py' has no 'plane'; did you mean 'plain'?"),
    ],
)
def test_what_is_wrong_with_parameters_is_told(name, error):
    with pytest.raises(TreeError) as caught:
        load(name)

    assert error in str(caught.value)
    assert "\n" not in str(caught.value)

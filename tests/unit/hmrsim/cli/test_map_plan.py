"""``hmrsim map plan``."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main

WORLD = """\
bounds: [-5, -5, 20, 10]
waypoints: {home: [0, 0], corner: [4, 0], shelf: [4, 3], far: [15, 9]}
lanes: [[home, corner], {from: corner, to: shelf, speed_limit: 0.5}]
walls: [[[10, -5], [10, 10]], {solid: [[6, 5], [7, 5], [7, 6], [6, 6]]}]
places: {pharmacy: {at: [4, 3]}}
items: {box: {at: [2, 0]}}
robots:
  eve: {at: home, yaw: 1.5707963267948966, base: {speed: 2, turning_rate: 1.5707963267948966}}
  bob: {at: home}
"""


@pytest.fixture
def path(tmp_path):
    """Return a small world."""
    file = tmp_path / "world.yaml"
    file.write_text(WORLD)
    return str(file)


@pytest.fixture
def plan(path, capsys):
    """Return the function that plans on the small world: exit code, and the answer as JSON values."""

    def run(*words):
        code = main(["map", "plan", path, *words, "--json"])
        return code, json.loads(capsys.readouterr().out)

    return run


def test_legs_length_and_time(plan):
    """A robot without a speed drives 1 m/s, or slower on a lane with a limit."""
    code, trip = plan("home", "pharmacy")

    assert (0, ["home", "corner", "shelf"], 7.0, 10.0) == (code, trip["waypoints"], trip["length"], trip["duration"])
    assert [(4.0, None, 4.0), (3.0, 0.5, 6.0)] == [
        (leg["length"], leg["speed_limit"], leg["duration"]) for leg in trip["legs"]
    ]


def test_a_robot_drives_from_where_it_stands(plan):
    """If FROM is a robot, its speed and its turns count."""
    _, trip = plan("eve", "shelf")

    assert ("eve", 2.0, 2.0) == (trip["robot"], trip["speed"], trip["turning"])
    assert 10.0 == pytest.approx(trip["duration"])


def test_for_another_robot(plan):
    """``--for`` names the robot that drives."""
    _, trip = plan("corner", "home", "--for", "eve")

    assert ("eve", 2.0) == (trip["robot"], trip["duration"])


def test_at_a_speed(plan):
    """``--speed`` overrides the speed of a robot at FROM."""
    _, trip = plan("eve", "corner", "--speed", "4")

    assert (None, 1.0) == (trip["robot"], trip["duration"])


@pytest.mark.parametrize(
    ("words", "length"), [(("box", "corner"), 2.0), (("-3,4", "-3,-1"), 5.0), (("1,0", "1,0"), 0.0)]
)
def test_points_have_names_or_coordinates(plan, words, length):
    """FROM and TO may be items, negative coordinates, or the same point."""
    code, trip = plan(*words)

    assert (0, length) == (code, trip["length"])


def test_text(path, capsys):
    """Each leg is a line, followed by the total."""
    main(["map", "plan", path, "home", "shelf"])

    assert [
        "home (0, 0)                start",
        "corner (4, 0)  4 m  4.0 s",
        "shelf (4, 3)   3 m  6.0 s  at most 0.5 m/s",
        "7 m in 10.0 s at up to 1 m/s",
    ] == capsys.readouterr().out.splitlines()


@pytest.mark.parametrize(("goal", "code"), [("far", 208), ("30,0", 204), ("6.5,5.5", 206)])
def test_no_route_is_1(path, capsys, goal, code):
    """The error has the planner's message and Nav2's error code."""
    assert 1 == main(["map", "plan", path, "home", goal])

    assert capsys.readouterr().err.endswith(f"(error_code {code})\n")


@pytest.mark.parametrize(
    ("start", "error"),
    [
        ("30,0", "start (30, 0) is outside the map, which spans (-5, -5) to (20, 10) (error_code 203)"),
        ("-1e308,0", "start (-1e+308, 0) is outside any map: coordinates end at 1e+07 (error_code 203)"),
        ("6.5,5.5", "start (6.5, 5.5) is inside an obstacle (error_code 205)"),
    ],
)
def test_no_start_is_1(path, capsys, start, error):
    """A start where no robot can stand is an error with Nav2's code for the start."""
    assert 1 == main(["map", "plan", path, start, start])

    assert f"hmrsim: {error}\n" == capsys.readouterr().err


@pytest.mark.parametrize("ends", [("1e400,1", "home"), ("home", "1,-1e400"), ("nan,1", "home"), ("home", "Infinity,1")])
def test_a_coordinate_that_is_not_finite_is_2(path, capsys, ends):
    """It is not a point of any map."""
    assert 2 == main(["map", "plan", path, *ends])

    assert capsys.readouterr().err.endswith(" is not a point; expected X,Y of finite numbers, such as 1.5,-2\n")


def test_each_unknown_name_is_a_line(path, capsys):
    """Each unknown name is a line."""
    code = main(["map", "plan", path, "hom", "shel", "--for", "ev"])

    captured = capsys.readouterr()
    assert (1, "") == (code, captured.out)
    assert (
        "hmrsim: no point, place or thing 'hom'; did you mean 'home'?\n"
        "hmrsim: no point, place or thing 'shel'; did you mean 'shelf'?\n"
        "hmrsim: no robot 'ev'; did you mean 'eve'?\n"
    ) == captured.err

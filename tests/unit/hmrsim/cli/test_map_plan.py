"""The command ``hmrsim map plan``."""

from __future__ import annotations

import json

import pytest

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
    file = tmp_path / "world.yaml"
    file.write_text(WORLD)
    return str(file)


@pytest.fixture
def plan(path, hmrsim):
    def run(*words):
        code, out, _ = hmrsim("map plan", path, *words, "--json")
        return code, json.loads(out)

    return run


def test_a_plan_has_legs_length_and_time(plan):
    """A robot without a speed drives 1 m/s, or slower on a lane with a limit."""
    code, trip = plan("home", "pharmacy")

    assert (0, ["home", "corner", "shelf"], 7.0, 10.0) == (code, trip["waypoints"], trip["length"], trip["duration"])
    assert [(4.0, None, 4.0), (3.0, 0.5, 6.0)] == [
        (leg["length"], leg["speed_limit"], leg["duration"]) for leg in trip["legs"]
    ]


def test_a_robot_drives_from_where_it_stands(plan):
    _, trip = plan("eve", "shelf")

    assert ("eve", 2.0, 2.0) == (trip["robot"], trip["speed"], trip["turning"])
    assert 10.0 == pytest.approx(trip["duration"])


@pytest.mark.parametrize(
    ("words", "robot", "duration"),
    [(("corner", "home", "--for", "eve"), "eve", 2.0), (("eve", "corner", "--speed", "4"), None, 1.0)],
)
def test_options_name_the_robot_or_its_speed(plan, words, robot, duration):
    _, trip = plan(*words)

    assert (robot, duration) == (trip["robot"], trip["duration"])


@pytest.mark.parametrize(
    ("words", "length"), [(("box", "corner"), 2.0), (("-3,4", "-3,-1"), 5.0), (("1,0", "1,0"), 0.0)]
)
def test_points_have_names_or_coordinates(plan, words, length):
    code, trip = plan(*words)

    assert (0, length) == (code, trip["length"])


def test_text_has_a_line_for_each_leg_and_the_total(path, hmrsim):
    assert [
        "home (0, 0)                start",
        "corner (4, 0)  4 m  4.0 s",
        "shelf (4, 3)   3 m  6.0 s  at most 0.5 m/s",
        "7 m in 10.0 s at up to 1 m/s",
    ] == hmrsim("map plan", path, "home", "shelf")[1].splitlines()


@pytest.mark.parametrize(
    ("ends", "code", "error"),
    [
        (("home", "far"), 1, "(error_code 208)"),
        (("home", "30,0"), 1, "(error_code 204)"),
        (("home", "6.5,5.5"), 1, "(error_code 206)"),
        (("30,0", "home"), 1, "start (30, 0) is outside the map, which spans (-5, -5) to (20, 10) (error_code 203)"),
        (("-1e308,0", "home"), 1, "start (-1e+308, 0) is outside any map: coordinates end at 1e+07 (error_code 203)"),
        (("6.5,5.5", "home"), 1, "start (6.5, 5.5) is inside an obstacle (error_code 205)"),
        (("1e400,1", "home"), 2, "'1e400,1' is not a point; expected X,Y of finite numbers, such as 1.5,-2"),
        (("home", "1,-1e400"), 2, "'1,-1e400' is not a point; expected X,Y of finite numbers, such as 1.5,-2"),
        (("nan,1", "home"), 2, "'nan,1' is not a point; expected X,Y of finite numbers, such as 1.5,-2"),
        (("home", "Infinity,1"), 2, "'Infinity,1' is not a point; expected X,Y of finite numbers, such as 1.5,-2"),
    ],
)
def test_impossible_ends_exit_with_1_and_infinite_ones_with_2(path, hmrsim, ends, code, error):
    found, out, err = hmrsim("map plan", path, *ends)

    assert (code, "", True) == (found, out, err.endswith(f"{error}\n"))


def test_each_unknown_name_is_a_line(path, hmrsim):
    code, out, err = hmrsim("map plan", path, "hom", "shel", "--for", "ev")

    assert (1, "") == (code, out)
    assert [
        "hmrsim: no point, place or thing 'hom'; did you mean 'home'?",
        "hmrsim: no point, place or thing 'shel'; did you mean 'shelf'?",
        "hmrsim: no robot 'ev'; did you mean 'eve'?",
    ] == err.splitlines()

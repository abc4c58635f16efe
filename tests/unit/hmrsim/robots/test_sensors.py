"""Detections of cameras and proximity sensors."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import Read, SendGoal
from hmrsim.protocol.goal import Refused
from hmrsim.protocol.outputs import Sampled
from hmrsim.protocol.topics import Topic
from tests.simulation import simulate


def world(*, components=None, walls=(), yaw=0.0, **items):
    """Return a world with items and a robot that looks from (0, 0)."""
    eye = {"at": [0, 0], "yaw": yaw, "components": components or {"camera": {}}}
    things = {name: {"at": [*at]} for name, at in items.items()}
    return {"robots": {"eye": eye}, "items": things, "walls": [*walls]}


def seen(values):
    """Return the names that the robot of a world detects, with the sensors."""
    run = simulate(values)
    run.simulator.submit(Read(Topic.DETECTIONS, "eye", reply_to="asked"))
    detections = run.log.answer("asked").message.detections
    return {one.id: run.ask("is_detected", {"robot": "eye", "entity": one.id}).by for one in detections}


@pytest.mark.parametrize(
    ("at", "expected"),
    [
        ((5, 0), True),
        ((5.01, 0), False),
        ((3, 3), True),
        ((3, -3), True),
        ((3, 3.01), False),
        ((-1, 0), False),
        ((0, 0), True),
    ],
)
def test_a_camera_sees_its_range_and_field_of_view_with_edges(at, expected):
    settings = {"camera": {"range": 5, "field_of_view": math.pi / 2}}

    assert expected == ("cup" in seen(world(components=settings, cup=at)))


def test_a_camera_turns_with_its_robot():
    assert {"up": ["camera"]} == seen(world(yaw=math.pi / 2, up=(0, 3), ahead=(3, 0)))


def test_a_camera_sees_ten_metres_by_default():
    assert {"near": ["camera"]} == seen(world(near=(10, 0), far=(10.01, 0)))


def test_in_pixels_the_range_is_converted():
    values = world(near=(800, 0), far=(801, 0)) | {"units": "px"}

    assert {"near": ["camera"]} == seen(values)


@pytest.mark.parametrize("wall", [[[1, -1], [1, 1]], {"solid": [[1, -1], [2, -1], [2, 1], [1, 1]]}])
def test_walls_and_solids_hide_objects_behind_them(wall):
    half_circle = {"camera": {"field_of_view": math.pi}}

    assert {"beside": ["camera"]} == seen(world(components=half_circle, walls=[wall], behind=(3, 0), beside=(2, 4)))


def test_only_a_closed_door_hides_objects_behind_it():
    values = world(cup=(3, 0)) | {"doors": {"gate": {"at": [[1, -1], [1, 1]]}}}
    opened = {**values, "doors": {"gate": {"at": [[1, -1], [1, 1]], "open": True}}}

    assert ({}, {"cup": ["camera"]}) == (seen(values), seen(opened))


def test_proximity_is_in_all_directions_and_shorter():
    settings = {"proximity": {}}

    assert {"behind": ["proximity"]} == seen(world(components=settings, behind=(-2, 0), far=(2.1, 0)))


def test_walls_hide_from_proximity_unless_it_goes_through():
    """Radio tags are seen through walls."""
    wall = [[1, -1], [1, 1]]
    shut, through = ({"proximity": {"through_walls": through}} for through in (False, True))

    assert {} == seen(world(components=shut, walls=[wall], cup=(2, 0)))
    assert {"cup": ["proximity"]} == seen(world(components=through, walls=[wall], cup=(2, 0)))


def test_an_object_seen_by_both_names_the_sensors_in_order():
    assert {"cup": ["camera", "proximity"]} == seen(world(components={"proximity": {}, "camera": {}}, cup=(1, 0)))


def test_other_robots_and_their_items_are_seen():
    claw = {"claw": {"reach": 2}, "proximity": {}}
    values = world(components=claw, mine=(0, 0), its=(1, 0))
    values["robots"]["other"] = {"type": "fetcher", "at": [1, 0]}
    run = simulate(values)
    robots, items = run.simulator.robots, run.simulator.items
    robots["eye"].pick(items["mine"])
    robots["other"].pick(items["its"])
    run.simulator.submit(Read(Topic.DETECTIONS, "eye", reply_to="asked"))

    assert ["its", "other"] == [one.id for one in run.log.answer("asked").message.detections]


def test_a_detection_has_pose_and_class():
    values = world(yaw=0.0)
    values["robots"]["other"] = {"type": "fetcher", "at": [3, 1], "yaw": math.pi, "base": {"radius": 0.25}}
    run = simulate(values)
    run.simulator.submit(Read(Topic.DETECTIONS, "eye", reply_to="asked"))
    sampled = run.log.answer("asked")
    (detection,) = sampled.message.detections
    (result,) = detection.results

    assert ("eye", "map", 1) == (sampled.robot, sampled.message.header.frame_id, detection.header.stamp.nanosec)
    assert ("other", "fetcher", 1.0) == (detection.id, result.hypothesis.class_id, result.hypothesis.score)
    assert (3.0, 1.0, 1.0) == (result.pose.pose.position.x, result.pose.pose.position.y, result.pose.pose.orientation.z)
    assert (3.0, 0.5) == (detection.bbox.center.position.x, detection.bbox.size.x)


def test_a_robot_without_sensors_has_no_detections():
    run = simulate()
    run.simulator.submit(Read(Topic.DETECTIONS, "cart", reply_to="asked"))

    assert Refused("robot", "cart", "cart has no sensor, such as a camera; it sees nothing") == run.log.answer("asked")


@pytest.mark.parametrize(
    ("request_", "code", "why"),
    [
        ({"robot": "eyes", "entity": "cup"}, 2, "robot: no robot 'eyes'; did you mean 'eye'?"),
        ({"robot": "eye", "entity": "cap"}, 2, "no entity 'cap'; did you mean 'cup'?"),
    ],
)
def test_is_detected_with_an_unknown_name_is_refused(request_, code, why):
    result = simulate(world(cup=(1, 0))).ask("is_detected", request_).result

    assert (code, why) == (result.result, result.error_message)


# --- when it is told -------------------------------------------------------------------------------------------------

ROAD = {
    "waypoints": {"a": [0, 0], "b": [20, 0]},
    "lanes": [["a", "b"]],
    "robots": {
        "eye": {"at": [0, 1], "components": {"proximity": {"range": 3, "resolution": 1.5}}},
        "cart": {"at": "b"},
    },
}


def told(run):
    """Return the times at which the watcher's detections changed, with their positions."""
    return [
        (round(time, 6), [(one.id, round(one.bbox.center.position.x, 6)) for one in event.message.detections])
        for time, event in run.log.events
        if isinstance(event, Sampled) and event.topic is Topic.DETECTIONS
    ]


def test_detections_are_published_when_an_object_comes_moves_or_goes():
    goal = NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": 0.0}}}})
    run = simulate(ROAD, topics=frozenset({Topic.DETECTIONS}), detection_rate=1.0)
    run((0.0, SendGoal("cart", "navigate_to_pose", goal)), until=22.0)

    assert [(1.0, []), (18.0, [("cart", 2.0)]), (20.0, [("cart", 0.0)])] == told(run)


def test_nothing_is_computed_without_a_subscriber(monkeypatch):
    run = simulate(ROAD, topics=frozenset({Topic.EVENTS}))
    monkeypatch.setattr(run.simulator.detections, "look", lambda *_: pytest.fail("it looked"))

    run.simulator.advance(5.0)


# --- all of it at once -----------------------------------------------------------------------------------------------

COORDINATES = st.integers(-6, 6)
POINTS = st.tuples(COORDINATES, COORDINATES)
WALLS = st.lists(st.tuples(POINTS, POINTS).filter(lambda wall: wall[0] != wall[1]), max_size=4)


def _side(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _on(point, a, b):
    return _side(a, b, point) == 0 and all(min(a[i], b[i]) <= point[i] <= max(a[i], b[i]) for i in (0, 1))


def _meet(a, b, c, d):
    """Return whether two segments with whole coordinates meet, exactly."""
    if _on(a, c, d) or _on(b, c, d) or _on(c, a, b) or _on(d, a, b):
        return True
    return _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0


@given(st.lists(POINTS, min_size=1, max_size=6), WALLS, st.integers(0, 3))
def test_detections_agree_with_checking_each_object_and_wall(points, walls, quarter):
    cos, sin = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarter]
    items = {f"item_{i}": point for i, point in enumerate(points)}
    settings = {"camera": {"range": 5, "field_of_view": math.pi / 2}}
    values = world(
        components=settings, walls=[[*map(list, wall)] for wall in walls], yaw=quarter * math.pi / 2, **items
    )

    expected = {
        name
        for name, (x, y) in items.items()
        if x * x + y * y <= 25
        and x * cos + y * sin >= abs(y * cos - x * sin)
        and not any(_meet((0, 0), (x, y), *wall) for wall in walls)
    }

    assert expected == set(seen(values))

"""Worlds without a traffic policy."""

from __future__ import annotations

from tests.simulation import simulate
from tests.unit.hmrsim.traffic.test_traffic import TRACK, A, B, end, go

WIDE = {"base": {"radius": 0.3}}


def wide(*names):
    """Return the track with robots that have a radius."""
    robots = {name: {**robot, **(WIDE if name in names else {})} for name, robot in TRACK["robots"].items()}
    return {**TRACK, "robots": robots, "robot_types": {"wide": WIDE}}


def test_robots_with_bodies_do_not_drive_through_each_other():
    log = simulate(wide("ann", "bob"))((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

    assert log.happened("made_room")
    assert ["SUCCEEDED", "SUCCEEDED"] == [end(log, goal)[1] for goal in (A, B)]


def test_robots_without_bodies_pass_through_each_other():
    log = simulate(TRACK)((0.0, go("ann", 20, 0, A)), (0.0, go("bob", 0, 0, B)))

    assert [(20.0, "SUCCEEDED", "")] * 2 == [end(log, A), end(log, B)]


def test_a_robot_that_is_spawned_does_not_change_the_policy():
    """The spawned robot passes through one with a body."""
    run = simulate(wide("ann"))
    pose = {"pose": {"position": {"x": 10.0, "y": 5.0}}}
    run.ask("spawn_entity", {"name": "new", "uri": "robot_type:wide", "initial_pose": pose})
    log = run((0.0, go("ann", 20, 0, A)), (0.0, go("new", 0, 0, B)))

    assert [(20.0, "SUCCEEDED", ""), (15.0, "SUCCEEDED", "")] == [end(log, A), end(log, B)]

"""Why robots wait."""

from __future__ import annotations

import pytest

from hmrsim.history.causes import Standing, standings, why_waits


def waits(robot, *others, **fields):
    """Return a robot that waits for others."""
    return Standing(robot, "a", ("navigate_to_pose",), since=3.0, waits_for=others, **fields)


def causes(*robots):
    """Return the kinds and robots of the causes for which the first of some robots waits."""
    chain = why_waits(robots[0].robot, {each.robot: each for each in robots})
    return [(link.robot, link.kind) for link in chain.links]


@pytest.mark.parametrize(
    ("last", "kind"),
    [
        (Standing("c", "b"), "idle"),
        (Standing("c", "b", ("pickup",)), "works"),
        (Standing("c", "b", ("navigate_to_pose",), moves=True), "drives"),
        (Standing("c", "b", ("navigate_to_pose",), ("breakdown",)), "disabled"),
        (Standing("c", "b", since=1.0, why="door is opening"), "obstacle"),
        (Standing("c", "b", since=1.0, waits_for=("a",)), "cycle"),
        (Standing("c", "b", since=1.0, waits_for=("b",)), "cycle"),
    ],
)
def test_a_chain_ends_with_the_robot_that_starts_it(last, kind):
    """However many robots are in between."""
    assert [("a", "robot"), ("b", "robot"), ("c", kind)] == causes(waits("a", "b"), waits("b", "c"), last)


def test_a_queue_leads_to_the_robot_at_the_dock():
    """The robots that are docked there are those that the queue waits for."""
    queues = Standing("a", "b", ("dock_robot",), waits_for=("b",), queue="charger")

    assert [("a", "queue"), ("b", "works")] == causes(queues, Standing("b", "charger", ("wait",), dock="charger"))


def test_robots_that_drive_on_are_not_the_cause():
    """Of two robots in the way, the one that stays is."""
    drives, idle = Standing("b", "x", ("navigate_to_pose",), moves=True), Standing("c", "y")

    assert [("a", "robot"), ("c", "idle")] == causes(waits("a", "b", "c"), drives, idle)


def test_a_long_jam():
    """Two thousand robots in a row, each of which has the next two in its way."""
    names = [f"r{number}" for number in range(2000)]
    jam = [waits(name, *names[i + 1 : i + 3]) for i, name in enumerate(names[:-1])]

    assert (names[-1], "idle") == causes(*jam, Standing(names[-1], "b"))[-1]


def test_a_robot_that_does_not_wait_says_what_it_does():
    """An idle one needs a goal."""
    chain = why_waits("a", {"a": Standing("a", "b")})

    assert ["a is idle at b, without a goal"] == [link.text for link in chain.links]
    assert "it waits for nothing but a goal from its controller" == chain.help


def robot_in(name, **fields):
    """Return a robot of a scene."""
    at_rest = {"pose": [1.0, 2.0, 0.0], "goals": [], "ailments": {}, "connected": True, "motion": None, "dock": None}
    return {"name": name, **at_rest, "waits": False, "waiting": None, **fields}


def test_a_robot_that_is_offline_goes_on_with_its_goal():
    """Only its controller can't reach it."""
    goals = [{"action": "navigate_to_pose", "status": 4}, {"action": "wait", "status": 2}]
    robots = [robot_in("a", connected=False, goals=goals), robot_in("b", connected=False)]
    known = standings({"robots": robots, "fixtures": []}, {"home": (1.0, 2.0)})

    texts = [why_waits(name, known).links[-1].text for name in "ab"]
    assert ["a executes wait at home", "b is idle at home, without a goal, and its connection is lost"] == texts


def test_a_scene_tells_who_queues_for_a_dock():
    dock = {"name": "charger", "tags": ["docked:b", "queued:a"]}
    known = standings({"robots": [robot_in("a"), robot_in("b", dock="charger")], "fixtures": [dock]}, {})

    assert ("charger", ("b",)) == (known["a"].queue, known["a"].waits_for)

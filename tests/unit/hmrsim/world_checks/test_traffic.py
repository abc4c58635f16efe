"""The traffic policy and its settings, capacities without effect, and start positions."""

from __future__ import annotations

import pytest

from hmrsim.world.model import World
from hmrsim.world_checks.traffic import check_traffic
from hmrsim.world_checks.validation import Lost

WAYPOINTS = {"a": (0.0, 0.0), "b": (1.0, 0.0)}


@pytest.mark.parametrize(
    ("fields", "path"),
    [
        ({"lanes": [{"from": "a", "to": "b"}, {"from": "b", "to": "a", "capacity": 2}]}, ("lanes", 1, "capacity")),
        ({"waypoints": {**WAYPOINTS, "c": {"at": (2.0, 0.0), "capacity": 2}}}, ("waypoints", "c", "capacity")),
    ],
)
def test_a_capacity_where_robots_pass_through_each_other_by_default(fields, path):
    """There is one warning per world, whose author expects robots to wait for each other."""
    world = World.model_validate({"waypoints": WAYPOINTS, **fields})

    (found,) = check_traffic(world)
    assert (path, "warning") == (found.path, found.severity)
    assert (
        "has no effect: robots pass through each other, as fewer than two have a radius and no policy is set; add"
        " traffic: {policy: planned}, or remove the capacity"
    ) == found.message


@pytest.mark.parametrize("policy", ["free", "priority"])
def test_a_capacity_with_traffic(policy):
    """There is no warning under a policy that was chosen, even if it ignores capacities."""
    lanes = [{"from": "a", "to": "b", "capacity": 2}]
    world = World.model_validate({"waypoints": WAYPOINTS, "lanes": lanes, "traffic": {"policy": policy}})

    assert [] == [*check_traffic(world)]


WIDE = {"base": {"radius": 0.3}}


def errors(**fields):
    """Return the errors of traffic in a world of two robots with radii and these fields."""
    robots = {"ann": {"at": "a", **WIDE}, "bob": {"at": "b", **WIDE}}
    world = World.model_validate({"waypoints": WAYPOINTS, "lanes": [["a", "b"]], "robots": robots, **fields})
    return [finding.message for finding in check_traffic(world) if finding.severity == "error"]


def test_robots_that_overlap_at_the_start_under_the_default_policy():
    """The error explains how to let robots pass through each other."""
    text = (
        "starts 0.5 from 'ann'; under 'planned' keep 0.6 away (the default; traffic: {policy: free} lets robots pass"
        " through each other)"
    )
    assert [text] == errors(waypoints={"a": (0.0, 0.0), "b": (0.5, 0.0)})


def test_settings_of_the_default_policy():
    """A world can set options of the default policy without naming it."""
    assert [] == errors(traffic={"patience": 30.0, "most_states": 1000})


def test_a_setting_that_the_default_policy_does_not_take():
    """The error names the default, as the file names no policy."""
    text = "unknown key 'lane_capacity'; there are policy, patience (the policy is 'free' by default; set another one)"
    assert [text] == errors(traffic={"lane_capacity": 2}, robots={"ann": {"at": "a", **WIDE}, "bob": {"at": "b"}})


def test_nothing_is_said_of_a_default_that_may_be_another_one():
    """There are no errors of a default policy that could be another one without the errors of robots."""
    robots = {"ann": {"at": "a", **WIDE}}
    world = World.model_validate({"waypoints": WAYPOINTS, "robots": robots, "traffic": {"lane_capacity": 2}})

    assert [] == [*check_traffic(world, Lost({"robots": frozenset({"bob"})}))]

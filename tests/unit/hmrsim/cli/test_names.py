"""The actions, services and topics of a running simulation."""

from __future__ import annotations

import pytest

from hmrsim.cli.names import Service, actions, find_action, find_topic, services, topics
from hmrsim.cli.options import UnknownName, WrongUse
from hmrsim_zenoh.wire.keys import Keys

INFO = {
    "robots": [{"name": "wall_e", "actions": ["pickup", "wait"]}, {"name": "eve", "actions": ["dance"]}],
    "aliases": {"wall_e/grab": "wall_e/pickup", "wait/wall_e": "wall_e/wait"},
}


@pytest.mark.parametrize("name", ["/wall_e/pickup", "wall_e/pickup", "/wall_e/grab", "wall_e/grab"])
def test_an_action_has_several_names(name):
    """The first slash is optional, and an alias stands for its target."""
    found = find_action(INFO, name)

    assert ("wall_e", "pickup", "moveit_msgs/action/Pickup") == (found.robot, found.action, found.ros_type)


@pytest.mark.parametrize("name", ["", "/", "wall_e", "/wall_e/", "wall_e/pickup/x", "//pickup"])
def test_a_name_that_is_not_robot_slash_action_is_wrong_use(name):
    with pytest.raises(WrongUse, match="expected /ROBOT/ACTION"):
        find_action(INFO, name)


def test_an_action_that_is_not_installed_has_no_messages():
    with pytest.raises(UnknownName, match="'dance' is not installed here"):
        find_action(INFO, "/eve/dance").definition()


def test_aliases_are_listed_last():
    names = [action.name for action in actions(INFO)]

    assert ["/wall_e/pickup", "/wall_e/wait", "/eve/dance", "/wall_e/grab", "/wait/wall_e"] == names


def test_all_published_topics_are_listed():
    names = [topic.name for topic in topics(INFO)]

    assert "/wall_e/odom" in names
    assert "/wall_e/pickup/_action/feedback" in names
    assert "/_world/clock" in names


@pytest.mark.parametrize(
    ("name", "key", "latched"),
    [
        ("/wall_e/odom", "hmrsim/wall_e/odom", True),
        ("_world/events", "hmrsim/_world/events", False),
        ("/wait/wall_e/_action/status", "hmrsim/wall_e/wait/_action/status", True),
        ("wall_e/wait/_action/feedback", "hmrsim/wall_e/wait/_action/feedback", False),
    ],
)
def test_a_topic_is_found_by_name_or_alias(name, key, latched):
    topic = find_topic(INFO, name)

    assert (key, latched) == (topic.key(Keys()), topic.latched)


def test_an_unknown_topic_lists_those_of_the_robot():
    with pytest.raises(UnknownName, match="no topic '/eve/smell'; eve has: odom, dance/_action/feedback"):
        find_topic(INFO, "/eve/smell")


@pytest.mark.parametrize(
    ("find", "name", "meant"),
    [
        (find_action, "/hal/pickup", "no robot 'hal'; there are: wall_e, eve"),
        (find_action, "/wall_e/fly", "wall_e has no action 'fly'; it has: pickup, wait"),
        (find_action, "/eve/pickup", "eve has no action 'pickup', which needs the component 'claw'"),
        (find_topic, "/hal/odom", "no robot 'hal'; there are: wall_e, eve"),
        (find_topic, "/wall_e/odm", "no topic '/wall_e/odm'; did you mean 'odom'?"),
        (find_topic, "/wally/odom", "there is no robot 'wally'; did you mean 'wall_e'?"),
        (find_topic, "/clock", "no topic '/clock'; did you mean '/_world/clock'?"),
        (find_action, "/wally/wait", "no robot 'wally'; did you mean 'wall_e'?"),
        (find_action, "/wall_e/wat", "wall_e has no action 'wat'; did you mean 'wait'?"),
    ],
)
def test_an_unknown_name_is_an_error_with_a_suggestion_or_list(find, name, meant):
    with pytest.raises(UnknownName) as error:
        find(INFO, name)
    assert str(error.value).endswith(meant)


def test_the_tree_topic_is_found_but_not_listed():
    """The topic exists only if the robot has a controller."""
    topic = find_topic(INFO, "/wall_e/_tree")

    assert ("hmrsim/wall_e/_tree", True) == (topic.key(Keys()), topic.latched)
    assert "/wall_e/_tree" not in [one.name for one in topics(INFO)]


WITH_ALIAS = {"robots": [{"name": "eve", "actions": ["wait"]}], "aliases": {"wait/eve": "eve/wait"}}


def test_a_simulator_that_lists_no_services_has_two():
    assert [Service("/_world/info", "hmrsim/WorldInfo"), Service("/_world/route_graph", "hmrsim/RouteGraph")] == [
        one for one in services(WITH_ALIAS) if not one.hidden
    ]


def test_listed_services_replace_the_built_in_ones():
    reported = [
        {"name": "_world/get_entities", "type": "simulation_interfaces/srv/GetEntities"},
        {"name": "_world/info", "type": "hmrsim/Other"},
    ]

    assert [
        Service("/_world/info", "hmrsim/Other"),
        Service("/_world/route_graph", "hmrsim/RouteGraph"),
        Service("/_world/get_entities", "simulation_interfaces/srv/GetEntities"),
    ] == list(services({"services": reported}))


def test_an_action_has_hidden_services():
    """An action has four services under each of its names, three of them with ROS 2's types."""
    assert [
        Service("/eve/wait/_action/send_goal", "nav2_msgs/action/Wait_SendGoal", hidden=True),
        Service("/eve/wait/_action/cancel_goal", "action_msgs/srv/CancelGoal", hidden=True),
        Service("/eve/wait/_action/get_result", "nav2_msgs/action/Wait_GetResult", hidden=True),
        Service("/eve/wait/_action/execute", "hmrsim/Execute", hidden=True),
        Service("/wait/eve/_action/send_goal", "nav2_msgs/action/Wait_SendGoal", hidden=True),
        Service("/wait/eve/_action/cancel_goal", "action_msgs/srv/CancelGoal", hidden=True),
        Service("/wait/eve/_action/get_result", "nav2_msgs/action/Wait_GetResult", hidden=True),
        Service("/wait/eve/_action/execute", "hmrsim/Execute", hidden=True),
    ] == [one for one in services(WITH_ALIAS) if one.hidden]

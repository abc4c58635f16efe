"""The actions, services and topics of a running simulation."""

from __future__ import annotations

import pytest

from hmrsim.cli.exits import UnknownName, WrongUse
from hmrsim.cli.names import Service, actions, find_action, find_topic, services, topics
from hmrsim_zenoh.wire.keys import Keys

INFO = {
    "robots": [{"name": "wall_e", "actions": ["pickup", "wait"]}, {"name": "eve", "actions": ["dance"]}],
    "aliases": {"wall_e/grab": "wall_e/pickup", "wait/wall_e": "wall_e/wait"},
}


@pytest.mark.parametrize("name", ["/wall_e/pickup", "wall_e/pickup", "/wall_e/grab", "wall_e/grab"])
def test_names_of_one_action(name):
    """The first slash is optional, and an alias stands for its target."""
    found = find_action(INFO, name)

    assert ("wall_e", "pickup", "moveit_msgs/action/Pickup") == (found.robot, found.action, found.ros_type)


@pytest.mark.parametrize("name", ["", "/", "wall_e", "/wall_e/", "wall_e/pickup/x", "//pickup"])
def test_a_name_has_two_words(name):
    """A name that is not of the form ROBOT/ACTION is wrong use."""
    with pytest.raises(WrongUse, match="expected /ROBOT/ACTION"):
        find_action(INFO, name)


def test_unknown_robot():
    """The error for an unknown robot lists the robots."""
    with pytest.raises(UnknownName, match="no robot 'hal'; there are: wall_e, eve"):
        find_action(INFO, "/hal/pickup")


def test_unknown_action():
    """The error for an unknown action lists the robot's actions."""
    with pytest.raises(UnknownName, match="wall_e has no action 'fly'; it has: pickup, wait"):
        find_action(INFO, "/wall_e/fly")


def test_action_for_want_of_a_component():
    """If the action exists, the error names the component that the robot lacks."""
    with pytest.raises(UnknownName, match=r"eve has no action 'pickup', which needs the component 'claw'$"):
        find_action(INFO, "/eve/pickup")


def test_action_that_is_not_installed_here():
    """An action that is not installed here has no messages."""
    with pytest.raises(UnknownName, match="'dance' is not installed here"):
        find_action(INFO, "/eve/dance").definition()


def test_actions_have_all_their_names():
    """Aliases come last."""
    names = [action.name for action in actions(INFO)]

    assert ["/wall_e/pickup", "/wall_e/wait", "/eve/dance", "/wall_e/grab", "/wait/wall_e"] == names


def test_topics_of_robots_actions_and_world():
    """All published topics are listed."""
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
def test_key_of_a_topic(name, key, latched):
    """A topic is found by its name or an alias."""
    topic = find_topic(INFO, name)

    assert (key, latched) == (topic.key(Keys()), topic.latched)


def test_topic_of_unknown_robot():
    """The error for an unknown robot lists the robots."""
    with pytest.raises(UnknownName, match=r"no robot 'hal'; there are: wall_e, eve$"):
        find_topic(INFO, "/hal/odom")


def test_unknown_topic():
    """The error for an unknown topic lists the robot's topics."""
    with pytest.raises(UnknownName, match="no topic '/eve/smell'; eve has: odom, dance/_action/feedback"):
        find_topic(INFO, "/eve/smell")


@pytest.mark.parametrize(
    ("find", "name", "meant"),
    [
        (find_topic, "/wall_e/odm", "no topic '/wall_e/odm'; did you mean 'odom'?"),
        (find_topic, "/wally/odom", "there is no robot 'wally'; did you mean 'wall_e'?"),
        (find_topic, "/clock", "no topic '/clock'; did you mean '/_world/clock'?"),
        (find_action, "/wally/wait", "no robot 'wally'; did you mean 'wall_e'?"),
        (find_action, "/wall_e/wat", "wall_e has no action 'wat'; did you mean 'wait'?"),
    ],
)
def test_the_most_similar_name_is_suggested(find, name, meant):
    """A suggestion helps more than a list of a hundred robots."""
    with pytest.raises(UnknownName) as error:
        find(INFO, name)
    assert str(error.value).endswith(meant)


def test_a_robot_may_have_a_tree():
    """The topic is found but not listed, since it needs a controller."""
    topic = find_topic(INFO, "/wall_e/_tree")

    assert ("hmrsim/wall_e/_tree", True) == (topic.key(Keys()), topic.latched)
    assert "/wall_e/_tree" not in [one.name for one in topics(INFO)]


WITH_ALIAS = {"robots": [{"name": "eve", "actions": ["wait"]}], "aliases": {"wait/eve": "eve/wait"}}


def test_services_of_every_simulator():
    """A simulator that lists no services has two."""
    assert [
        Service("/_world/info", "hmrsim/WorldInfo"),
        Service("/_world/route_graph", "hmrsim/RouteGraph"),
    ] == [one for one in services(WITH_ALIAS) if not one.hidden]


def test_services_that_the_simulator_lists():
    """Services that the simulator lists override the built-in ones."""
    told = [
        {"name": "_world/get_entities", "type": "simulation_interfaces/srv/GetEntities"},
        {"name": "_world/info", "type": "hmrsim/Other"},
    ]

    assert [
        Service("/_world/info", "hmrsim/Other"),
        Service("/_world/route_graph", "hmrsim/RouteGraph"),
        Service("/_world/get_entities", "simulation_interfaces/srv/GetEntities"),
    ] == list(services({"services": told}))


def test_actions_are_made_of_hidden_services():
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

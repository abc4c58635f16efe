"""Which services there are."""

from __future__ import annotations

from hmrsim.cli.services import Service, services

INFO = {"robots": [{"name": "eve", "actions": ["wait"]}], "aliases": {"wait/eve": "eve/wait"}}


def test_what_every_simulator_has():
    """A simulator that tells no services has the two fixed ones."""
    assert [
        Service("/_world/info", "hmrsim/WorldInfo"),
        Service("/_world/route_graph", "hmrsim/RouteGraph"),
    ] == [one for one in services(INFO) if not one.hidden]


def test_what_the_simulator_tells():
    """The list comes from the simulator; what it tells of the fixed ones replaces what we know."""
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
    """Each has four, by each of its names, three of them with ROS 2's types."""
    assert [
        Service("/eve/wait/_action/send_goal", "nav2_msgs/action/Wait_SendGoal", hidden=True),
        Service("/eve/wait/_action/cancel_goal", "action_msgs/srv/CancelGoal", hidden=True),
        Service("/eve/wait/_action/get_result", "nav2_msgs/action/Wait_GetResult", hidden=True),
        Service("/eve/wait/_action/execute", "hmrsim/Execute", hidden=True),
        Service("/wait/eve/_action/send_goal", "nav2_msgs/action/Wait_SendGoal", hidden=True),
        Service("/wait/eve/_action/cancel_goal", "action_msgs/srv/CancelGoal", hidden=True),
        Service("/wait/eve/_action/get_result", "nav2_msgs/action/Wait_GetResult", hidden=True),
        Service("/wait/eve/_action/execute", "hmrsim/Execute", hidden=True),
    ] == [one for one in services(INFO) if one.hidden]

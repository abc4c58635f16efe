"""Why robots do not go on."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.protocol.commands import CallService, SendGoal
from hmrsim.services import registry as services
from hmrsim.simulation.snapshot import scene
from hmrsim.traffic.causes import Link, chain_of
from tests.simulation import simulate

LINE = {
    "waypoints": {name: [4 * number, 0] for number, name in enumerate("abcde")},
    "lanes": [["a", "b"], ["b", "c"], ["c", "d"], ["d", "e"]],
}
ALL_POLICIES = pytest.mark.parametrize("policy", ["reserve", "priority", "planned"])


def send(robot, action, **goal):
    goal = registry()[action].goal.model_validate(goal, strict=False)
    return SendGoal(robot, action, goal, f"{sum(map(ord, robot)):032x}")


def go(robot, x):
    return send(robot, "navigate_to_pose", pose={"pose": {"position": {"x": x}}})


def chain(robot, *commands, until=30.0, policy="reserve", **world):
    """Return the causes in the scene of a run: the robots and kinds of the links, the last text, and the help."""
    traffic = {"policy": policy, "patience": 60}
    run = simulate({**LINE, "traffic": traffic, **world})
    run(*commands, until=until)
    links = {each["name"]: Link(**each["cause"]) for each in scene(run.simulator)["robots"]}
    found = chain_of(robot, links.__getitem__)
    return [(link.robot, link.kind) for link in found.links], found.links[-1].text, found.help


@ALL_POLICIES
def test_a_chain_leads_to_the_idle_robot_that_starts_it(policy):
    robots = {"r1": {"at": "a"}, "r2": {"at": "b"}, "r3": {"at": "e"}}
    links, text, remedy = chain("r1", (0.0, go("r1", 16)), (0.0, go("r2", 16)), robots=robots, policy=policy)

    assert [("r1", "robots"), ("r2", "robots"), ("r3", "idle")] == links
    assert "r3 is idle at e: it has had no goal yet" == text
    assert remedy.startswith("send r1, then r2 elsewhere, then r3, which can't leave before")


@ALL_POLICIES
def test_a_robot_in_a_dead_end_cannot_get_out_past_the_waiting_one(policy):
    run = simulate({**LINE, "traffic": {"policy": policy}, "robots": {"r1": {"at": "a"}, "r2": {"at": "e"}}})
    run((0.0, go("r1", 16)), until=30.0)

    why = "makes no room under the policy 'reserve'" if policy == "reserve" else "can't get out past r1"
    cause = scene(run.simulator)["robots"][0]["cause"]
    assert f"r1 has waited at d since 12 s for r2, which {why}" == cause["text"]
    assert ("robots", ["r2"], "r2") == (cause["kind"], cause["held_by"], cause["next"])


DEAD_END = {
    "waypoints": {"west": [0, 0], "mouth": [4, 0], "east": [8, 0], "alley": [4, 4], "face": [4, 8]},
    "lanes": [["west", "mouth"], ["mouth", "east"], ["mouth", "alley"], ["alley", "face"]],
    "robots": {"hauler": {"at": "west"}, "digger": {"at": "face"}},
}


def to(robot, name, goal_id):
    x, y = DEAD_END["waypoints"][name]
    return send(robot, "navigate_to_pose", pose={"pose": {"position": {"x": x, "y": y}}})._replace(goal_id=goal_id * 32)


def test_the_help_in_a_dead_end_works():
    """To send the robot in the dead end elsewhere does not help, as the other one stands before it."""
    run = simulate({**DEAD_END, "traffic": {"policy": "reserve", "patience": None}})
    run((0.0, to("hauler", "face", "a")), until=30.0)
    told = str(run.simulator.roster.admission.causes.chain(run.simulator.robots["hauler"]))

    steps = "send hauler to east, then digger to west, then hauler to its goal again"
    assert told.endswith(
        f"what would help: {steps}: digger can't leave before hauler; or use the traffic policy `planned`, under which "
        "idle robots make room"
    )
    moves = [("hauler", "east", "b"), ("digger", "west", "c"), ("hauler", "face", "d")]
    run(*((30.0 + 20 * number, to(*move)) for number, move in enumerate(moves)), until=200.0)
    assert ["SUCCEEDED"] * 3 == [run.log.changes(number * 32)[-1][1] for number in "bcd"]


def test_the_help_in_a_dead_end_follows_robots_that_have_moved():
    world = {**DEAD_END, "waypoints": {**DEAD_END["waypoints"], "far": [12, 0]}}
    world["lanes"] = [*DEAD_END["lanes"], ["east", "far"]]
    world["robots"] = {**DEAD_END["robots"], "truck": {"at": "far"}}
    run = simulate({**world, "traffic": {"policy": "reserve", "patience": None}})
    causes = run.simulator.roster.admission.causes
    run((0.0, to("hauler", "face", "a")), until=30.0)
    before = causes.chain(run.simulator.robots["hauler"]).help
    run((30.0, to("truck", "east", "b")), until=60.0)
    after = causes.chain(run.simulator.robots["hauler"]).help

    assert before.startswith("send hauler to east, then digger to west")
    assert after.startswith("send hauler elsewhere, then digger, which can't leave before: they can't pass each other")


def test_the_help_in_a_dead_end_without_room_to_pass():
    links, _, remedy = chain("r1", (0.0, go("r1", 16)), robots={"r1": {"at": "a"}, "r2": {"at": "e"}}, policy="planned")

    assert [("r1", "robots"), ("r2", "idle")] == links
    assert remedy.startswith("send r1 elsewhere, then r2, which can't leave before: they can't pass each other here")


def test_the_help_where_no_robot_can_go_elsewhere():
    """Only r1 has room behind it, which does not help r3."""
    robots = {"r1": {"at": "a"}, "r2": {"at": "d"}, "r3": {"at": "e"}}
    for robot in ("r1", "r3"):
        _, _, remedy = chain(robot, (0.0, go("r1", 16)), (10.0, go("r3", 0)), robots=robots, policy="planned")

        assert remedy.startswith("add a waypoint where one can move aside: r1, r2, r3 can't pass each other here")


def test_the_help_for_several_robots_before_a_dead_end():
    world = {**DEAD_END, "waypoints": {**DEAD_END["waypoints"], "far": [-4, 0]}}
    world["lanes"] = [*DEAD_END["lanes"], ["far", "west"]]
    world["robots"] = {**DEAD_END["robots"], "truck": {"at": "far"}}
    run = simulate({**world, "traffic": {"policy": "reserve", "patience": None}})
    run((0.0, to("hauler", "face", "a")), (0.0, to("truck", "face", "b")), until=30.0)
    told = str(run.simulator.roster.admission.causes.chain(run.simulator.robots["truck"]))

    steps = (
        "send truck to west, then hauler to east, then truck to far, then digger to west, then hauler to its goal again"
    )
    assert f"what would help: {steps}: digger can't leave before hauler" in told


def test_the_help_for_a_robot_that_idle_ones_shut_in():
    robots = {"r1": {"at": "a"}, "r2": {"at": "b"}, "r3": {"at": "c"}}
    _, _, remedy = chain("r1", (0.0, go("r1", 16)), robots=robots)

    assert remedy.startswith("send r3 elsewhere first, as r2 can't leave before")


def test_a_robot_that_works_is_a_cause():
    robots = {"r1": {"at": "a"}, "r2": {"at": "c"}}
    links, text, remedy = chain("r1", (0.0, go("r1", 16)), (0.0, send("r2", "wait", time={"sec": 100})), robots=robots)

    assert ([("r1", "robots"), ("r2", "works")], "r2 executes wait at c") == (links, text)
    assert "wait until its goal has ended, or cancel it" == remedy


def test_a_queue_leads_to_the_robot_in_the_dock():
    kinds = {"t": {"components": {"battery": {"capacity": 1000, "initial_charge": 100}}}}
    robots = {"r1": {"at": "a", "type": "t"}, "r2": {"at": "d", "type": "t"}}
    dock = {"charger": {"at": [16, 2], "type": "charger"}}
    commands = [(0.0, send(robot, "dock_robot", dock_id="charger")) for robot in ("r2", "r1")]
    links, text, _ = chain("r1", *commands, robots=robots, docks=dock, robot_types=kinds)

    assert [("r1", "queue"), ("r2", "docked")] == links
    assert "r2 is charging in 'charger' at charger: it has had no goal since dock_robot SUCCEEDED at 6 s" == text


def test_a_closed_lane_leads_to_the_robot_that_has_broken_down_on_it():
    robots = {"r1": {"at": "a"}, "r2": {"at": "b"}}
    faults = [{"type": "breakdown", "robot": "r2", "at": 3}]
    links, _, remedy = chain("r1", (0.0, go("r1", 16)), (0.0, go("r2", 16)), robots=robots, faults=faults)

    assert [("r1", "obstacle"), ("r2", "disabled")] == links
    assert "hmrsim fault clear" in remedy


@pytest.mark.parametrize(
    ("kind", "remedy"),
    [
        ("lane_closed", "end the fault: `hmrsim fault clear lane_closed_1`"),
        ("door_jammed", "end the fault: `hmrsim fault clear door_jammed`"),
    ],
)
def test_the_fault_that_closes_a_lane_is_named(kind, remedy):
    doors = {"gate": {"at": [[6, -1], [6, 1]]}}
    fault = {"type": kind, "at": 1, **({"door": "gate"} if kind == "door_jammed" else {"lane": ["b", "c"]})}
    links, _, told = chain("r1", (0.0, go("r1", 16)), robots={"r1": {"at": "a"}}, doors=doors, faults=[fault])

    assert ([("r1", "obstacle")], remedy) == (links, told)


def test_a_locked_door_is_named():
    doors = {"gate": {"at": [[6, -1], [6, 1]]}}
    request = services()["set_door_state"].request.model_validate({"name": "gate", "state": "locked"})
    lock = CallService("set_door_state", request, object())
    *_, told = chain("r1", (0.0, go("r1", 16)), (1.0, lock), robots={"r1": {"at": "a"}}, doors=doors)

    assert "open the door: `hmrsim service call /_world/set_door_state '{name: gate, state: open}'`" == told


def test_a_door_that_opens_needs_no_help():
    doors = {"gate": {"at": [[6, -1], [6, 1]], "opening_time": 90}}
    links, text, remedy = chain("r1", (0.0, go("r1", 16)), robots={"r1": {"at": "a"}}, doors=doors)

    assert [("r1", "obstacle")] == links
    assert "r1 has waited at b since 4 s: gate is opening" == text
    assert remedy.startswith("nothing")


def test_a_robot_without_a_goal_waits_for_its_controller():
    links, text, remedy = chain("r1", (0.0, go("r1", 4)), robots={"r1": {"at": "a"}})

    assert [("r1", "idle")] == links
    assert "r1 is idle at b: it has had no goal since navigate_to_pose SUCCEEDED at 4 s" == text
    assert remedy.startswith("its controller has to send it a goal")


def test_a_request_for_a_path_is_not_the_last_goal_of_an_idle_robot():
    plan = send("r1", "compute_path_to_pose", goal={"pose": {"position": {"x": 4}}})
    _, text, _ = chain("r1", (0.0, go("r1", 8)), (20.0, plan._replace(goal_id="f" * 32)), robots={"r1": {"at": "a"}})

    assert "r1 is idle at c: it has had no goal since navigate_to_pose SUCCEEDED at 8 s" == text


def test_a_robot_without_connection_gets_no_goal():
    faults = [{"type": "messages_lost", "robot": "r1", "at": 1}]
    _, text, remedy = chain("r1", robots={"r1": {"at": "a"}}, faults=faults)

    assert "r1 is idle at a: its connection is lost" == text
    assert "restore its connection" in remedy


def test_robots_that_give_up_at_the_same_instant_name_the_same_cause():
    robots = {"r1": {"at": "a"}, "r2": {"at": "b"}, "r3": {"at": "d"}}
    run = simulate({**LINE, "traffic": {"policy": "reserve"}, "robots": robots})
    log = run((0.0, go("r1", 16)), (0.0, go("r2", 16)), until=100.0)

    gave_up = log.happened("gave_up_waiting")
    assert [(64.0, "r2"), (64.0, "r1")] == [(at, fields["robot"]) for at, fields in gave_up]
    assert all("r3 is idle at d: it has had no goal yet" in fields["why"] for _, fields in gave_up)


def waits(robot, following):
    return Link(robot, "robots", f"{robot} has waited", next=following, help="apart")


def test_a_circle_is_told_in_words():
    links = {"a": waits("a", "b"), "b": waits("b", "c"), "c": waits("c", "b")}
    found = chain_of("a", links.__getitem__)

    assert ["robots", "robots", "circle"] == [link.kind for link in found.links]
    assert "c has waited, which closes a circle: b → c → b" == found.links[-1].text
    assert "apart" == found.help


def test_a_long_chain_is_cut_in_messages():
    links = {f"r{number}": waits(f"r{number}", f"r{number + 1}") for number in range(2000)}
    found = chain_of("r0", {**links, "r2000": Link("r2000", "idle", "r2000 is idle", help="go")}.__getitem__)

    assert 2001 == len(found.links)
    told = "r0 has waited; r1 has waited; r2 has waited; … 1997 more …; r2000 is idle; what would help: go"
    assert told == str(found)


def stopped(*commands, until):
    """Return the results of the goals of r1 and r2 that the end of a run aborts."""
    robots = {"r1": {"at": "a"}, "r2": {"at": "c"}}
    run = simulate({**LINE, "traffic": {"policy": "reserve", "patience": None}, "robots": robots})
    log = run(*commands, until=until)
    run.simulator.stop("it is over")
    run.simulator.run()
    return log.result(go("r1", 0).goal_id).error_msg


def test_a_goal_that_the_end_of_a_run_aborts_tells_why_its_robot_waited():
    message = stopped((0.0, go("r1", 16)), until=30.0)

    assert message.startswith("it is over; r1 has waited at b since 4 s for r2")
    assert "r2 is idle at c: it has had no goal yet; what would help:" in message


def test_a_robot_that_waits_for_one_that_moves_is_not_stuck():
    wait = send("r2", "wait", time={"sec": 20})

    assert "it is over" == stopped((0.0, wait), (0.0, go("r1", 12)), (20.0, go("r2", 16)), until=21.0)

"""What is wrong with a network, judged by what was found there."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hmrsim.actions import registry
from hmrsim_zenoh.doctor import Simulator, Snapshot, problems
from hmrsim_zenoh.doctor.ros2_checks import incomplete_actions, later_actions
from hmrsim_zenoh.doctor.snapshot import first_few
from hmrsim_zenoh.ros2.codec.types import action_type
from hmrsim_zenoh.ros2.keys import NO_HASH, Endpoint, Kind, Node, Token

US, THEM, OTHERS = "aa", "bb", "cc"
INFO = {
    "contract": 1,
    "hmrsim": "0.1.0",
    "robots": [{"name": "wall_e", "actions": ["wait"], "planner": "graph"}],
    "actions": [],
}
TIME = {"now": 3.0, "clock": "realtime", "paused": False, "participants": [], "waiting_for": [], "lag": 0.0}
SEND = "/wall_e/wait/_action/send_goal"


def simulator(info=(), **fields):
    """Return a simulator with which nothing is wrong, but for what is given."""
    return Simulator(
        **{"info": {**INFO, **dict(info)}, "session": US, "times": (TIME, TIME), "alive": frozenset({"wall_e"})}
        | fields
    )


def stood(**fields):
    """Return a simulator whose time was the same at two looks."""
    return simulator(times=({**TIME, **fields},) * 2, watched=0.5)


def network(**fields):
    """Return a network with which nothing is wrong, but for what is given."""
    return Snapshot(
        **{"endpoints": ("tcp/h:1",), "routers": (US,), "prefixes": ("hmrsim",), "simulator": simulator()} | fields
    )


def token(kind, name, type_, hash_, session=US, node="n"):
    """Return the endpoint of a token."""
    return Token(session, Node("/", node), Endpoint(kind, name, type_, hash_))


def action_tokens(name="/wall_e/wait", session=US):
    """Return the tokens of an action server, whole."""
    wait = registry()["wait"]
    type_ = action_type(wait.ros_type, wait.goal, wait.result, wait.feedback)
    parts = {
        "send_goal": (Kind.SERVICE, type_.send_goal),
        "cancel_goal": (Kind.SERVICE, type_.cancel_goal),
        "get_result": (Kind.SERVICE, type_.get_result),
        "feedback": (Kind.PUBLISHER, type_.feedback),
        "status": (Kind.PUBLISHER, type_.status),
    }
    return [token(kind, f"{name}/_action/{part}", of.dds_name, of.hash, session) for part, (kind, of) in parts.items()]


SERVED = action_tokens()
OURS = Token(US, Node("/", "hmrsim"))
TYPE, HASH = SERVED[0].endpoint.type, SERVED[0].endpoint.hash


def client(name=SEND, type_=TYPE, hash_=HASH, node="nav"):
    """Return the token of a service's client."""
    return token(Kind.CLIENT, name, type_, hash_, THEM, node)


def ros(*tokens, domain=0, **fields):
    """Return a network where ROS nodes are, too."""
    return network(tokens={domain: (*SERVED, *tokens)}, **fields)


def kinds(snapshot):
    """Return what kinds of problem there are."""
    return [problem.kind for problem in problems(snapshot)]


@pytest.mark.parametrize(
    "snapshot",
    [
        network(),
        ros(),
        ros(client()),
        ros(client(), environment={"RMW_IMPLEMENTATION": "rmw_zenoh_cpp", "ROS_DISTRO": "jazzy", "ROS_DOMAIN_ID": "0"}),
        ros(environment={"ZENOH_CONFIG_OVERRIDE": 'mode="client";connect/endpoints=["tcp/h:1"]'}),
        ros(environment={"ZENOH_ROUTER_CONFIG_URI": "/no/such.json5"}),
        network(simulator=stood(now=4.0, clock="lockstep", participants=["a"])),
    ],
)
def test_nothing_is_wrong(snapshot):
    """A simulator that works, with or without ROS nodes, has no problems."""
    assert [] == kinds(snapshot)


@pytest.mark.parametrize(
    ("snapshot", "kind"),
    [
        (network(simulator=None, prefixes=()), "no_simulator"),
        (network(simulator=None, prefixes=("lab",)), "other_prefix"),
        (ros(client(), routers=(), peers=(US,)), "no_router"),
        (network(wants_ros=True), "no_ros2"),
        (network(tokens={0: (Token(THEM, Node("/", "n")),)}), "no_ros2"),
        (ros(environment={"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}), "other_middleware"),
        (ros(environment={"ROS_DISTRO": "jazzy"}), "other_middleware"),
        (
            ros(environment={"ROS_DISTRO": "humble", "RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}),
            "other_distribution",
        ),
        (ros(environment={"ROS_DOMAIN_ID": "x"}), "no_domain"),
        (ros(environment={"ROS_DOMAIN_ID": "233"}), "no_domain"),
        (ros(environment={"ROS_DOMAIN_ID": "7" * 5000}), "no_domain"),
        (ros(environment={"ZENOH_SESSION_CONFIG_URI": "x" * 5000}), "no_configuration"),
        (network(simulator=simulator(twins=(OTHERS,))), "two_simulators"),
        (ros(environment={"ROS_DOMAIN_ID": "4"}), "domain_of_this_shell"),
        (ros(environment={"ZENOH_SESSION_CONFIG_URI": "/no/such.json5"}), "no_configuration"),
        (ros(environment={"ZENOH_CONFIG_OVERRIDE": "mode='client'"}), "own_configuration"),
        (ros(unreadable=("@ros2_lv/0/x",)), "unreadable_tokens"),
        (network(simulator=simulator({"contract": 2})), "contract"),
        (network(simulator=simulator({"robots": []})), "no_robots"),
        (network(simulator=simulator({"robots": [{"name": "wall_e"}]})), "no_actions"),
        (network(simulator=simulator(alive=frozenset())), "no_token"),
        (network(simulator=simulator({"robots": [{**INFO["robots"][0], "planner": "external"}]})), "no_planner"),
        (network(simulator=stood(paused=True)), "paused"),
        (network(simulator=stood(participants=["a"], waiting_for=["a"])), "time_stands"),
        (network(simulator=stood(waiting_for=["1"])), "time_stands"),
        (network(simulator=stood(participants=["a"], waiting_for=["_planner"])), "time_stands"),
        (network(simulator=simulator(times=(TIME, {**TIME, "now": 4.0, "lag": 2.0}))), "lag"),
        (ros(domain=5), "other_domain"),
        (network(tokens={0: tuple(SERVED[1:])}), "incomplete_actions"),
        (ros(token(Kind.PUBLISHER, "/x", TYPE, "RIHS01_00")), "unknown_types"),
        (ros(*action_tokens(session=THEM)), "two_servers"),
        (ros(client("/wally/wait/_action/send_goal")), "no_server"),
        (ros(client(hash_=NO_HASH)), "different_types"),
        (
            ros(replace(SERVED[3], session=THEM, endpoint=replace(SERVED[3].endpoint, kind=Kind.SUBSCRIBER, hash="x"))),
            "different_types",
        ),
        (network(tokens={0: tuple(SERVED), 5: (client(),)}), "client_in_other_domain"),
    ],
)
def test_each_problem_alone(snapshot, kind):
    """Each thing that is wrong is one problem, with something to do about it."""
    (problem,) = problems(snapshot)

    assert kind == problem.kind
    assert "" != problem.remedy
    assert "\n" not in f"{problem.text}{problem.remedy}"


def text(snapshot):
    """Return the text of the one problem."""
    (problem,) = problems(snapshot)
    return f"{problem.text}; {problem.remedy}"


def test_name_that_is_close_is_proposed():
    """A mistyped robot name is reported with the right one."""
    assert "/nav waits for /wally/wait, which has no server; did you mean /wall_e/wait?" == text(
        ros(client("/wally/wait/_action/send_goal"), client("/wally/wait/_action/get_result"))
    )


def test_server_in_another_domain_is_named():
    """A client whose server is in another domain is reported with that domain."""
    snapshot = network(simulator=None, prefixes=(), tokens={0: (client(),), 5: tuple(action_tokens(session=OTHERS))})

    assert "/nav waits for /wall_e/wait, which has no server in domain 0, but in domain 5" in problems(snapshot)[1].text


def test_some_clients_without_server_are_a_warning():
    """A node such as nav2_simple_commander's asks for more than it needs."""
    (problem,) = problems(ros(client(), client("/map_server/load_map")))

    assert ("no_server", "warning") == (problem.kind, problem.severity)


def test_many_clients_of_a_node_are_one_problem():
    """Names are grouped, and not all are listed."""
    names = [f"/r{number}/fly" for number in range(7)]

    assert text(ros(*map(client, names))).startswith("/nav waits for /r0/fly, /r1/fly, /r2/fly, /r3/fly and 3 more")


def test_client_of_humble():
    """Both hashes are reported, with advice on what to use."""
    assert (
        f"/nav is incompatible with {SEND}: its hash is {NO_HASH} (humble), the server's {HASH} "
        "(jazzy, kilted, lyrical); humble is not supported; use jazzy, kilted or lyrical"
    ) == text(ros(client(hash_=NO_HASH)))


def test_client_of_another_server():
    """A client that is incompatible with a robot gets no remedy for the simulator."""
    served = action_tokens("/real/wait", OTHERS)
    asked = client("/real/wait/_action/send_goal", hash_="RIHS01_00")

    assert text(ros(*served, asked)).endswith("build client and server against the same nav2_msgs")


def test_waiting_participant_is_named():
    """If time stands still, the doctor names the participants that it waits for."""
    assert "time stands at 3 s, for 0.5 s at least: waiting for nurses to advance" in text(
        network(simulator=stood(participants=["nurses", "porters"], waiting_for=["nurses"]))
    )


def test_number_of_participants_that_are_missing():
    """Participants whose names are not known are counted."""
    assert "time stands at 3 s: waiting for 2 more to join in lockstep;" in text(
        network(simulator=stood(participants=["a"], waiting_for=["2 more to join", "a"]))
    )


def test_client_without_a_namespace():
    """A client of an action that several robots serve is reported with all of them."""
    served = (*SERVED, *action_tokens("/eve/wait"))

    assert "/nav waits for /wait, which has no server; give it a namespace: eve, wall_e" == text(
        network(tokens={0: (*served, client("/wait/_action/send_goal"))})
    )


def test_action_that_two_programs_serve():
    """Its parts are not listed one by one, and the advice names the simulator's option."""
    assert (
        "2 programs serve /wall_e/wait (nodes /n): both execute each goal and request; end one of them, "
        "or start the simulator with another --ros-domain-id"
    ) == text(ros(*action_tokens(session=THEM)))


def test_robot_out_of_reach_is_reported_as_one():
    """The text has the singular for one robot, and the plural for several."""
    assert text(network(simulator=simulator(alive=frozenset()))).startswith("wall_e is unreachable: ")


@pytest.mark.parametrize(
    ("endpoint", "command"),
    [
        ("tcp/127.0.0.1:7447", "start `hmrsim run WORLD --ros2`"),
        ("tcp/localhost:7447", "start `hmrsim run WORLD --ros2`"),
        ("tcp/h:1", "start `hmrsim run WORLD --ros2 --connect tcp/h:1`"),
    ],
)
def test_simulator_joins_by_itself_where_it_would_listen(endpoint, command):
    """Elsewhere it needs the option to join."""
    assert command == problems(network(endpoints=(endpoint,), simulator=None, prefixes=()))[0].remedy


def test_errors_come_before_warnings():
    """Errors, which have to be fixed, come first."""
    found = problems(ros(client(), client("/x"), unreadable=("y",), environment={"RMW_IMPLEMENTATION": "z"}))

    assert ["error", "warning", "warning"] == [problem.severity for problem in found]


def test_robots_of_large_worlds_have_no_tokens():
    """No robot counts as missing in a world with too many robots for tokens."""
    robots = [{"name": f"r{number}", "actions": ["wait"]} for number in range(1001)]

    assert [] == kinds(network(simulator=simulator({"robots": robots}, alive=frozenset())))


def test_robots_out_of_reach_are_one_problem():
    """Their actions are not there either, as the robots are out of reach; that is no second problem."""
    assert ["no_token"] == kinds(network(simulator=simulator(alive=frozenset()), tokens={0: (OURS,)}))


def test_missing_parts_of_an_action():
    """Three services and two publishers make an action."""
    assert {"/wall_e/wait": ["cancel_goal", "status"]} == incomplete_actions(
        network(tokens={0: (SERVED[0], *SERVED[2:4])})
    )


def test_actions_that_are_declared_later():
    """One that is missing as a whole is no problem: in a large fleet, it is declared when a client looks for it."""
    snapshot = network(tokens={0: tuple(action_tokens("/wall_e/spin"))})

    assert {} == incomplete_actions(snapshot)
    assert ["/wall_e/wait"] == later_actions(snapshot)


@pytest.mark.parametrize(("count", "words"), [(0, ""), (1, "0"), (5, "0, 1, 2, 3, 4"), (6, "0, 1, 2, 3 and 2 more")])
def test_some_of_many(count, words):
    """A single remaining name is listed rather than counted."""
    assert words == first_few(map(str, range(count)))

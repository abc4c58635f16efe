"""Problems of a network, as the doctor derives them from its findings."""

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
    """Return a healthy simulator, with some fields changed."""
    return Simulator(
        **{"info": {**INFO, **dict(info)}, "session": US, "times": (TIME, TIME), "alive": frozenset({"wall_e"})}
        | fields
    )


def stood(**fields):
    """Return a simulator whose time was the same at two looks."""
    return simulator(times=({**TIME, **fields},) * 2, watched=0.5)


def network(**fields):
    """Return a healthy network, with some fields changed."""
    return Snapshot(
        **{"endpoints": ("tcp/h:1",), "routers": (US,), "prefixes": ("hmrsim",), "simulator": simulator()} | fields
    )


def token(kind, name, type_, hash_, session=US, node="n"):
    return Token(session, Node("/", node), Endpoint(kind, name, type_, hash_))


def action_tokens(name="/wall_e/wait", session=US):
    """Return the tokens of an action server, whole."""
    type_ = action_type(registry()["wait"])
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
    """Return a network with ROS nodes."""
    return network(tokens={domain: (*SERVED, *tokens)}, **fields)


def kinds(snapshot):
    """Return the kinds of all problems."""
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
def test_a_healthy_network_has_no_problems(snapshot):
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
        (ros(environment={"ROS_DISTRO": "humble", "RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}), "other_distribution"),
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
def test_each_fault_is_one_problem_with_a_remedy(snapshot, kind):
    (problem,) = problems(snapshot)

    assert kind == problem.kind
    assert "" != problem.remedy
    assert "\n" not in f"{problem.text}{problem.remedy}"


def text(snapshot):
    """Return the text of the one problem."""
    (problem,) = problems(snapshot)
    return f"{problem.text}; {problem.remedy}"


def test_a_mistyped_robot_name_is_reported_with_the_right_one():
    assert "/nav waits for /wally/wait, which has no server; did you mean /wall_e/wait?" == text(
        ros(client("/wally/wait/_action/send_goal"), client("/wally/wait/_action/get_result"))
    )


def test_a_server_in_another_domain_is_named():
    snapshot = network(simulator=None, prefixes=(), tokens={0: (client(),), 5: tuple(action_tokens(session=OTHERS))})

    assert "/nav waits for /wall_e/wait, which has no server in domain 0, but in domain 5" in problems(snapshot)[1].text


def test_some_clients_without_server_are_a_warning():
    """Nodes such as nav2_simple_commander create more clients than they need."""
    (problem,) = problems(ros(client(), client("/map_server/load_map")))

    assert ("no_server", "warning") == (problem.kind, problem.severity)


def test_many_clients_of_a_node_are_grouped_and_abridged():
    names = [f"/r{number}/fly" for number in range(7)]

    assert text(ros(*map(client, names))).startswith("/nav waits for /r0/fly, /r1/fly, /r2/fly, /r3/fly and 3 more")


def test_a_client_of_humble_is_reported_with_both_hashes_and_advice():
    assert (
        f"/nav is incompatible with {SEND}: its hash is {NO_HASH} (humble), the server's {HASH} "
        "(jazzy, kilted, lyrical, rolling); humble is not supported; use jazzy, kilted, lyrical or rolling"
    ) == text(ros(client(hash_=NO_HASH)))


def test_an_incompatible_client_of_a_robot_gets_no_remedy_for_the_simulator():
    served = action_tokens("/real/wait", OTHERS)
    asked = client("/real/wait/_action/send_goal", hash_="RIHS01_00")

    assert text(ros(*served, asked)).endswith("build client and server against the same nav2_msgs")


def test_participants_that_hold_the_time_are_named():
    assert "time stands at 3 s, for 0.5 s at least: waiting for nurses to advance" in text(
        network(simulator=stood(participants=["nurses", "porters"], waiting_for=["nurses"]))
    )


def test_unnamed_participants_are_counted():
    assert "time stands at 3 s: waiting for 2 more to join in lockstep;" in text(
        network(simulator=stood(participants=["a"], waiting_for=["2 more to join", "a"]))
    )


def test_a_client_without_a_namespace_is_reported_with_all_robots():
    served = (*SERVED, *action_tokens("/eve/wait"))

    assert "/nav waits for /wait, which has no server; give it a namespace: eve, wall_e" == text(
        network(tokens={0: (*served, client("/wait/_action/send_goal"))})
    )


def test_an_action_that_two_programs_serve_is_one_problem():
    """The advice names the simulator's option."""
    assert (
        "2 programs serve /wall_e/wait (nodes /n): both execute each goal and request; end one of them, "
        "or start the simulator with another --ros-domain-id"
    ) == text(ros(*action_tokens(session=THEM)))


def test_robots_out_of_reach_are_reported_in_singular_or_plural():
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
    found = problems(ros(client(), client("/x"), unreadable=("y",), environment={"RMW_IMPLEMENTATION": "z"}))

    assert ["error", "warning", "warning"] == [problem.severity for problem in found]


def test_no_robot_of_a_large_world_is_missing():
    """A large world has no tokens of robots."""
    robots = [{"name": f"r{number}", "actions": ["wait"]} for number in range(1001)]

    assert [] == kinds(network(simulator=simulator({"robots": robots}, alive=frozenset())))


def test_robots_out_of_reach_are_one_problem():
    """The missing actions of such a robot are not a second problem."""
    assert ["no_token"] == kinds(network(simulator=simulator(alive=frozenset()), tokens={0: (OURS,)}))


def test_an_action_with_missing_parts_is_reported():
    assert {"/wall_e/wait": ["cancel_goal", "status"]} == incomplete_actions(
        network(tokens={0: (SERVED[0], *SERVED[2:4])})
    )


def test_an_action_that_is_missing_altogether_is_no_problem():
    """Large fleets declare an action when a client looks for it."""
    snapshot = network(tokens={0: tuple(action_tokens("/wall_e/spin"))})

    assert {} == incomplete_actions(snapshot)
    assert ["/wall_e/wait"] == later_actions(snapshot)


@pytest.mark.parametrize(("count", "words"), [(0, ""), (1, "0"), (5, "0, 1, 2, 3, 4"), (6, "0, 1, 2, 3 and 2 more")])
def test_a_single_remaining_name_is_listed_instead_of_counted(count, words):
    assert words == first_few(map(str, range(count)))

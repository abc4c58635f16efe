"""Publishers and services of each node, and the contents of their tokens."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from zenoh_ros2_sdk.discovery import _parse_liveliness_keyexpr

from hmrsim.actions import registry as actions
from hmrsim.services import registry as services
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import World
from hmrsim_zenoh.ros2.keys import LATCHED_QOS, Kind, Node, endpoint_token
from hmrsim_zenoh.ros2.names import Names, names_of
from hmrsim_zenoh.ros2.publishing.endpoints import Endpoints, Owned, Part
from hmrsim_zenoh.ros2.publishing.parts import MAX_STANDING, Parts
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds, Wire

from tests.simulation import SMALL_WORLD  # isort: skip

NAVIGATE = Names({"wall_e": ["navigate_to_pose"]})
JAZZY = RmwZenoh(distros=("jazzy",))


def owned(names: Names, wire: Wire = JAZZY) -> list[Owned]:
    """Return all endpoints on a wire."""
    endpoints = Endpoints(wire, actions(), services())
    return [one for part in Parts(names).all for one in endpoints.of(part)]


def nodes_of(names: Names, robot: str) -> set[str]:
    """Return the names of a robot's nodes."""
    return {node.name for node, _ in owned(names) if node.namespace == f"/{robot}"}


@pytest.fixture(scope="module")
def small() -> Names:
    """Return the endpoints of the small world."""
    return names_of(Simulator(World.model_validate(SMALL_WORLD)))


def test_endpoints_of_an_action() -> None:
    """An action is three services and two publishers, in the node and with the hashes of Nav2."""
    expected = [
        (Kind.SERVICE, "send_goal", "RIHS01_a4fcb3bee1bf32e21a0e541a943b221aa0826996e2c98f079b47022b256f48b5"),
        (Kind.SERVICE, "cancel_goal", "RIHS01_573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a"),
        (Kind.SERVICE, "get_result", "RIHS01_c407920357d566771e8882b4ef4d1f1a84ee922d609920ccd57faa6d6e391dc5"),
        (Kind.PUBLISHER, "feedback", "RIHS01_9d1f6fa2eb975ce733b419ac2e97b134d8ff92b6478b6559feed9a50bdfd82b3"),
        (Kind.PUBLISHER, "status", "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e"),
    ]

    found = [
        (one.kind, one.name.removeprefix("/wall_e/navigate_to_pose/_action/"), one.hash)
        for node, one in owned(NAVIGATE)
        if node == Node("/wall_e", "bt_navigator") and "_action" in one.name
    ]

    assert expected == found


def test_each_layout_has_its_publisher() -> None:
    """Feedback that all distributions share is published once."""
    found = [one.name for _, one in owned(NAVIGATE, RmwZenoh())]

    assert 2 == found.count("/wall_e/navigate_to_pose/_action/feedback")
    assert 1 == found.count("/wall_e/navigate_to_pose/_action/send_goal")


def test_keys_without_a_hash_have_one_layout() -> None:
    found = [one.name for _, one in owned(NAVIGATE, Ros2Dds())]

    assert len(found) == len(set(found))


def test_status_is_latched() -> None:
    (status,) = [one for _, one in owned(NAVIGATE) if one.name.endswith("status")]

    assert LATCHED_QOS == status.qos


def test_nodes_without_endpoints_are_left_out(small: Names) -> None:
    assert "move_group" in nodes_of(small, "wall_e")
    assert "move_group" not in nodes_of(small, "cart")


def test_nav2_nodes_and_localization_are_active() -> None:
    found = {one.name for _, one in owned(NAVIGATE) if one.type == "lifecycle_msgs::srv::dds_::GetState_"}

    assert {"/wall_e/bt_navigator/get_state", "/wall_e/amcl/get_state"} == found


@pytest.mark.parametrize("topic", ["battery_state", "detections"])
def test_only_robots_with_a_battery_or_sensor_have_its_topic(topic: str) -> None:
    names = Names({"wall_e": [], "eve": []}, powered=frozenset({"eve"}), seeing=frozenset({"eve"}))

    assert [f"/eve/{topic}"] == [one.name for _, one in owned(names) if one.name.endswith(topic)]


def test_the_pose_is_latched_and_published_by_amcl() -> None:
    (found,) = [one for one in owned(NAVIGATE) if one.endpoint.name == "/wall_e/amcl_pose"]

    assert (Node("/wall_e", "amcl"), LATCHED_QOS) == (found.node, found.endpoint.qos)


def test_an_alias_of_an_action_has_all_its_endpoints(small: Names) -> None:
    found = [node for node, one in owned(small) if one.name == "/navigate_to_pose/wall_e/_action/send_goal"]

    assert [Node("/wall_e", "bt_navigator")] == found


def test_back_up_has_the_name_of_its_type_and_that_of_nav2(small: Names) -> None:
    found = {one.name for _, one in owned(small) if one.name.startswith("/eve/back") and one.name.endswith("status")}

    assert {"/eve/back_up/_action/status", "/eve/backup/_action/status"} == found


def test_an_action_has_its_own_names_before_aliases() -> None:
    """Aliases that are taken are left out."""
    aliases = {"retreat": "eve/back_up", "eve/wait": "eve/back_up", "eve/backup": "eve/back_up", "x": "eve/spin"}
    names = Names({"eve": ["back_up", "wait"]}, aliases)

    assert ("/eve/back_up", "/eve/backup", "/retreat") == names.called("eve", "back_up")
    assert () == names.called("eve", "spin")


def test_the_world_has_the_services_of_simulation_interfaces_only(small: Names) -> None:
    found = {one.name: one.type for node, one in owned(small) if node == Node("/", "hmrsim")}

    assert "simulation_interfaces::srv::dds_::SpawnEntity_" == found["/spawn_entity"]
    assert "rosgraph_msgs::msg::dds_::Clock_" == found["/clock"]
    assert "/inject_fault" not in found
    assert "/simulate_steps/_action/send_goal" in found


def test_endpoints_are_declared_in_the_order_of_need(small: Names) -> None:
    found = [(part.robot, bool(part.actions), bool(part.nodes), bool(part.topics)) for part in Parts(small).all]

    robots = ["wall_e", "eve", "cart"]
    expected = [
        ("_world", True, False, True),
        *((name, False, True, False) for name in robots),
        *((name, True, False, False) for name in robots),
        *((name, False, True, False) for name in robots),
        *((name, False, False, True) for name in robots),
    ]
    assert expected == found[: len(expected)]
    rest = [has_actions for _, has_actions, _, _ in found[len(expected) :]]
    assert rest == sorted(rest, reverse=True)


@pytest.mark.parametrize("robots", [10, 300, 1000, 5000])
def test_large_fleets_have_few_standing_tokens(robots: int) -> None:
    """A small fleet has all tokens; a new node sees a node of each robot of any fleet, in linear time."""
    fleet = Names({f"r{number}": ["navigate_to_pose", "spin", "wait", "follow_path"] for number in range(robots)})
    parts, endpoints = Parts(fleet), Endpoints(RmwZenoh(), actions(), services())
    standing = parts.all[: parts.standing(endpoints.tokens)]
    nodes = {node.full_name for part in standing for node in part.nodes}
    drives = {part.robot for part in standing if any(action == "navigate_to_pose" for _, action in part.actions)}

    assert (robots == 10) == (standing == parts.all)
    assert {f"/{robot}/bt_navigator" for robot in fleet.serves} <= nodes
    assert drives == (set(fleet.serves) if robots <= 300 else set())
    assert sum(map(endpoints.tokens, standing)) <= max(MAX_STANDING, robots + 50)


def test_each_endpoint_is_found_in_the_part_that_declares_it(small: Names) -> None:
    endpoints, parts = Endpoints(RmwZenoh(), actions(), services()), Parts(small)

    for part in parts.all:
        assert {part} == {parts.of(one.name) for _, one in endpoints.of(part)} | {part}
    assert parts.of("/wall_e/nothing") is None
    assert parts.of("/wall_e/nothing/_action/status") is None


def test_a_lost_robot_has_no_endpoints(small: Names) -> None:
    assert "eve" not in {part.robot for part in Parts(small, {"eve"}).all}


@given(
    st.from_regex(r"\A[A-Za-z][A-Za-z0-9_]{0,20}\Z"),
    st.sampled_from(sorted(name for name, action in actions().items() if not action.of_world)),
    st.integers(0, 232),
)
def test_an_independent_parser_reads_our_tokens(robot: str, action: str, domain: int) -> None:
    endpoints = Endpoints(RmwZenoh(domain), actions(), services())
    part = Part(robot, ((f"/{robot}/{action}", action),), ("odom", "amcl_pose"))

    for node, endpoint in endpoints.of(part):
        read = _parse_liveliness_keyexpr(endpoint_token(domain, "5e65be91", (3, 4), node, endpoint))
        assert read is not None
        told = (read["domain_id"], read["node_id"], read["entity_id"], read["kind"], read["qualified_name"])
        assert (domain, 3, 4, endpoint.kind.value, endpoint.name) == told
        assert (endpoint.type, endpoint.hash, endpoint.qos) == (read["dds_type"], read["type_hash"], read["qos"])
        assert (f"/{robot}", node.name) == (read["namespace"], read["node_name"].lstrip("/"))

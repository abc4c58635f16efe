"""The rights of roles on both wires."""

from __future__ import annotations

import pytest

from hmrsim.services import registry
from hmrsim_zenoh.security.roles import Rights
from hmrsim_zenoh.wire.access_control import AccessControl
from tests.cases import case
from tests.unit.hmrsim_zenoh.security.conftest import MEMBERS

POLICY = Rights("hmrsim", 0).access_control(MEMBERS)
HASH = "RIHS01_00"

READING = (
    "hmrsim/_world/info",
    "hmrsim/_world/scene",
    "hmrsim/_world/time/state",
    "hmrsim/_world/get_entities",
    "hmrsim/eve/odom",
    "hmrsim/*/odom",
    "hmrsim/*/_tree",
    "hmrsim/eve/wait/_action/status",
    "hmrsim/_world/info/@adv/**",
    f"0/get_entities/simulation_interfaces::srv::dds_::GetEntities_/{HASH}",
    f"0/eve/amcl/get_state/lifecycle_msgs::srv::dds_::GetState_/{HASH}",
    f"0/hmrsim/list_parameters/rcl_interfaces::srv::dds_::ListParameters_/{HASH}",
    f"0/eve/amcl/get_parameters/rcl_interfaces::srv::dds_::GetParameters_/{HASH}",
)
DRIVING_EVE = (
    "hmrsim/eve/wait/_action/send_goal",
    "hmrsim/eve/wait/_action/cancel_goal",
    "hmrsim/eve/wait/_action/get_result",
    "hmrsim/eve/wait/_action/execute",
    f"0/eve/wait/_action/send_goal/nav2_msgs::action::dds_::Wait_SendGoal_/{HASH}",
    f"0/eve/bt_navigator/change_state/lifecycle_msgs::srv::dds_::ChangeState_/{HASH}",
)
DRIVING_M_O = tuple(key.replace("/eve/", "/m_o/") for key in DRIVING_EVE)
IN_TIME = ("hmrsim/_world/time/join", "hmrsim/_world/time/leave")
BY_NAME = ("hmrsim/_world/time/advance/nurses", "hmrsim/_world/time/advance/fleet")
OF_WORLD = "hmrsim/_world/simulate_steps/_action/send_goal"
COMMANDS = (
    "hmrsim/_world/load_world",
    "hmrsim/_world/inject_fault",
    "hmrsim/_world/time/set",
    "hmrsim/_world/time/advance",
    OF_WORLD,
    f"0/set_entity_state/simulation_interfaces::srv::dds_::SetEntityState_/{HASH}",
    f"0/simulate_steps/_action/send_goal/simulation_interfaces::action::dds_::SimulateSteps_SendGoal_/{HASH}",
)
ELSEWHERE = ("other/eve/wait/_action/send_goal", f"1/eve/wait/_action/send_goal/T/{HASH}")
EVERY = (*READING, *DRIVING_EVE, *DRIVING_M_O, *IN_TIME, *BY_NAME, *COMMANDS, "hmrsim/_world/call_lift", *ELSEWHERE)


@pytest.mark.parametrize(
    ("name", "allowed"),
    [
        ("viewer", READING),
        ("nurses", (*READING, *DRIVING_EVE, *IN_TIME, BY_NAME[0], "hmrsim/_world/call_lift")),
        ("fleet", (*READING, *DRIVING_EVE, *DRIVING_M_O, *IN_TIME, BY_NAME[1])),
        ("operator", (*READING, *DRIVING_EVE, *DRIVING_M_O, *IN_TIME, *BY_NAME, *COMMANDS, "hmrsim/_world/call_lift")),
        ("mallory", ()),
    ],
)
def test_each_role_may_ask_what_it_needs_and_nothing_else(name, allowed):
    """Everything that is not allowed to a role is denied, for JSON and for ROS."""
    assert list(allowed) == [key for key in EVERY if POLICY.may_query(name, key).allowed]


def test_a_viewer_calls_no_service_that_changes_the_world():
    """Viewers may call exactly the services that only read."""
    for name, service in registry().items():
        with case(name):
            allowed = POLICY.may_query("viewer", f"hmrsim/_world/{name}").allowed

            assert allowed == name.startswith(("get_", "is_"))
            assert not (allowed and service.changes_world)


def test_only_the_simulator_publishes_poses():
    """No client can counterfeit a robot's odometry, or answer requests in the simulator's place."""
    for message, key in (("put", "hmrsim/eve/odom"), ("declare_queryable", "hmrsim/**"), ("put", "0/eve/odom/T/H")):
        with case(key):
            assert ["simulator"] == [
                name for name in POLICY.rules if POLICY.decide(name, message, "ingress", key).allowed
            ]


def test_a_viewer_writes_no_lines_into_the_log_of_ros():
    """Viewers declare no tokens of participants, unlike controllers."""
    log = "0/rosout/rcl_interfaces::msg::dds_::Log_/RIHS01_00"
    refused = [name for name in POLICY.rules if not POLICY.decide(name, "put", "ingress", log).allowed]

    assert ["viewer"] == refused


def test_a_controller_publishes_the_trees_of_its_own_robots():
    """A controller publishes only its own robots' trees."""
    may = [POLICY.decide("nurses", "put", "ingress", f"hmrsim/{robot}/_tree").allowed for robot in ("eve", "m_o")]

    assert [True, False] == may


def test_ros_nodes_publish_goals_of_their_own_robots_and_operators_move_all():
    def may(name):
        topics = ("eve/goal_pose", "m_o/cmd_vel", "eve/initialpose")
        keys = (f"0/{topic}/geometry_msgs::msg::dds_::PoseStamped_/{HASH}" for topic in topics)
        return [POLICY.decide(name, "put", "ingress", key).allowed for key in keys]

    assert [False, False, False] == may("viewer")
    assert [True, False, False] == may("nurses")
    assert [True, True, False] == may("fleet")
    assert [True, True, True] == may("operator")


def test_a_policy_is_the_same_after_it_was_written():
    """Zenoh's form contains the whole policy, so that explanations match the enforcement."""
    again = AccessControl.from_json(POLICY.to_json())

    for key in EVERY:
        assert [POLICY.may_query(name, key) for name in POLICY.rules] == [
            again.may_query(name, key) for name in POLICY.rules
        ]


def test_a_decision_names_its_rule():
    """A denial without a rule is explained as such."""
    assert "allowed by rule 'nurses drives wall_e, eve'" == str(POLICY.may_query("nurses", DRIVING_EVE[0]))
    assert "denied by rule 'only operators command the world'" == str(POLICY.may_query("fleet", OF_WORLD))
    assert "denied, as no rule allows it" == str(POLICY.may_query("viewer", COMMANDS[0]))

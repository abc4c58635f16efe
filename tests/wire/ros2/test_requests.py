"""Queries of ROS clients as commands, and answers as their replies, without a network."""

from __future__ import annotations

import itertools
import logging
import struct
from dataclasses import dataclass, field
from types import SimpleNamespace

import pytest
import zenoh

from hmrsim.actions import registry as all_actions
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.lifecycle_msgs import GetState
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.interfaces.simulation_interfaces import GetEntities, Result
from hmrsim.protocol.commands import CallService, CancelGoal, GetResult, SendGoal, StopWaiting
from hmrsim.protocol.goal import WORLD, CancelResponse, GoalEntry, GoalResponse, GoalStatus, Refused, ResultResponse
from hmrsim.services import registry as all_services
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import World
from hmrsim_zenoh.ros2.codec.types import DISTROS, action_type, service_type
from hmrsim_zenoh.ros2.names import Names
from hmrsim_zenoh.ros2.rejection_log import RejectionLog
from hmrsim_zenoh.ros2.requests import catalog as catalog_module
from hmrsim_zenoh.ros2.requests import requests as requests_module
from hmrsim_zenoh.ros2.requests.catalog import Catalog
from hmrsim_zenoh.ros2.requests.requests import PendingResults, Requests
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds

from tests.simulation import SMALL_WORLD  # isort: skip

ID = bytes(range(16))
GID = bytes(range(100, 116))
CDR = bytes((0, 1, 0, 0))
NAMES = Names({"wall_e": ["wait", "spin", "back_up", "navigate_to_pose"], WORLD: ["simulate_steps"]})
SECOND = 1_000_000_000


def wait_type(distro="jazzy", action="wait"):
    return action_type(all_actions()[action], distro)


@dataclass
class Query:
    """A query and its replies."""

    key_expr: str
    payload: zenoh.ZBytes | None
    attachment: zenoh.ZBytes | None
    replies: list = field(default_factory=list)
    drops: int = 0

    def reply(self, key, payload, *, attachment):
        assert not self.drops
        self.replies.append((key, payload, attachment))

    def drop(self):
        self.drops += 1


def key(verb, distro="jazzy", action="wait", robot="wall_e"):
    """Return the key of a service of an action."""
    type_ = getattr(wait_type(distro, action), verb)
    return f"0/{robot}/{action}/_action/{verb}/{type_.dds_name}/{type_.hash}"


def attached(gid):
    """Return the attachment of a client."""
    return struct.pack("<qqB16s", 7, 1, 16, gid)


def query(key_, payload=b"", attachment=None):
    """Return a query like those of rmw_zenoh."""
    signed = attached(GID) if attachment is None else attachment
    return Query(key_, zenoh.ZBytes(payload), zenoh.ZBytes(signed) if signed else None)


class DeclaredKeys(list):
    """The keys that are declared, in place of a publisher's."""

    declare = list.append

    def forget(self, is_unused):
        self[:] = [key_ for key_ in self if not is_unused(key_)]


class Desk:
    def __init__(self, wire=RmwZenoh(), names=NAMES):  # noqa: B008 - frozen
        self.waiting = PendingResults()
        self.wrong, self.rejected = [], []
        simulator = Simulator(World.model_validate(SMALL_WORLD))
        catalog = Catalog(names, wire.distros, actions=all_actions(), services=all_services(), simulator=simulator)
        self.catalog = catalog
        self.keys = DeclaredKeys()
        self.requests = Requests(
            wire,
            catalog,
            self.keys,
            waiting=self.waiting,
            rejections=RejectionLog(),
            peers=SimpleNamespace(
                name_of=lambda who: f"client {who[:4]}",
                wrong_hash=lambda address, who: self.wrong.append((address, who)),
            ),
            reject=lambda node, text: self.rejected.append((node.full_name, text)),
            max_payload=1000,
        )

    def one(self, query_):
        (command,) = self.requests.decode(query_)
        assert not query_.replies
        assert not query_.drops
        return command


def reply_of(query_, type_):
    """Return the decoded reply, and check that there is only one."""
    ((_, payload, _),) = query_.replies
    assert 1 == query_.drops
    return type_.response.decode(payload)


SEND = CDR + ID + struct.pack("<iI", 3, 500)


class TestGoals:
    def test_a_goal_is_decoded_with_its_id(self):
        command = Desk().one(query(key("send_goal"), SEND))

        goal = Wait.Goal(time=Duration(sec=3, nanosec=500))
        assert ("wall_e", "wait", goal, "000102030405060708090a0b0c0d0e0f") == command[:4]
        assert isinstance(command, SendGoal)

    def test_the_answer_has_the_stamp_and_the_attachment_of_the_request(self):
        asked = query(key("send_goal"), SEND)
        command = Desk().one(asked)
        command.reply_to.answer(GoalResponse(accepted=True, goal_id=ID.hex(), stamp=9 * SECOND + 10))

        ((key_, payload, attachment),) = asked.replies
        sequence, stamp, length, gid = struct.unpack("<qqB16s", attachment)
        assert bytes.fromhex("0001000001000000090000000a000000") == payload
        assert asked.key_expr == key_
        assert (7, 16, GID) == (sequence, length, gid)
        assert stamp > 1_700_000_000 * SECOND

    def test_each_distribution_is_answered_in_its_layout(self):
        """Jazzy's Spin goal lacks a field of kilted's."""
        jazzy, kilted = (
            Desk().one(query(key("send_goal", distro, "spin"), CDR + ID + tail))
            for distro, tail in (
                ("jazzy", struct.pack("<f4xI", 1.5, 0)[:4] + struct.pack("<iI", 10, 0)),
                ("kilted", struct.pack("<f", 1.5) + struct.pack("<iI", 10, 0) + b"\1"),
            )
        )

        assert (1.5, False) == (jazzy.goal.target_yaw, jazzy.goal.disable_collision_checks)
        assert (1.5, True) == (kilted.goal.target_yaw, kilted.goal.disable_collision_checks)

    def test_a_truncated_goal_is_not_accepted(self, caplog):
        """The missing field is logged once, however often the goal comes."""
        desk, asked = Desk(), [query(key("send_goal"), SEND[:-2]) for _ in range(3)]
        found = [desk.requests.decode(each) for each in asked]

        assert [[], [], []] == found
        assert {"accepted": False, "stamp": {"sec": 0, "nanosec": 1}} == reply_of(asked[2], wait_type().send_goal)
        (said,) = caplog.messages
        assert said.startswith("ROS 2: client 6465: /wall_e/wait/_action/send_goal: ")
        assert "goal.time.nanosec" in said

    def test_a_goal_with_nan_is_rejected_and_logged(self, caplog):
        type_ = wait_type(action="navigate_to_pose").send_goal
        pose = {"position": {"x": float("nan"), "y": 0.0, "z": 0.0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}
        header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "map"}
        goal = {"pose": {"header": header, "pose": pose}, "behavior_tree": ""}
        asked = query(
            key("send_goal", action="navigate_to_pose"), type_.request.encode({"goal_id": {"uuid": ID}, "goal": goal})
        )
        found = Desk().requests.decode(asked)

        assert [] == found
        assert not reply_of(asked, type_)["accepted"]
        assert caplog.messages[0].endswith("pose.pose.position.x: Input should be a finite number")

    @pytest.mark.parametrize("payload", [bytes(1001), b"\xff" * 300, b""])
    def test_malformed_goals_are_answered(self, payload, caplog):
        asked = query(key("send_goal"), payload)
        found = Desk().requests.decode(asked)

        assert [] == found
        assert not reply_of(asked, wait_type().send_goal)["accepted"]
        assert 1 == len(caplog.messages)

    def test_each_kind_of_error_of_a_client_is_logged(self, caplog):
        desk = Desk()
        for size in (1001, 1002, 1001):
            desk.requests.decode(query(key("send_goal"), bytes(size)))

        assert [f"payload of {size} bytes; 1 to 1000 are taken" for size in (1001, 1002)] == [
            message.split(": ")[3] for message in caplog.messages
        ]

    def test_a_goal_without_an_attachment_is_answered_with_zeros(self, caplog):
        asked = query(key("send_goal"), SEND, attachment=b"")
        command = Desk().one(asked)
        command.reply_to.answer(GoalResponse(accepted=True, goal_id=ID.hex(), stamp=1))

        sequence, _, length, gid = struct.unpack("<qqB16s", asked.replies[0][2])
        assert (0, 16, bytes(16)) == (sequence, length, gid)
        assert "has no attachment" in caplog.text

    def test_a_goal_with_a_malformed_attachment_is_answered_with_zeros(self, caplog):
        asked = query(key("send_goal"), SEND, attachment=b"rubbish")
        Desk().one(asked)

        assert "an attachment of 7 bytes; rmw_zenoh's has 33" in caplog.text


class TestOthersKeys:
    @pytest.mark.parametrize(
        "key_",
        [
            "0/r2d2/wait/_action/send_goal/nav2_msgs::action::dds_::Wait_SendGoal_/RIHS01_0",
            "0/wall_e/wait/_action/other/x/y",
            "0/wall_e/nothing/x/y",
            "0/*/wait/_action/send_goal/*/*",
            "0/x",
            "1/wall_e/wait/_action/send_goal/x/y",
        ],
    )
    def test_a_query_of_another_node_is_dropped_silently(self, key_):
        asked = query(key_, SEND)
        found = Desk().requests.decode(asked)

        assert ([], [], 1) == (found, asked.replies, asked.drops)

    def test_a_goal_with_a_wrong_hash_is_reported_and_rejected(self):
        """Without an answer the client would wait forever."""
        desk = Desk()
        asked = query(f"0/wall_e/wait/_action/send_goal/{wait_type().send_goal.dds_name}/RIHS01_0", SEND)
        found = desk.requests.decode(asked)

        ((address, who),) = desk.wrong
        assert [] == found
        assert ("/wall_e/wait/_action/send_goal", "RIHS01_0", GID.hex()) == (address.name, address.hash, who)
        assert not reply_of(asked, wait_type().send_goal)["accepted"]


class TestCancels:
    @pytest.mark.parametrize(
        ("goal_id", "stamp", "expected"),
        [
            (ID, (0, 0), (ID.hex(), 0)),
            (bytes(16), (2, 5), ("0" * 32, 2 * SECOND + 5)),
            (ID, (1, 0), (ID.hex(), SECOND)),
        ],
    )
    def test_a_cancel_has_the_id_and_stamp_of_the_request(self, goal_id, stamp, expected):
        command = Desk().one(query(key("cancel_goal"), CDR + goal_id + struct.pack("<iI", *stamp)))

        assert isinstance(command, CancelGoal)
        assert ("wall_e", "wait", *expected) == command[:4]

    def test_the_answer_lists_the_canceled_goals(self):
        asked = query(key("cancel_goal"), CDR + bytes(24))
        Desk().one(asked).reply_to.answer(CancelResponse(0, (GoalEntry(ID.hex(), SECOND, GoalStatus.CANCELING),)))

        reply = reply_of(asked, wait_type().cancel_goal)
        assert 0 == reply["return_code"]
        assert [(list(ID), 1)] == [(list(g["goal_id"]["uuid"]), g["stamp"]["sec"]) for g in reply["goals_canceling"]]

    def test_a_malformed_cancel_is_rejected_with_code_1(self):
        asked = query(key("cancel_goal"), CDR + bytes(5))
        Desk().requests.decode(asked)

        assert {"return_code": 1, "goals_canceling": []} == reply_of(asked, wait_type().cancel_goal)

    def test_a_cancel_for_an_unreachable_robot_is_rejected_with_code_1(self):
        asked = query(key("cancel_goal"), CDR + bytes(24))
        Desk().one(asked).reply_to.answer(Refused("robot", "wall_e", "no connection"))

        assert 1 == reply_of(asked, wait_type().cancel_goal)["return_code"]


class TestResults:
    def test_a_result_request_waits_for_its_answer(self):
        command = Desk().one(query(key("get_result"), CDR + ID))

        assert isinstance(command, GetResult)
        assert ("wall_e", "wait", ID.hex()) == command[:3]

    def test_the_answer_has_status_and_result(self):
        asked = query(key("get_result"), CDR + ID)
        result = Wait.Result(total_elapsed_time=Duration(sec=3))
        Desk().one(asked).reply_to.answer(ResultResponse(GoalStatus.SUCCEEDED, result))

        reply = reply_of(asked, wait_type().get_result)
        assert (4, 3) == (reply["status"], reply["result"]["total_elapsed_time"]["sec"])

    def test_a_malformed_result_request_gets_status_0(self):
        asked = query(key("get_result"), CDR + ID[:7])
        Desk().requests.decode(asked)

        assert 0 == reply_of(asked, wait_type().get_result)["status"]

    def test_an_answered_request_is_not_withdrawn(self):
        desk = Desk()
        command = desk.one(query(key("get_result"), CDR + ID))
        desk.waiting.answered(command.reply_to)

        assert [] == desk.waiting.gone(GID.hex())

    @pytest.mark.parametrize("bound", ["MAX_WAITING", "MAX_PER_CLIENT"])
    def test_the_oldest_request_makes_room_with_the_current_status(self, monkeypatch, bound):
        monkeypatch.setattr(requests_module, bound, 1)
        desk = Desk()
        first = desk.one(query(key("get_result"), CDR + ID))
        withdraw, second = desk.requests.decode(query(key("get_result"), CDR + ID))

        assert StopWaiting("wall_e", "wait", ID.hex(), (first.reply_to,), tell=True) == withdraw
        assert [second.reply_to] == [asked for each in desk.waiting.gone(GID.hex()) for asked in each.reply_tos]

    def test_the_client_with_most_requests_makes_room(self, monkeypatch):
        """A client with few requests keeps them."""
        monkeypatch.setattr(requests_module, "MAX_WAITING", 3)
        desk, other = Desk(), bytes(range(16, 32))
        modest = desk.one(query(key("get_result"), CDR + ID, attachment=struct.pack("<qqB16s", 1, 1, 16, other)))
        first = desk.one(query(key("get_result"), CDR + ID))
        desk.one(query(key("get_result"), CDR + ID))
        withdraw, _ = desk.requests.decode(query(key("get_result"), CDR + ID))

        assert (first.reply_to,) == withdraw.reply_tos
        assert [(modest.reply_to,)] == [each.reply_tos for each in desk.waiting.gone(other.hex())]


class TestServices:
    """Services of the world and of Nav2's nodes."""

    ENTITIES = all_services()["get_entities"]

    def _type(self):
        return service_type(self.ENTITIES.ros, "jazzy")

    def _query(self, payload):
        return query(f"0/get_entities/{self._type().dds_name}/{self._type().hash}", payload)

    def test_a_service_request_is_a_call(self):
        command = Desk().one(self._query(self._type().request.encode(GetEntities.Request())))

        assert isinstance(command, CallService)
        assert ("get_entities", GetEntities.Request()) == command[:2]

    def test_the_answer_is_the_response_of_the_service(self):
        asked = self._query(self._type().request.encode(GetEntities.Request()))
        Desk().one(asked).reply_to.answer(GetEntities.Response(result=Result(result=1), entities=["wall_e"]))

        assert ["wall_e"] == reply_of(asked, self._type())["entities"]

    @pytest.mark.parametrize("refuse", [True, False])
    def test_a_rejected_or_malformed_request_fails_with_a_reason(self, refuse):
        asked = self._query(self._type().request.encode(GetEntities.Request()) if refuse else b"\0\1\0\0\1")
        commands = Desk().requests.decode(asked)
        for command in commands:
            command.reply_to.answer(Refused("", None, "the simulation has ended"))

        result = reply_of(asked, self._type())["result"]
        assert Result.RESULT_OPERATION_FAILED == result["result"]
        assert ("the simulation has ended" if refuse else "filters") in result["error_message"]

    def test_services_of_our_own_types_are_not_served_to_ros(self):
        assert Desk().catalog.find("/inject_fault") is None

    @pytest.mark.parametrize(
        ("node", "there"),
        [("bt_navigator", True), ("amcl", True), ("behavior_server", True), ("move_group", False), ("nobody", False)],
    )
    def test_nodes_of_nav2_are_active(self, node, there):
        """Nav2's clients wait for state 3."""
        offer = Desk().catalog.find(f"/wall_e/{node}/get_state")

        assert there == (offer is not None)

    def test_the_state_has_number_and_label(self):
        desk = Desk()
        type_ = service_type(GetState, "jazzy")
        asked = query(f"0/wall_e/amcl/get_state/{type_.dds_name}/{type_.hash}", CDR + b"\0")
        found = desk.requests.decode(asked)

        assert [] == found
        assert {"current_state": {"id": 3, "label": "active"}} == reply_of(asked, type_)


class TestNames:
    def test_nav2s_backup_is_served_as_back_up(self):
        offer = Desk().catalog.find("/wall_e/backup/_action/send_goal")

        assert ("wall_e", "back_up") == (offer.robot, offer.action.name)

    def test_an_alias_of_the_world_file_is_served(self):
        names = Names({"wall_e": ["wait"]}, {"rest/wall_e": "wall_e/wait"})
        offer = Desk(names=names).catalog.find("/rest/wall_e/_action/get_result")

        assert ("wall_e", "wait") == (offer.robot, offer.action.name)

    @pytest.mark.parametrize(
        ("verb", "payload", "expected"),
        [
            ("send_goal", SEND, {"accepted": False, "stamp": {"sec": 0, "nanosec": 1}}),
            ("cancel_goal", CDR + bytes(24), {"return_code": 2, "goals_canceling": []}),
            ("get_result", CDR + ID, {"status": 0}),
            ("get_result", b"rubbish", {"status": 0}),
        ],
    )
    def test_requests_for_a_lost_robot_are_answered(self, verb, payload, expected, caplog):
        """Neither the robot nor its goals are known."""
        desk, asked = Desk(), query(key(verb), payload)
        desk.catalog.follow(Names({"eve": ["wait"]}))
        found = desk.requests.decode(asked)

        assert [] == found
        assert expected.items() <= reply_of(asked, getattr(wait_type(), verb)).items()
        assert caplog.messages[0].endswith(f"/wall_e/wait/_action/{verb}: no longer served: its robot is gone")

    def test_keys_are_declared_for_the_first_request_until_their_robot_is_lost(self):
        """Zenoh compares an undeclared key with all others."""
        desk = Desk(names=Names({"wall_e": ["wait"], "eve": ["wait"]}))
        lost = query(key("send_goal"), SEND)
        kept = f"0/eve/wait/_action/send_goal/{key('send_goal').partition('send_goal/')[2]}"
        for _ in range(2):
            desk.requests.decode(query(key("send_goal"), SEND))
            desk.requests.decode(query(kept, SEND))
        declared = list(desk.keys)
        desk.catalog.follow(Names({"eve": ["wait"]}))
        desk.requests.follow({"eve"})
        desk.requests.decode(lost)

        assert [key("send_goal"), kept] == declared
        assert [kept] == desk.keys
        assert not reply_of(lost, wait_type().send_goal)["accepted"]

    def test_the_log_of_the_asked_node_has_the_rejection(self):
        desk = Desk()
        type_ = service_type(GetState, "jazzy")
        for asked in (
            query(f"0/wall_e/amcl/get_state/{type_.dds_name}/{type_.hash}", b"x"),
            query(key("send_goal"), b"x"),
        ):
            desk.requests.decode(asked)

        assert ["/wall_e/amcl", "/wall_e/behavior_server"] == [node for node, _ in desk.rejected]

    def test_the_node_of_a_lost_robot_has_state_0(self):
        desk = Desk()
        type_ = service_type(GetState, "jazzy")
        asked = query(f"0/wall_e/amcl/get_state/{type_.dds_name}/{type_.hash}", CDR + b"\0")
        desk.catalog.follow(Names({"eve": ["wait"]}))
        desk.requests.decode(asked)

        assert 0 == reply_of(asked, type_)["current_state"]["id"]

    def test_a_robot_that_is_back_is_served_as_before(self):
        catalog = Desk().catalog
        catalog.follow(Names({"eve": ["wait"]}))
        lost = [catalog.find(f"/{robot}/wait/_action/send_goal").lost for robot in ("wall_e", "eve")]
        catalog.follow(NAMES)

        assert [True, False] == lost
        assert not catalog.find("/wall_e/wait/_action/send_goal").lost

    def test_the_oldest_lost_robots_are_forgotten(self, monkeypatch):
        monkeypatch.setattr(catalog_module, "_MAX_LOST", 1)
        catalog = Desk(names=Names({"a": ["wait"], "b": ["wait"]})).catalog
        catalog.follow(Names({"b": ["wait"]}))
        catalog.follow(Names({}))

        assert catalog.find("/a/wait/_action/send_goal") is None
        assert catalog.find("/b/wait/_action/send_goal").lost


class TestRos2Dds:
    """The wire of zenoh-bridge-ros2dds, whose keys are names."""

    def test_a_goal_needs_no_attachment(self):
        asked = query("wall_e/wait/_action/send_goal", SEND, attachment=b"")
        Desk(Ros2Dds()).one(asked).reply_to.answer(GoalResponse(accepted=True, goal_id=ID.hex(), stamp=1))

        assert [None] == [attachment for _, _, attachment in asked.replies]

    def test_an_attachment_is_returned_unchanged(self):
        asked = query("wall_e/wait/_action/send_goal", SEND, attachment=b"who knows")
        Desk(Ros2Dds()).one(asked).reply_to.answer(GoalResponse(accepted=True, goal_id=ID.hex(), stamp=1))

        assert [b"who knows"] == [attachment.to_bytes() for _, _, attachment in asked.replies]


class TestAnswers:
    def test_the_refusal_of_a_query_keeps_no_route(self):
        """Another thread refuses queries, while the routes of the simulation's thread change."""
        desk, asked = Desk(), query(key("send_goal"), SEND)
        desk.requests.refuse(asked, "too many pending requests")

        assert {"accepted": False, "stamp": {"sec": 0, "nanosec": 1}} == reply_of(asked, wait_type().send_goal)
        assert [] == desk.keys

    def test_a_query_is_dropped_when_its_session_is_closed(self):

        class Closed(Query):
            def reply(self, *_args, **_options):
                raise zenoh.ZError

        asked = Closed(key("get_result"), zenoh.ZBytes(CDR + ID), None)
        Desk().requests.refuse(asked, "the simulation has ended")

        assert 1 == asked.drops

    def test_an_answer_that_can_not_be_encoded_is_replaced_and_logged(self, caplog):
        asked = query(key("cancel_goal"), CDR + bytes(24))
        Desk().one(asked).reply_to.answer(CancelResponse(1000))

        assert 1 == reply_of(asked, wait_type().cancel_goal)["return_code"]
        assert logging.ERROR == caplog.records[-1].levelno

    def test_a_bug_while_decoding_is_answered(self, monkeypatch):
        asked = query(key("send_goal"), SEND)
        monkeypatch.setattr("hmrsim_zenoh.ros2.requests.handlers._goal_id", lambda _request: 1 / 0)
        found = Desk().requests.decode(asked)

        assert [] == found
        assert not reply_of(asked, wait_type().send_goal)["accepted"]

    def test_warnings_are_limited_per_minute(self, caplog):
        """A client that invents a thousand ids must not fill the disk."""
        now = [0.0]
        rejections = RejectionLog(clock=lambda: now[0])
        for number in range(1100):
            rejections.warn(f"rubbish of {number}")
        now[0] = 60.0
        rejections.warn("rubbish of 3")
        rejections.warn("somebody else's")

        assert "rubbish of 19" == caplog.messages[19]
        assert ["ROS 2: suppressed 1080 more warnings in a minute", "somebody else's"] == caplog.messages[20:]

    def test_a_warning_that_has_not_recurred_for_long_is_logged_again(self, caplog):
        minutes = itertools.count(step=60.0)
        rejections = RejectionLog(clock=lambda: next(minutes))
        for number in range(1000):
            rejections.warn(str(number))
        for text in ("0", "new", "0", "1"):
            rejections.warn(text)

        assert ["new", "1"] == caplog.messages[1000:]

    @pytest.mark.parametrize("distro", DISTROS)
    def test_every_service_of_every_action_has_a_rejection(self, distro):
        actions = {action.name for action in all_actions().values()}
        catalog = Desk(names=Names({"wall_e": sorted(actions)})).catalog
        offers = [
            catalog.find(f"/wall_e/{action}/_action/{verb}")
            for action in sorted(actions)
            for verb in ("send_goal", "cancel_goal", "get_result")
        ] + [offer for name in all_services() if (offer := catalog.find(f"/{name}"))]
        layouts = [offer.layouts.types[DISTROS.index(distro)] for offer in offers]
        replies = [layout.response.encode(offer.refusal("why")) for layout, offer in zip(layouts, offers, strict=True)]

        assert all(reply.startswith(CDR) for reply in replies)
        assert len(replies) > 3 * len(actions)

"""Scenario 1 by a third-party client of ROS 2's wire, ``zenoh-ros2-sdk`` as it comes: ``sdk_client.py PORT``.

The script needs a process, as the SDK has one session per process. It knows nothing of hmrsim: types are those
of definitions.msg. It writes a line of JSON about each thing that it did; `test_sdk` says what should be in it.
"""

from __future__ import annotations

import json
import struct
import sys
import time
import uuid
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import zenoh
from rosbags.interfaces import Nodetype
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber
from zenoh_ros2_sdk import ROS2ServiceClient, ROS2Subscriber, ZenohSession, get_service_names_and_types

PATIENCE = 300.0
NOBODY = bytes(16)
OURS = bytes(range(16))
"""The id that we ask under without the SDK's client."""
NAVIGATE = "/wall_e/navigate_to_pose"
DEFINITIONS = Path(__file__).with_name("definitions.msg")


def tell(what: str, **facts: Any) -> None:
    sys.stdout.write(json.dumps({"what": what, **facts}) + "\n")
    sys.stdout.flush()


def read_definitions() -> dict[str, tuple[str, str]]:
    """Return definition and hash of each type."""
    found = {}
    for part in DEFINITIONS.read_text().split("\n== ")[1:]:
        head, _, definition = part.partition("\n")
        name, _, hash_ = head.partition(" ")
        found[name] = (definition.strip(), hash_)
    return found


class Sdk:
    """The SDK, connected, with all types registered without a network."""

    def __init__(self, port: int) -> None:
        self.port = port
        self.session = ZenohSession.get_instance("127.0.0.1", port)
        self.definitions = read_definitions()
        for name, (definition, _) in self.definitions.items():
            if "---" not in definition:
                self.session.register_message_type(definition, name)

    def client(self, name: str, type_: str) -> ROS2ServiceClient:
        """Return the SDK's client of a service."""
        definition, hash_ = self.definitions[type_]
        request, _, response = definition.partition("---")
        return ROS2ServiceClient(
            name,
            type_,
            request_definition=request.strip(),
            response_definition=response.strip(),
            router_port=self.port,
            type_hash=hash_,
            timeout=PATIENCE,
        )

    def subscribe(self, topic: str, type_: str) -> SimpleQueue[Any]:
        """Return the list of messages that the SDK's subscriber receives from now on."""
        definition, hash_ = self.definitions[type_]
        heard: SimpleQueue[Any] = SimpleQueue()
        ROS2Subscriber(topic, type_, heard.put, msg_definition=definition, router_port=self.port, type_hash=hash_)
        return heard

    def zero(self, type_: str) -> Any:
        """Return a message of zeros, as the SDK's classes have no defaults."""
        _, fields = self.session.store.fielddefs[type_]
        return self.session.store.types[type_](**{name: self._zero(*described) for name, described in fields})

    def _zero(self, kind: Nodetype, details: Any) -> Any:
        if kind == Nodetype.NAME:
            return self.zero(details)
        if kind == Nodetype.BASE:
            return {"string": "", "bool": False}.get(details[0], 0)
        (of, what), size = details
        if of == Nodetype.BASE and what[0] != "string":
            return np.zeros(size if kind == Nodetype.ARRAY else 0, {"octet": "uint8"}.get(what[0], what[0]))
        return [self._zero(of, what) for _ in range(size if kind == Nodetype.ARRAY else 0)]

    def id(self, values: bytes) -> Any:
        message = self.zero("unique_identifier_msgs/msg/UUID")
        message.uuid = np.frombuffer(values, np.uint8)
        return message

    def ask(self, name: str, type_: str, payload: bytes) -> tuple[bytes, bytes]:
        """Send a query without the SDK's client, like rmw_zenoh; return reply and attachment."""
        package, kind, short = type_.split("/")
        (reply,) = self.session.session.get(
            f"0{name}/{package}::{kind}::dds_::{short}_/{self.definitions[type_][1]}",
            payload=bytes((0, 1, 0, 0)) + payload,
            attachment=struct.pack("<qqB16s", 7, time.time_ns(), 16, OURS),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=10 * PATIENCE,
        )
        return reply.ok.payload.to_bytes(), reply.ok.attachment.to_bytes()


class Action:
    """The three services of an action, by the SDK's clients."""

    def __init__(self, sdk: Sdk, name: str, type_: str) -> None:
        self._sdk, self._type = sdk, type_
        self._send_goal = sdk.client(f"{name}/_action/send_goal", f"{type_}_SendGoal")
        self._get_result = sdk.client(f"{name}/_action/get_result", f"{type_}_GetResult")
        self._cancel_goal = sdk.client(f"{name}/_action/cancel_goal", "action_msgs/srv/CancelGoal")

    def goal(self) -> Any:
        return self._sdk.zero(f"{self._type}_Goal")

    def send(self, goal: Any, goal_id: bytes | None = None) -> tuple[bytes, Any]:
        """Send a goal; return its id and the answer."""
        chosen = uuid.uuid4().bytes if goal_id is None else goal_id
        return chosen, self._send_goal.call(goal_id=self._sdk.id(chosen), goal=goal)

    def result(self, goal_id: bytes) -> Any:
        return self._get_result.call(goal_id=self._sdk.id(goal_id))

    def cancel(self, goal_id: bytes) -> tuple[int, list[bytes]]:
        info = self._sdk.zero("action_msgs/msg/GoalInfo")
        info.goal_id = self._sdk.id(goal_id)
        answer = self._cancel_goal.call(goal_info=info)
        return answer.return_code, [bytes(one.goal_id.uuid) for one in answer.goals_canceling]

    def do(self, what: str, goal: Any) -> bytes:
        """Send a goal and wait for its result; report both."""
        goal_id, answer = self.send(goal)
        stamp = answer.stamp.sec + answer.stamp.nanosec
        done = self.result(goal_id)
        code = getattr(done.result.error_code, "val", done.result.error_code)
        tell(what, accepted=answer.accepted, stamped=stamp > 0, status=done.status, error_code=code)
        return goal_id


def to(drive: Action, x: float, y: float) -> Any:
    goal = drive.goal()
    goal.pose.pose.position.x, goal.pose.pose.position.y = x, y
    goal.pose.pose.orientation.w = 1.0
    return goal


def follow_status(sdk: Sdk) -> SimpleQueue[tuple[bytes, int]]:
    """Return the list of statuses of navigate_to_pose, from a subscriber with rmw_zenoh's options."""
    heard: SimpleQueue[tuple[bytes, int]] = SimpleQueue()
    type_ = "action_msgs/msg/GoalStatusArray"
    key = f"0{NAVIGATE}/_action/status/action_msgs::msg::dds_::GoalStatusArray_/{sdk.definitions[type_][1]}"

    def take(sample: zenoh.Sample) -> None:
        message = sdk.session.store.deserialize_cdr(sample.payload.to_bytes(), type_)
        for one in message.status_list:
            heard.put((bytes(one.goal_info.goal_id.uuid), one.status))

    declare_advanced_subscriber(
        sdk.session.session,
        key,
        zenoh.handlers.Callback(take, indirect=False),
        history=HistoryConfig(detect_late_publishers=True, max_samples=1),
        recovery=RecoveryConfig(heartbeat=True),
        subscriber_detection=True,
    )
    return heard


def held_result(sdk: Sdk, goal_id: bytes) -> None:
    """Wait for a result without a timeout, unlike the SDK."""
    type_ = "nav2_msgs/action/NavigateToPose_GetResult"
    payload, attachment = sdk.ask(f"{NAVIGATE}/_action/get_result", type_, goal_id)
    sequence, _, _, gid = struct.unpack("<qqB16s", attachment)
    tell("a held result", status=payload[4], sequence=sequence, its_own=gid == OURS)


def discover(sdk: Sdk) -> None:
    """Wait until the SDK finds the services, and report those of navigate_to_pose."""
    wanted = {f"{NAVIGATE}/_action/{verb}" for verb in ("send_goal", "cancel_goal", "get_result")}
    until = time.monotonic() + PATIENCE
    found: dict[str, list[str]] = {}
    while time.monotonic() < until and not wanted <= found.keys():
        found = dict(get_service_names_and_types(0, router_port=sdk.port, include_hidden_services=True))
    tell("services", found=sorted((name, *found[name]) for name in wanted & found.keys()))


def refuse(drive: Action, used: bytes) -> None:
    """Send goals that are rejected."""
    _, answer = drive.send(to(drive, 512, 215), NOBODY)
    tell("a goal without an id", accepted=answer.accepted)
    _, answer = drive.send(to(drive, 512, 215), used)
    tell("a goal with the id of another", accepted=answer.accepted)


def cancel(sdk: Sdk, wait: Action, over: bytes, drive: Action) -> None:
    """Cancel a running, an ended and an unknown goal, and send a malformed cancel request."""
    goal = wait.goal()
    goal.time.sec = 100_000
    goal_id, _ = wait.send(goal)
    code, ended = wait.cancel(goal_id)
    tell("a cancel", code=code, its_own=ended == [goal_id], status=wait.result(goal_id).status)
    code, ended = drive.cancel(over)
    tell("a cancel of one that is over", code=code, goals=len(ended))
    code, ended = drive.cancel(uuid.uuid4().bytes)
    tell("a cancel of one that nobody knows", code=code, goals=len(ended))
    payload, _ = sdk.ask(f"{NAVIGATE}/_action/cancel_goal", "action_msgs/srv/CancelGoal", b"too little")
    tell("a cancel that can't be read", code=payload[4], goals=payload[8])


def scenario(sdk: Sdk) -> None:
    """Drive, grab, drive and drop, and everything that can fail."""
    discover(sdk)
    drive = Action(sdk, NAVIGATE, "nav2_msgs/action/NavigateToPose")
    wait = Action(sdk, "/wall_e/wait", "nav2_msgs/action/Wait")
    grab = Action(sdk, "/wall_e/grab", "moveit_msgs/action/Pickup")
    drop = Action(sdk, "/wall_e/drop", "moveit_msgs/action/Place")
    heard = sdk.subscribe(f"{NAVIGATE}/_action/feedback", "nav2_msgs/action/NavigateToPose_FeedbackMessage")
    battery = sdk.subscribe("/wall_e/battery_state", "sensor_msgs/msg/BatteryState")
    status = follow_status(sdk)

    pickup, place = grab.goal(), drop.goal()
    pickup.target_name, place.attached_object_name = "medicine", "medicine"
    first = drive.do("to the medicine", to(drive, 512, 215))
    tell("feedback", distances=falling(heard, first))
    tell("status", of_the_drive=until_succeeded(status, first))
    grab.do("grab", pickup)
    second = drive.do("to the patient", to(drive, 100, 180))
    falling(heard, second)
    drop.do("drop", place)
    level = battery.get(timeout=PATIENCE)
    tell("battery", percentage=round(level.percentage, 2), present=level.present, whose=level.serial_number)

    refuse(drive, first)
    cancel(sdk, wait, first, drive)
    drive.do("to nowhere", to(drive, 5, 5))
    drop.do("drop nothing", place)
    tell("no such goal", status=drive.result(uuid.uuid4().bytes).status)
    goal_id, _ = drive.send(to(drive, 512, 215))
    held_result(sdk, goal_id)


def falling(heard: SimpleQueue[Any], goal_id: bytes) -> list[float]:
    """Return the distances of a goal's feedback, down to zero."""
    distances = [1.0]
    while distances[-1]:
        message = heard.get(timeout=PATIENCE)
        if bytes(message.goal_id.uuid) == goal_id:
            distances.append(round(float(message.feedback.distance_remaining), 3))
    return distances[1:]


def until_succeeded(status: SimpleQueue[tuple[bytes, int]], goal_id: bytes) -> list[int]:
    """Return the statuses of a goal up to its success, each once."""
    found: list[int] = []
    while 4 not in found:
        whose, code = status.get(timeout=PATIENCE)
        if whose == goal_id and code not in found:
            found.append(code)
    return found


if __name__ == "__main__":
    outside = Sdk(int(sys.argv[1]))
    try:
        scenario(outside)
    finally:
        outside.session.close()

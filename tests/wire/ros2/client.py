"""A ROS 2 client as rmw_zenoh makes one, built on Zenoh alone: its keys, tokens and ids are independent."""

from __future__ import annotations

import itertools
import json
import struct
import threading
import time
import uuid
from concurrent.futures import Future
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import xxhash
import zenoh
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber

from hmrsim.actions import registry
from hmrsim.interfaces.lifecycle_msgs import GetState
from hmrsim_zenoh.ros2.codec.types import ActionType, MessageType, ServiceType, action_type, service_type
from tests.patience import PATIENCE
from tests.wire.ros2.graph import Graph

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.interfaces.message import Message

NO_ID = bytes(16)
CDR = bytes((0, 1, 0, 0))
SERVICE_QOS = "::,10:,:,:,,"
LATCHED_QOS = ":1:,1:,:,:,,"

UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(7)
"""The states of a goal."""

SESSION = MappingProxyType(
    {
        "mode": "peer",
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 1000, "period_max_ms": 4000, "period_increase_factor": 2},
        "listen/endpoints": ["tcp/127.0.0.1:0"],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": True,
        "scouting/gossip/target": {"router": ["router", "peer"], "peer": ["router"]},
        "timestamping/enabled": True,
        "queries_default_timeout": 600_000,
        "transport/shared_memory/enabled": False,
    }
)
"""What rmw_zenoh's default configuration of a session says, where that is not Zenoh's own default."""


class Unanswered(Exception):
    """A request without an answer, whose future in rclpy would never complete."""


# As in hmrsim_zenoh.wire.session: garbage collection in a callback would wait for Zenoh's thread with the GIL held.
_never_deallocated: list[zenoh.Session] = []


def open_session(endpoint: str, **settings: Any) -> zenoh.Session:
    """Return a session as a ROS node opens it; *settings* are more of its configuration, with ``__`` for ``/``."""
    config = zenoh.Config()
    more = {key.replace("__", "/"): value for key, value in settings.items()}
    for key, value in {**SESSION, "connect/endpoints": [endpoint], **more}.items():
        config.insert_json5(key, json.dumps(value))
    session = zenoh.open(config)
    _never_deallocated.append(session)
    return session


def ros_action(action: str, distro: str = "jazzy") -> ActionType:
    """Return an action's type by our name of the action, such as ``pickup``."""
    return action_type(registry()[action], distro)


def get_state(distro: str = "jazzy") -> ServiceType:
    """Return the type of the service for a lifecycle node's state."""
    return service_type(GetState, distro)


def attachment(sequence: int, gid: bytes) -> bytes:
    """Return the attachment of a request."""
    return struct.pack("<qqB16s", sequence, time.time_ns(), 16, gid)


def goal_to(x: float, y: float) -> dict[str, Any]:
    """Return the plain values of a goal to drive to a point, whole."""
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "map"}
    pose = {"position": {"x": x, "y": y, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {"pose": {"header": header, "pose": pose}, "behavior_tree": ""}


@dataclass(frozen=True)
class Got:
    """One message of a topic.

    Attributes:
        message: Its plain values.
        sequence: Its number; from 1 for each publisher.
        gid: Its publisher's id.
        key: The key that it was sent on.
    """

    message: dict[str, Any]
    sequence: int
    gid: bytes
    key: str


class Inbox:
    """Messages of a topic, in the order in which they came."""

    def __init__(self, type_: MessageType) -> None:
        self._type = type_
        self._changed = threading.Condition()
        self.items: list[Got] = []
        self.errors: list[Exception] = []
        """What was sent and could not be read."""

    def take(self, sample: zenoh.Sample) -> None:
        """Store a message; rmw_zenoh ignores one without an attachment, too."""
        with self._changed:
            try:
                assert sample.attachment is not None
                sequence, _, length, gid = struct.unpack("<qqB16s", sample.attachment.to_bytes())
                assert length == 16
                self.items.append(
                    Got(self._type.decode(sample.payload.to_bytes()), sequence, gid, str(sample.key_expr))
                )
            except Exception as error:  # noqa: BLE001 - a callback of Zenoh's
                self.errors.append(error)
            self._changed.notify_all()

    @property
    def messages(self) -> list[dict[str, Any]]:
        with self._changed:
            return [got.message for got in self.items]

    def wait(self, until: Callable[[list[dict[str, Any]]], Any]) -> list[dict[str, Any]]:
        """Return all messages, once *until* holds for them."""
        with self._changed:
            assert self._changed.wait_for(
                lambda: self.errors or until([got.message for got in self.items]), PATIENCE
            ), self.items[-5:]
            assert not self.errors, self.errors
            return [got.message for got in self.items]

    def next(self) -> dict[str, Any]:
        """Return the first message, once there is one."""
        return self.wait(len)[0]


def statuses(message: dict[str, Any]) -> dict[bytes, int]:
    """Return the status of each goal in a GoalStatusArray."""
    return {bytes(one["goal_info"]["goal_id"]["uuid"]): one["status"] for one in message["status_list"]}


class RosClient:
    """A ROS node, with a session.

    Args:
        endpoint: Where the router is.
        distro: Whose types it has.
        domain: Its ROS domain.
        node: Its name.
        settings: More of its session's configuration, with ``__`` for ``/``.
    """

    def __init__(
        self, endpoint: str, distro: str = "jazzy", *, domain: int = 0, node: str = "tester", **settings: Any
    ) -> None:
        self.distro, self.domain, self.node = distro, domain, node
        self.session = open_session(endpoint, **settings)
        self.zid = str(self.session.info.zid())
        self._ids = itertools.count(1)
        self._declared: list[Any] = []
        self._token(f"@ros2_lv/{domain}/{self.zid}/0/0/NN/%/%/{node}")
        self.graph = Graph(self.session, domain)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    def close(self) -> None:
        self.session.close()

    def key(self, name: str, type_: str, hash_: str) -> str:
        """Return the key of a topic or a service."""
        return f"{self.domain}/{name.strip('/')}/{type_}/{hash_}"

    def declare(self, kind: str, name: str, type_: str, hash_: str, qos: str = SERVICE_QOS) -> bytes:
        """Declare the token of an endpoint, and return the endpoint's id."""
        head = f"@ros2_lv/{self.domain}/{self.zid}/0/{next(self._ids)}/{kind}/%/%/{self.node}"
        return self._token(f"{head}/{name.replace('/', '%')}/{type_}/{hash_}/{qos}")

    def _token(self, token: str) -> bytes:
        self._declared.append(self.session.liveliness().declare_token(token))
        digest = xxhash.xxh3_128_intdigest(token.encode())
        return digest.to_bytes(16, "little")

    def service(self, name: str, type_: ServiceType) -> ServiceClient:
        """Return a client of a service, such as ``/wall_e/amcl/get_state``."""
        return ServiceClient(self, name, type_)

    def subscribe(self, name: str, type_: MessageType, *, latched: bool = False) -> Inbox:
        """Return the messages of a topic from now on, with the last one first if it is latched (transient local)."""
        self.declare("MS", name, type_.dds_name, type_.hash, LATCHED_QOS if latched else SERVICE_QOS)
        inbox = Inbox(type_)
        history = HistoryConfig(detect_late_publishers=True, max_samples=1) if latched else None
        self._declared.append(
            declare_advanced_subscriber(
                self.session,
                self.key(name, type_.dds_name, type_.hash),
                zenoh.handlers.Callback(inbox.take, indirect=False),
                history=history,
                subscriber_detection=latched,
                recovery=RecoveryConfig(heartbeat=True) if latched else None,
            )
        )
        return inbox

    def action(self, name: str, action: str | None = None) -> ActionClient:
        """Return a client of an action by its name, such as ``/wall_e/pickup``.

        Args:
            name: ROS's name of it.
            action: Our name of the action, where that isn't the last part of *name*.
        """
        ours = action or name.rpartition("/")[2]
        return ActionClient(self, name, ros_action(ours, self.distro), registry()[ours].goal)


@dataclass
class _Pending:
    """A request that waits for its reply."""

    type: MessageType
    sequence: int
    gid: bytes
    future: Future[dict[str, Any]] = field(default_factory=Future)
    replies: int = 0

    def take(self, reply: zenoh.Reply) -> None:
        """Store a reply; a second one, an error, or a reply to another client is a bug of the server."""
        self.replies += 1
        try:
            assert reply.ok is not None, f"an error: {reply.err.payload.to_bytes() if reply.err else None!r}"
            assert self.replies == 1, "a second reply"
            assert reply.ok.attachment is not None, "a reply without an attachment"
            sequence, stamp, length, gid = struct.unpack("<qqB16s", reply.ok.attachment.to_bytes())
            assert (self.sequence, 16, self.gid) == (sequence, length, gid)
            assert stamp > 0
            payload = reply.ok.payload.to_bytes()
            assert payload[:4] == CDR
            self.future.set_result(self.type.decode(payload))
        except Exception as error:  # noqa: BLE001 - raised where the test waits
            if not self.future.done():
                self.future.set_exception(error)

    def end(self) -> None:
        if not self.future.done():
            self.future.set_exception(Unanswered(self.type.name))


class ServiceClient:
    """A client of a service, with its token and id."""

    def __init__(self, client: RosClient, name: str, type_: ServiceType) -> None:
        self._session = client.session
        self._graph = client.graph
        self.name, self.type = name, type_
        self.key = client.key(name, type_.dds_name, type_.hash)
        self.gid = client.declare("SC", name, type_.dds_name, type_.hash)
        self._sequence = itertools.count(1)

    def wait(self) -> Self:
        """Wait for the service, as rclpy's wait_for_service does."""
        self._graph.wait_for(("SS", self.name, self.type.dds_name))
        return self

    def begin(self, request: dict[str, Any] | bytes) -> Future[dict[str, Any]]:
        """Send a request, given as plain values or as bytes, and don't wait."""
        payload = request if isinstance(request, bytes) else self.type.request.encode(request)
        pending = _Pending(self.type.response, next(self._sequence), self.gid)
        self._session.get(
            self.key,
            zenoh.handlers.Callback(pending.take, pending.end, indirect=False),
            payload=payload,
            attachment=attachment(pending.sequence, self.gid),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            # rmw_zenoh waits for results as long as it lives.
            timeout=PATIENCE,
        )
        return pending.future

    def call(self, request: dict[str, Any] | bytes) -> dict[str, Any]:
        """Send a request and return the reply."""
        return self.begin(request).result(PATIENCE)


@dataclass(frozen=True)
class RosGoal:
    """A goal that was sent."""

    client: ActionClient
    id: bytes
    accepted: bool
    stamp: tuple[int, int]

    def result(self) -> tuple[int, dict[str, Any]]:
        """Wait for the end; return status and result."""
        answer = self.begin_result().result(PATIENCE)
        return answer["status"], answer["result"]

    def begin_result(self) -> Future[dict[str, Any]]:
        """Request the result, and don't wait."""
        return self.client.get_result.begin(CDR + self.id)

    def cancel(self) -> tuple[int, list[bytes]]:
        """Cancel the goal; return the code and the goals that end."""
        return self.client.cancel(self.id)


class ActionClient:
    """A client of an action: three services and two subscriptions."""

    def __init__(self, client: RosClient, name: str, type_: ActionType, goal: type[Message]) -> None:
        self.name, self.type = name, type_
        self._graph, self._goal, self._session = client.graph, goal, client.session
        self.send_goal = client.service(f"{name}/_action/send_goal", type_.send_goal)
        self.cancel_goal = client.service(f"{name}/_action/cancel_goal", type_.cancel_goal)
        self.get_result = client.service(f"{name}/_action/get_result", type_.get_result)
        self.feedback = client.subscribe(f"{name}/_action/feedback", type_.feedback)
        self.status = client.subscribe(f"{name}/_action/status", type_.status, latched=True)

    def wait(self) -> Self:
        """Wait for the server, as rcl does: three services and two publishers, by name and type only."""
        services = (self.send_goal, self.cancel_goal, self.get_result)
        topics = (("feedback", self.type.feedback), ("status", self.type.status))
        self._graph.wait_for(
            *(("SS", each.name, each.type.dds_name) for each in services),
            *(("MP", f"{self.name}/_action/{topic}", type_.dds_name) for topic, type_ in topics),
        )
        # The simulator is the router: when it answers, it knows of the subscriptions that were declared before.
        list(self._session.liveliness().get("@ros2_lv/of/nothing"))
        return self

    def send(self, goal: dict[str, Any], goal_id: bytes | None = None) -> RosGoal:
        """Send a goal; fields that *goal* omits have the defaults of our models."""
        chosen = uuid.uuid4().bytes if goal_id is None else goal_id
        whole = self._goal.model_validate_json(json.dumps(goal))
        answer = self.send_goal.call({"goal_id": {"uuid": list(chosen)}, "goal": whole})
        return RosGoal(self, chosen, answer["accepted"], (answer["stamp"]["sec"], answer["stamp"]["nanosec"]))

    def do(self, goal: dict[str, Any]) -> tuple[int, dict[str, Any]]:
        """Send a goal that is accepted, and return status and result."""
        sent = self.send(goal)
        assert sent.accepted
        return sent.result()

    def cancel(self, goal_id: bytes = NO_ID, stamp: tuple[int, int] = (0, 0)) -> tuple[int, list[bytes]]:
        """Cancel a goal, all up to a time, or all; return the code and the goals that end."""
        answer = self.cancel_goal.call(CDR + goal_id + struct.pack("<iI", *stamp))
        return answer["return_code"], [bytes(one["goal_id"]["uuid"]) for one in answer["goals_canceling"]]

    def wait_for_status(self, goal_id: bytes, status: int) -> None:
        """Wait until a goal has had a status."""
        self.status.wait(lambda messages: any(statuses(one).get(goal_id) == status for one in messages))

    def feedback_of(self, goal_id: bytes) -> list[dict[str, Any]]:
        """Return the feedback that has come of a goal."""
        found = (one for one in self.feedback.messages if bytes(one["goal_id"]["uuid"]) == goal_id)
        return [one["feedback"] for one in found]

    def wait_for_last_feedback(self, goal_id: bytes, field: str = "distance_remaining") -> dict[str, Any]:
        """Return the feedback of a robot that has arrived, whose *field* is zero."""

        def last(message: dict[str, Any]) -> bool:
            mine = bytes(message["goal_id"]["uuid"]) == goal_id
            return mine and message["feedback"][field] == 0

        self.feedback.wait(lambda messages: any(map(last, messages)))
        return self.feedback_of(goal_id)[-1]

    def wait_for_feedback(self, goal_id: bytes) -> dict[str, Any]:
        """Return the first feedback of a goal, once there is one."""
        self.feedback.wait(lambda messages: any(bytes(one["goal_id"]["uuid"]) == goal_id for one in messages))
        return self.feedback_of(goal_id)[0]

"""A ROS 2 client on rmw_zenoh's wire that costs as little as Python allows."""

from __future__ import annotations

import itertools
import json
import threading
import time
import uuid
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import zenoh

from benchmarks._processes import PATIENCE
from benchmarks._wire import answer
from hmrsim.actions import registry
from hmrsim.interfaces.action_msgs import CancelGoal
from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.codec.types import ActionType, MessageType, ServiceType, action_type
from hmrsim_zenoh.ros2.keys import Endpoint, Kind, Node
from hmrsim_zenoh.ros2.wires import Attachment

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

HEADER = bytes((0, 1, 0, 0))
_SUCCEEDED, _CANCELED = 4, 5
_IGNORE: Final[zenoh.handlers.Callback[Any]] = zenoh.handlers.Callback(lambda _: None, indirect=False)
_ACCEPTED = 1


def open_session(endpoint: str) -> zenoh.Session:
    """Return a session as rmw_zenoh opens it, but with quick retries while there is no router yet."""
    config = zenoh.Config()
    for key, value in {
        "mode": "peer",
        "connect/endpoints": [endpoint],
        "connect/timeout_ms": round(PATIENCE * 1e3),
        "connect/retry": {"period_init_ms": 10, "period_max_ms": 20, "period_increase_factor": 1.0},
        "listen/endpoints": ["tcp/127.0.0.1:0"],
        "scouting/multicast/enabled": False,
        "timestamping/enabled": True,
        "transport/shared_memory/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def type_of(action: str, distro: str = "jazzy") -> ActionType:
    """Return an action's type by its name."""
    return action_type(registry()[action], distro)


_KIND_CHUNK, _NAME_CHUNK = 5, 9
_ROLES: Final = (("SS", "send_goal"), ("SS", "cancel_goal"), ("SS", "get_result"), ("MP", "feedback"), ("MP", "status"))


class ServiceClient:
    """A client of one of an action's services, with its token and id."""

    def __init__(self, session: zenoh.Session, name: str, type_: ServiceType, number: int) -> None:
        self._session = session
        self._key = keys.key(0, name, type_.dds_name, type_.hash)
        self._token, token = _declare(session, Endpoint(Kind.CLIENT, name, type_.dds_name, type_.hash), number)
        self._gid = keys.gid(token)
        self._sequence = itertools.count(1)

    def ask(self, payload: bytes) -> bytes:
        """Send a request and return the reply."""
        return answer(self.send(payload), self._key)

    def send(self, payload: bytes, take: zenoh.handlers.Callback[zenoh.Reply] | None = None) -> Any:
        """Send a request; *take* is called with the reply, or a channel of replies is returned."""
        return self._session.get(
            self._key,
            take,
            payload=payload,
            attachment=Attachment(next(self._sequence), time.time_ns(), self._gid).to_bytes(),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=PATIENCE,
        )


def _subscribed(session: zenoh.Session, name: str, type_: MessageType, number: int) -> list[object]:
    """Subscribe to a topic and ignore its messages; return what keeps the subscription."""
    endpoint = Endpoint(Kind.SUBSCRIBER, name, type_.dds_name, type_.hash)
    key = keys.key(0, name, type_.dds_name, type_.hash)
    return [session.declare_subscriber(key, _IGNORE), _declare(session, endpoint, number)[0]]


def _declare(session: zenoh.Session, endpoint: Endpoint, number: int) -> tuple[zenoh.LivelinessToken, str]:
    token = keys.endpoint_token(0, str(session.info.zid()), (0, number), Node("/", "benchmark"), endpoint)
    return session.liveliness().declare_token(token), token


class RosGoalSender:
    """Sends goals of one robot's action, each the action's default goal.

    Args:
        session: An open session.
        robot: Whose.
        action: Which.
        first: The number of the client's first entity; it has five in the session.
        goal: Which goal; that with all defaults if None.
    """

    def __init__(
        self, session: zenoh.Session, robot: str, action: str, first: int = 1, goal: Message | None = None
    ) -> None:
        self._session = session
        self._type = type_ = type_of(action)
        self._name = name = f"/{robot}/{action}/_action"
        self._first = first
        self._send_goal = ServiceClient(session, f"{name}/send_goal", type_.send_goal, first)
        self._get_result = ServiceClient(session, f"{name}/get_result", type_.get_result, first + 1)
        self._cancel_goal = ServiceClient(session, f"{name}/cancel_goal", type_.cancel_goal, first + 2)
        unknown = {"goal_id": {"uuid": bytes(16)}, "goal": goal or registry()[action].goal()}
        self._goal = type_.send_goal.request.encode(unknown)[len(HEADER) + 16 :]
        self._no_time = type_.cancel_goal.request.encode(CancelGoal.Request())[len(HEADER) + 16 :]
        self._id = b""
        self._subscriptions: list[object] = []

    def subscribe(self) -> None:
        """Subscribe to feedback and status, as an action client of ROS does."""
        for number, (topic, type_) in enumerate((("feedback", self._type.feedback), ("status", self._type.status)), 3):
            self._subscriptions += _subscribed(self._session, f"{self._name}/{topic}", type_, self._first + number)

    def right_behind(self, take: Callable[[zenoh.Reply], None]) -> None:
        """Send a goal and ask for its result at once; *take* is called with the result's reply."""
        self._id = uuid.uuid4().bytes
        self._send_goal.send(HEADER + self._id + self._goal, _IGNORE)
        self._get_result.send(HEADER + self._id, zenoh.handlers.Callback(take, indirect=False))

    def one_by_one(self) -> None:
        """Send a goal; when it is accepted, ask for the result, and return with it."""
        self._accepted()
        self._ended(_SUCCEEDED)

    def canceled(self) -> None:
        """Send a goal; when it is accepted, cancel it, and return with its result."""
        self._accepted()
        self._cancel_goal.ask(HEADER + self._id + self._no_time)
        self._ended(_CANCELED)

    def _accepted(self) -> None:
        self._id = uuid.uuid4().bytes
        if self._send_goal.ask(HEADER + self._id + self._goal)[len(HEADER)] != _ACCEPTED:
            raise RuntimeError("a goal was rejected")

    def _ended(self, status: int) -> None:
        if self._get_result.ask(HEADER + self._id)[len(HEADER)] != status:
            raise RuntimeError(f"a goal has not ended with status {status}")


class Graph:
    """The services and publishers that a ROS node knows of, and when it learned of the last."""

    def __init__(self, session: zenoh.Session) -> None:
        self._seen: set[tuple[str, str]] = set()
        self._missing: set[tuple[str, str]] = set()
        self._complete_at = 0.0
        self._changed = threading.Condition()
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(self._take, indirect=False)
        self._subscriber = session.liveliness().declare_subscriber(keys.all_tokens(0), handler, history=True)

    def _take(self, sample: zenoh.Sample) -> None:
        chunks = str(sample.key_expr).split("/")
        if len(chunks) <= _NAME_CHUNK:
            return
        endpoint = (chunks[_KIND_CHUNK], chunks[_NAME_CHUNK])
        with self._changed:
            self._seen.add(endpoint)
            self._missing.discard(endpoint)
            if not self._missing:
                self._complete_at = time.perf_counter()
                self._changed.notify_all()

    def when(self, servers: list[str]) -> float:
        """Wait until all these actions can be used, and return since when."""
        wanted = {(kind, f"{name.replace('/', '%')}%_action%{role}") for name in servers for kind, role in _ROLES}
        with self._changed:
            self._missing = wanted - self._seen
            self._complete_at = time.perf_counter()
            if not self._changed.wait_for(lambda: not self._missing, PATIENCE):
                raise RuntimeError(f"{len(self._missing)} endpoints are not there")
            return self._complete_at

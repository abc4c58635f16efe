"""The listener, which records a running simulator over the network."""

from __future__ import annotations

import logging
import struct
from collections.abc import Mapping
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import zenoh
from pydantic_core import from_json

from hmrsim import events
from hmrsim.actions import registry as actions
from hmrsim.events.simulation import SimulatorReturned
from hmrsim.interfaces.builtin_interfaces import Time, values_of
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.vision_msgs import Detection3DArray
from hmrsim.protocol.goal import WORLD, GoalEntry, GoalStatus
from hmrsim.protocol.outputs import FeedbackSent, Sampled, StatusChanged
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.recording.recorder import nanoseconds_of
from hmrsim_zenoh.wire.envelopes import dump
from hmrsim_zenoh.wire.keys import TREE, ActionKey, Keys, TopicKey, Verb

if TYPE_CHECKING:
    from typing import Self

    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.connection import Reply
    from hmrsim_zenoh.recording.recorder import Recorder

_log = logging.getLogger(__name__)

_MAX_WAITING: Final = 100_000
"""The maximum number of samples in the queue; further samples are lost."""
_FEW_WAITING: Final = _MAX_WAITING // 10
"""The length of the queue below which the state is queried again after a loss."""

_PATIENCE: Final = 10.0
"""Wall seconds for an answer."""

_INFO, _DEFINITION, _SCENE = "info", "get_current_world", "scene"

_MESSAGES: Final[Mapping[str, tuple[Topic, type[Message]]]] = {
    "odom": (Topic.ODOM, Odometry),
    "battery_state": (Topic.BATTERY_STATE, BatteryState),
    "detections": (Topic.DETECTIONS, Detection3DArray),
}

_UNREADABLE: Final = (
    ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError, struct.error
)  # fmt: skip
"""The exceptions that an invalid sample raises. An error of the file is an `HmrsimError` instead."""


class _Answered(NamedTuple):
    """The answer to a query for the state of the world."""

    topic: str
    answer: Reply


class Listener:
    """Subscribes to all topics of a simulator, queues the samples, and records them in `work`.

    Samples and answers to queries share one queue, so that they are recorded in the order in which they arrive.

    Attributes:
        lost: The number of samples that were lost because the queue was full.
        begun: Whether the initial state has arrived; nothing is recorded before.
        interrupted: Whether the simulator was gone, if only for a moment, since the last query.
    """

    def __init__(self, client: Client, recorder: Recorder) -> None:
        self._client = client
        self._keys = client.keys
        self._recorder = recorder
        self._waiting: SimpleQueue[tuple[str, bytes] | _Answered] = SimpleQueue()
        self._answers: dict[str, dict[str, Any]] = {}
        self._querying = False
        self._warned = self._missed = False
        self.lost = 0
        self.begun = False
        self.interrupted = False
        handler = zenoh.handlers.Callback(self._on_sample, indirect=False)
        self._subscriber = client.session.declare_subscriber(self._keys.everything(), handler)
        presence = zenoh.handlers.Callback(self._on_presence, indirect=False)
        self._presence = client.session.liveliness().declare_subscriber(self._keys.alive(), presence)
        self._query()

    def __enter__(self) -> Self:
        """Return the listener."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Unsubscribe from the simulator."""
        self._subscriber.undeclare()
        self._presence.undeclare()

    def work(self, timeout: float) -> None:
        """Record the next sample or answer of the queue; wait up to *timeout* wall seconds for it.

        Raises:
            queue.Empty: Nothing has arrived.
            HmrsimError: The file can't be written.
        """
        item = self._waiting.get(timeout=timeout)
        try:
            if isinstance(item, _Answered):
                self._on_answer(item)
            elif self.begun:
                self._record(*item)
        except _UNREADABLE as error:
            if not self._warned:
                self._warned = True
                _log.warning("invalid messages are not recorded: %s", str(error).partition("\n")[0])
        if self._missed and not self._querying and self._waiting.qsize() <= _FEW_WAITING:
            self._missed = False
            self._recorder.forget_world()
            self._query()

    def drain(self) -> None:
        """Record all samples that have arrived."""
        for _ in range(self._waiting.qsize()):
            self.work(0.0)
        self._recorder.settle()

    def query_again(self) -> None:
        """Query the state again after the simulator was unreachable or restarted."""
        self.interrupted = False
        recorder = self._recorder
        if self.begun:
            now, event = recorder.time.simulated, SimulatorReturned()
            recorder.event(event, dump({"stamp": values_of(now), "kind": event.kind}), now)
            recorder.forget_world()
        self._query()

    def _on_sample(self, sample: zenoh.Sample) -> None:
        if self._waiting.qsize() < _MAX_WAITING:
            self._waiting.put((str(sample.key_expr), sample.payload.to_bytes()))
        else:
            if not self.lost:
                _log.warning("messages arrive faster than they can be written; some are lost")
            self.lost += 1
            self._missed = True

    def _on_presence(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.DELETE:
            self.interrupted = True

    def _query(self) -> None:
        """Query the state of the simulator; the answers go to the queue of samples."""
        self._querying = True
        for topic in (_INFO, _DEFINITION, _SCENE):
            self._client.ask(
                self._keys.world(topic),
                b"",
                lambda answer, topic=topic: self._waiting.put(_Answered(topic, answer)),  # type: ignore[misc]  # default
                timeout=_PATIENCE,
            )

    def _on_answer(self, answered: _Answered) -> None:
        if answered.answer is None or isinstance(answered.answer, RequestError):
            # The simulator has gone; `query_again` is called when it is back.
            self._querying = False
            return
        self._querying &= answered.topic != _SCENE
        value = _object_in(answered.answer)
        if answered.topic == _DEFINITION:
            value = _object_in(value["world"]["world_resource"]["resource_string"])
        self._answers[answered.topic] = value
        if answered.topic != _SCENE:
            return
        self._keys = Keys(self._keys.prefix, self._answers[_INFO]["aliases"])
        now = (self._answers[_DEFINITION], self._answers[_INFO], value)
        if not self.begun:
            self.begun = True
            self._recorder.begin(*now)
        elif self._recorder.world_stale:
            self._recorder.write_state(*now)
        else:
            self._recorder.scene(value)

    def _record(self, key: str, payload: bytes) -> None:
        match self._keys.parse(key):
            case TopicKey(robot, topic) if robot == WORLD:
                self._record_world(topic, payload)
            case TopicKey(robot, topic) if topic == TREE:
                self._recorder.tree(robot, _object_in(payload))
            case TopicKey(robot, topic) if topic in _MESSAGES:
                kind, cls = _MESSAGES[topic]
                message: Any = cls.model_validate_json(payload)
                self._recorder.sample(Sampled(kind, robot, message), message.header.stamp.to_nanoseconds())
            case ActionKey(robot, action, verb) if key == self._keys.action(robot, action, verb):
                self._record_goals(robot, action, verb, _object_in(payload))
        if self._recorder.scene_due and not self._querying:
            self._query()

    def _record_world(self, topic: str, payload: bytes) -> None:
        if topic == "events":
            event = _object_in(payload)
            self._recorder.event(events.from_json(event), payload, Time.model_validate(event["stamp"]).to_nanoseconds())
        elif topic == "clock":
            clock = Clock.model_validate_json(payload)
            self._recorder.sample(Sampled(Topic.CLOCK, "", clock), clock.clock.to_nanoseconds())

    def _record_goals(self, robot: str, action: str, verb: Verb, message: dict[str, Any]) -> None:
        if verb is Verb.FEEDBACK and action in actions():
            self._recorder.feedback(FeedbackSent(robot, action, message["goal_id"], message["feedback"]))
        elif verb is Verb.STATUS:
            self._recorder.status(StatusChanged(robot, action, tuple(map(_entry, message["status_list"]))))


def _object_in(payload: bytes | str) -> dict[str, Any]:
    value = from_json(payload)
    if not isinstance(value, dict):
        raise TypeError("not a JSON object")
    return value


def _entry(goal: Mapping[str, Any]) -> GoalEntry:
    info = goal["goal_info"]
    return GoalEntry(info["goal_id"], nanoseconds_of(info["stamp"]), GoalStatus(goal["status"]))

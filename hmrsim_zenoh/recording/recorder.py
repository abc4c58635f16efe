"""Conversion of a simulation's events and samples to a recording: ROS 2 messages, and the JSON of the wire.

The recording's time is simulated time that continues after a reset.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim import CONTRACT, __version__
from hmrsim.actions import registry as actions
from hmrsim.engine.sim_time import JITTER
from hmrsim.events.simulation import Deleted, SimulationReset, Spawned, Teleported, WorldLoaded
from hmrsim.interfaces.action_msgs import GoalStatusArray
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS, Time, values_of
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.interfaces.tf2_msgs import TFMessage
from hmrsim.interfaces.visualization_msgs import MarkerArray
from hmrsim.world.model import World
from hmrsim_zenoh.recording.writer import (
    EVENT_SCHEMA,
    INFO_SCHEMA,
    SCENE_SCHEMA,
    Schema,
    tree_schema,
    world_definition_schema,
)
from hmrsim_zenoh.ros2.codec.structures import definition
from hmrsim_zenoh.ros2.codec.types import action_type, message_type
from hmrsim_zenoh.ros2.publishing.goal_topics import Statuses
from hmrsim_zenoh.ros2.publishing.markers import WorldMarkers, frames_metadata, static_frames, transform
from hmrsim_zenoh.wire.envelopes import dump

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.outputs import FeedbackSent, Sampled, StatusChanged
    from hmrsim_zenoh.recording.writer import RecordingFile
    from hmrsim_zenoh.ros2.codec.types import MessageType


class Timeline:
    """Maps simulated time to the recording's time, which never goes back, even after a reset.

    Attributes:
        offset: Nanoseconds by which the recording's time is ahead of simulated time.
        begin: The first time in the recording; 0 before that.
        now: The latest time in the recording.
    """

    def __init__(self) -> None:
        self.offset = 0
        self.begin = 0
        self.now = 0

    @property
    def simulated(self) -> int:
        """The latest simulated time, in nanoseconds."""
        return self.now - self.offset

    def at(self, nanoseconds: int) -> int:
        """Return the recording's time of an instant that is current now."""
        # As everywhere, the first instant is 1: ROS reads zero as "unset".
        nanoseconds = max(1, nanoseconds)
        if nanoseconds + self.offset < self.now - JITTER:
            self.offset = self.now - (nanoseconds if nanoseconds > 1 else 0)
        self.now = max(self.now, nanoseconds + self.offset)
        self.begin = self.begin or self.now
        return self.now

    def seconds(self, simulated: float) -> float:
        """Return the recording's time of an instant, both in seconds."""
        return simulated + self.offset / NANOSECONDS

    def stamp(self, stamp: Mapping[str, int]) -> dict[str, int]:
        """Return a stamp in the recording's time, as plain values."""
        return values_of(nanoseconds_of(stamp) + self.offset)

    def message(self, message: Message) -> Message:
        """Return a message with its header's stamp, or its clock, in the recording's time."""
        if not self.offset:
            return message
        if (clock := getattr(message, "clock", None)) is not None:
            return message.model_copy(update={"clock": self._later(clock)})
        header = getattr(message, "header", None)
        if header is None:
            return message
        return message.model_copy(update={"header": header.model_copy(update={"stamp": self._later(header.stamp)})})

    def scene(self, scene: dict[str, Any]) -> dict[str, Any]:
        """Return a scene with all times in the recording's time."""
        if not self.offset:
            return scene
        return {**scene, "stamp": self.stamp(scene["stamp"]), "robots": [self._robot(each) for each in scene["robots"]]}

    def _robot(self, robot: dict[str, Any]) -> dict[str, Any]:
        motion = robot["motion"]
        if motion:
            motion = {**motion, "began": self.seconds(motion["began"])}
        return {**robot, "motion": motion, "goals": [self._goal(goal) for goal in robot["goals"]]}

    def _goal(self, goal: dict[str, Any]) -> dict[str, Any]:
        ended = goal.get("ended")
        return {**goal, "stamp": self.stamp(goal["stamp"]), "ended": None if ended is None else self.stamp(ended)}

    def _later(self, time: Time) -> Time:
        return Time.from_nanoseconds(time.to_nanoseconds() + self.offset)


def nanoseconds_of(stamp: Mapping[str, int]) -> int:
    """Return a stamp's nanoseconds."""
    return stamp["sec"] * NANOSECONDS + stamp["nanosec"]


EVENTS, SCENE, INFO, WORLD_TOPIC = "/_world/events", "/_world/scene", "/_world/info", "/_world/world"
ABOUT: Final = "hmrsim"
"""The name of the recording's metadata record."""
MARKERS, THINGS = "/world/markers", "/world/things"

_RESTARTS: Final = (SimulationReset, WorldLoaded)
"""The events after which the whole state is written again at once."""
_MAKES_SCENE_STALE: Final = (*_RESTARTS, Spawned, Deleted, Teleported)

_LATCHED: Final = frozenset({MARKERS, THINGS, "/tf_static"})
_INFINITE: Final = "{sec: 9223372036, nsec: 854775807}"
_LATCHED_PROFILE: Final = f"""\
- history: keep_last
  depth: 1
  reliability: reliable
  durability: transient_local
  deadline: {_INFINITE}
  lifespan: {_INFINITE}
  liveliness: automatic
  liveliness_lease_duration: {_INFINITE}
  avoid_ros_namespace_conventions: false
"""
"""The quality of service of latched topics in rosbag2's format, which requires all fields."""

_SCENE_PERIOD: Final = NANOSECONDS
_THINGS_PERIOD: Final = NANOSECONDS // 10
"""Nanoseconds between two snapshots of all items, doors and lanes while some of them change."""


class LogLine(NamedTuple):
    """A line of the log on ``/rosout``.

    Attributes:
        level: The severity, as in `Log`.
    """

    level: int
    name: str
    text: str


class Recorder:
    """Writes events and samples; simulated times become the recording's, which never go back.

    Args:
        line_of: Returns the line of an event on ``/rosout``; None for no line.

    Attributes:
        stale: Whether the scene has to be written again eventually.
        world_stale: Whether the world and the description have to be written again, too.
        time: The recording's time.
    """

    def __init__(self, file: RecordingFile, line_of: Callable[[Event], LogLine | None]) -> None:
        self._file = file
        self._line_of = line_of
        self._markers = WorldMarkers()
        self._statuses: dict[tuple[str, str], Statuses] = {}
        self._channels: dict[str, tuple[int, MessageType]] = {}
        self._json: dict[str, int] = {}
        self._transforms: list[dict[str, Any]] = []
        self._things_changed = self._restarted = False
        self._things_at = self._scene_at = 0
        self.time = Timeline()
        self.stale = self.world_stale = False

    @property
    def scene_due(self) -> bool:
        """True if the scene has to be written again now; scenes of many robots are expensive."""
        return self._restarted or (self.stale and self.time.now - self._scene_at >= _SCENE_PERIOD)

    def begin(self, definition: Mapping[str, Any], info: Mapping[str, Any], scene: dict[str, Any], **more: str) -> None:
        """Write the initial state; *more* is further metadata."""
        world = info["world"]
        about = {
            "hmrsim": __version__,
            "contract": str(CONTRACT),
            "world": str(world["name"]),
            "world_hash": str(world["hash"]),
            "units": str(world["units"]),
            **frames_metadata(world["units"]),
            **more,
        }
        self._file.describe(ABOUT, about)
        self._file.attach("world.json", "application/json", json.dumps(definition).encode())
        # First, so that a reader of events finds their channel at once.
        self._json_channel(EVENTS, EVENT_SCHEMA)
        self.write_state(definition, info, scene)

    def forget_world(self) -> None:
        """Mark the world and the description as stale after a loss of samples."""
        self.world_stale = True

    def write_state(self, definition: Mapping[str, Any], info: Mapping[str, Any], scene: dict[str, Any]) -> None:
        """Write the world, the description and the scene again."""
        self.world_stale = False
        self._go_to(nanoseconds_of(scene["stamp"]))
        self._add_json(WORLD_TOPIC, world_definition_schema, definition)
        self._add_json(INFO, INFO_SCHEMA, info)
        world = World.model_validate(definition)
        self._markers.load(world)
        if static := static_frames(world.units, self.time.now):
            self._add("/tf_static", TFMessage, {"transforms": static})
        self.scene(scene)

    def scene(self, scene: dict[str, Any]) -> None:
        """Write the current scene."""
        self.stale = self._restarted = False
        self._scene_at = self._go_to(nanoseconds_of(scene["stamp"]))
        shifted = self.time.scene(scene)
        self._add_json(SCENE, SCENE_SCHEMA, shifted)
        self._markers.follow(shifted)
        self._add(MARKERS, MarkerArray, self._markers.markers(self.time.now))
        self._write_things(self.time.now)

    def event(self, event: Event, payload: bytes, nanoseconds: int) -> None:
        """Write an event and its line on ``/rosout``.

        Args:
            event: The event.
            payload: The event as on the wire.
            nanoseconds: Its simulated time.
        """
        line = self._line_of(event)
        time = self._go_to(nanoseconds)
        if self.time.offset:
            payload = dump({**json.loads(payload), "stamp": values_of(time)})
        self._file.add(self._json_channel(EVENTS, EVENT_SCHEMA), time, payload)
        self.stale |= isinstance(event, _MAKES_SCENE_STALE)
        self._restarted |= isinstance(event, _RESTARTS)
        self.world_stale |= isinstance(event, WorldLoaded)
        if line is not None:
            self.log(line)
        self._things_changed |= self._markers.change(event)

    def log(self, line: LogLine) -> None:
        """Write a line on ``/rosout`` at the current time."""
        values = {"stamp": values_of(self.time.now), "level": line.level, "name": line.name, "msg": line.text}
        self._add("/rosout", Log, {**values, "file": "", "function": "", "line": 0})

    def sample(self, sample: Sampled, nanoseconds: int) -> None:
        """Write a sample of a topic."""
        self._go_to(nanoseconds)
        message = self.time.message(sample.message)
        topic = sample.topic.value
        self._add(f"/{sample.robot}/{topic}" if sample.robot else f"/{topic}", type(message), message)
        if isinstance(message, Odometry):
            pose = message.pose.pose
            self._transforms.append(transform(message.header, message.child_frame_id, pose.position, pose.orientation))

    def status(self, event: StatusChanged) -> None:
        """Write the status list of an action's goals, at the time of the latest event."""
        topic = f"/{event.robot}/{event.action}/_action/status"
        channel, _ = self._channel(topic, GoalStatusArray)
        statuses = self._statuses.get((event.robot, event.action))
        if statuses is None:
            statuses = self._statuses[event.robot, event.action] = Statuses()
        goals = event.goals
        if offset := self.time.offset:
            goals = tuple(goal._replace(stamp=goal.stamp + offset) for goal in goals)
        self._file.add(channel, self.time.now, statuses.encode(goals))

    def feedback(self, event: FeedbackSent, nanoseconds: int | None = None) -> None:
        """Write feedback; by default at the time of the latest event."""
        if nanoseconds is not None:
            self._go_to(nanoseconds)
        topic = f"/{event.robot}/{event.action}/_action/feedback"
        known = self._channels.get(topic)
        if known is None:
            action = actions()[event.action]
            known = self._opened(topic, action_type(action).feedback, action.feedback)
        goal_id = {"uuid": bytes.fromhex(event.goal_id)}
        self._file.add(known[0], self.time.now, known[1].encode({"goal_id": goal_id, "feedback": event.feedback}))

    def tree(self, robot: str, state: Mapping[str, Any]) -> None:
        """Write the state of a robot's behavior tree, at the time of the latest event."""
        self._add_json(f"/{robot}/_tree", tree_schema, state)

    def settle(self) -> None:
        """Write the pending data of this instant; call this after its last event."""
        self._write_transforms(self.time.now)
        if self._things_changed:
            self._write_things(self.time.now)

    def _go_to(self, nanoseconds: int) -> int:
        """Advance to an instant of the simulation; return the recording's time."""
        before = self.time.now
        now = self.time.at(nanoseconds)
        if now != before:
            self._write_transforms(before)
            if self._things_changed and before - self._things_at >= _THINGS_PERIOD:
                self._write_things(before)
        return now

    def _write_transforms(self, time: int) -> None:
        """Write the transforms of all robots as one message: separate ones would be a third of all messages."""
        if self._transforms:
            transforms, self._transforms = self._transforms, []
            self._add("/tf", TFMessage, {"transforms": transforms}, time)

    def _write_things(self, time: int) -> None:
        """Write all items, doors and closed lanes; doing so at each change would take too long."""
        self._things_changed, self._things_at = False, time
        self._add(THINGS, MarkerArray, self._markers.things(time), time)

    def _add(
        self, topic: str, cls: type[Message], values: Message | Mapping[str, Any], time: int | None = None
    ) -> None:
        channel, type_ = self._channel(topic, cls)
        self._file.add(channel, self.time.now if time is None else time, type_.encode(values))

    def _channel(self, topic: str, cls: type[Message]) -> tuple[int, MessageType]:
        return self._channels.get(topic) or self._opened(topic, message_type(cls), cls)

    def _opened(self, topic: str, type_: MessageType, cls: type[Message]) -> tuple[int, MessageType]:
        schema = Schema(type_.name, "ros2msg", definition(type_.structure, cls), "cdr")
        about = {"topic_type_hash": type_.hash}
        if topic in _LATCHED or topic.endswith("/_action/status"):
            about["offered_qos_profiles"] = _LATCHED_PROFILE
        opened = self._channels[topic] = self._file.channel(topic, schema, about), type_
        return opened

    def _add_json(self, topic: str, schema: Schema | Callable[[], Schema], values: Mapping[str, Any]) -> None:
        self._file.add(self._json_channel(topic, schema), self.time.now, dump(values))

    def _json_channel(self, topic: str, schema: Schema | Callable[[], Schema]) -> int:
        number = self._json.get(topic)
        if number is None:
            number = self._json[topic] = self._file.channel(topic, schema if isinstance(schema, Schema) else schema())
        return number

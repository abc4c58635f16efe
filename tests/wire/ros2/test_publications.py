"""ROS topics of a simulation, as other nodes receive them."""

from __future__ import annotations

import queue
import threading
from typing import TYPE_CHECKING, Any

import pytest
import zenoh
from zenoh.ext import HistoryConfig, RecoveryConfig, declare_advanced_subscriber

from hmrsim.actions import registry as actions
from hmrsim.geometry import Pose
from hmrsim.protocol.goal import GoalEntry, GoalStatus, made_goal_id
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged, Sampled, StatusChanged
from hmrsim.protocol.topics import Topic
from hmrsim.services import registry as services
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import World
from hmrsim_zenoh.ros2.keys import gid, read_token
from hmrsim_zenoh.ros2.names import names_of
from hmrsim_zenoh.ros2.publishing.endpoints import Endpoints
from hmrsim_zenoh.ros2.publishing.publications import Publications
from hmrsim_zenoh.ros2.publishing.publishers import LatchedPublisher, Publisher
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds, Wire, read_attachment
from hmrsim_zenoh.wire.session import SessionOptions, open_client, open_server
from tests.patience import PATIENCE

from tests.simulation import SMALL_WORLD  # isort: skip

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hmrsim_zenoh.ros2.codec.types import MessageType

GOAL = made_goal_id("test", 1)
ACCEPTED = StatusChanged("wall_e", "navigate_to_pose", (GoalEntry(GOAL, 10**9, GoalStatus.ACCEPTED),))
FEEDBACK = actions()["navigate_to_pose"].feedback().model_dump()


class Heard:
    """The samples that a subscriber of a topic receives, in order."""

    def __init__(self, type_: MessageType) -> None:
        self._type = type_
        self._samples: queue.Queue[zenoh.Sample] = queue.Queue()
        self.put = zenoh.handlers.Callback(self._samples.put, indirect=False)

    def next(self) -> Any:
        """Return the next message; waits for it."""
        return self._type.decode(self.sample().payload.to_bytes())

    def sample(self) -> zenoh.Sample:
        return self._samples.get(timeout=PATIENCE)

    def until(self, wanted: Callable[[Any], bool]) -> Any:
        """Return the first message that fulfills a condition."""
        while not wanted(message := self.next()):
            pass
        return message


class Stage:
    """Publications of the small world, and another session on the network."""

    def __init__(self, wire: Wire) -> None:
        self.wire = wire
        self.changed = threading.Semaphore(0)
        self.simulator = Simulator(World.model_validate(SMALL_WORLD))
        self.session, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
        self.other = open_client(SessionOptions(connect=endpoints, listen=("tcp/127.0.0.1:0",)))
        self.endpoints = Endpoints(wire, actions(), services())
        self.publications = Publications(
            self.session,
            wire,
            names_of(self.simulator),
            actions=actions(),
            services=services(),
            simulator=self.simulator,
            changed=self.changed.release,
        )
        self._tokens: queue.Queue[zenoh.Sample] = queue.Queue()
        handler = zenoh.handlers.Callback(self._tokens.put, indirect=False)
        self._watched = self.other.liveliness().declare_subscriber("@ros2_lv/**", handler, history=True)
        self._subscribers: list[Any] = []

    def odom(self, robot: str) -> Sampled:
        return self.simulator.readings.odom(self.simulator.robots[robot])

    def start(self) -> None:
        self.publications.start()
        thread = self.publications._declarations._thread
        assert thread is not None
        self.token("/cart/amcl/get_state")

    def token(self, name: str, kind: zenoh.SampleKind = zenoh.SampleKind.PUT) -> str:
        """Return the token of an endpoint once it is declared, or once it is gone."""
        while True:
            sample = self._tokens.get(timeout=PATIENCE)
            read = read_token(str(sample.key_expr))
            if sample.kind == kind and read and read.endpoint and read.endpoint.name == name:
                return str(sample.key_expr)

    def hear(self, name: str, type_: MessageType) -> Heard:
        """Subscribe as rmw_zenoh does with volatile durability; returns once the publisher has matched."""
        heard = Heard(type_)
        key = self.wire.key(name, type_.dds_name, type_.hash)
        self._subscribers.append(self.other.declare_subscriber(key, heard.put))
        while not self.publications._interest.in_key(key):
            assert self.changed.acquire(timeout=PATIENCE)
        self.publications.look()
        return heard

    def hear_latched(self, name: str, type_: MessageType) -> Heard:
        """Subscribe as rmw_zenoh does to what is latched."""
        heard = Heard(type_)
        self._subscribers.append(
            declare_advanced_subscriber(
                self.other,
                self.wire.key(name, type_.dds_name, type_.hash),
                heard.put,
                history=HistoryConfig(detect_late_publishers=True, max_samples=1),
                subscriber_detection=True,
                recovery=RecoveryConfig(heartbeat=True),
            )
        )
        return heard

    def close(self) -> None:
        self.publications.close()
        self.other.close()
        self.session.close()


@pytest.fixture
def stage() -> Iterator[Stage]:
    """Return publications on rmw_zenoh's wire that have not started."""
    made = Stage(RmwZenoh())
    yield made
    made.close()


def statuses(message: Any) -> list[int]:
    return [each["status"] for each in message["status_list"]]


STATUS = "/wall_e/navigate_to_pose/_action/status"


def test_a_subscriber_from_before_the_publisher_gets_every_status_list(stage):
    heard = stage.hear_latched(STATUS, stage.endpoints.status_type)
    stage.start()
    first = heard.next()
    stage.publications.emit(ACCEPTED)

    assert [[], [1]] == [statuses(first), statuses(heard.until(statuses))]


def test_a_late_subscriber_gets_the_last_status_list(stage):
    stage.start()
    stage.publications.emit(ACCEPTED)

    assert [1] == statuses(stage.hear_latched(STATUS, stage.endpoints.status_type).next())


def test_one_query_gets_the_last_messages_of_many_topics(stage):
    stage.start()
    type_ = stage.endpoints.message_type("amcl_pose")
    key = stage.wire.key("/*/amcl_pose", type_.dds_name, type_.hash)
    replies = stage.other.get(f"{key}/@adv/**?_anyke", timeout=PATIENCE)

    assert ["cart", "eve", "wall_e"] == sorted(str(reply.ok.key_expr).split("/")[1] for reply in replies)


def test_a_subscriber_that_joins_between_messages_gets_each_later_one_once_and_in_order(stage):
    stage.start()
    last, heard = 200, []
    for number in range(1, last + 1):
        if number % 20 == 0:
            heard.append(stage.hear_latched(STATUS, stage.endpoints.status_type))
        entry = GoalEntry(GOAL, number, GoalStatus.ACCEPTED)
        stage.publications.emit(StatusChanged("wall_e", "navigate_to_pose", (entry,)))

    for each in heard:
        received = [0]
        while received[-1] != last:
            received.append(each.next()["status_list"][0]["goal_info"]["stamp"]["nanosec"])
        assert list(range(received[1], last + 1)) == received[1:]


def test_the_first_status_list_has_goals_from_before_the_publisher(stage):
    stage.publications._declarations.want = lambda *_parts: None
    stage.publications.start()
    stage.publications.emit(ACCEPTED)
    del stage.publications._declarations.want
    stage.start()

    assert [1] == statuses(stage.hear_latched(STATUS, stage.endpoints.status_type).next())


def test_the_attachment_has_the_id_of_the_token_and_counts_from_1(stage):
    heard = stage.hear_latched(STATUS, stage.endpoints.status_type)
    stage.publications.start()
    token = stage.token(STATUS)
    attached = heard.sample().attachment

    assert attached is not None
    assert (1, gid(token)) == (read_attachment(attached.to_bytes()).sequence, read_attachment(attached.to_bytes()).gid)


def test_a_late_subscriber_gets_the_first_pose(stage):
    stage.start()
    pose = stage.hear_latched("/eve/amcl_pose", stage.endpoints.message_type("amcl_pose")).next()

    assert {"x": 9.0, "y": 2.0, "z": 0.0} == pose["pose"]["pose"]["position"]


def test_the_pose_is_published_after_a_goal_only_if_the_robot_has_moved(stage, monkeypatch):
    stage.start()
    published = []
    monkeypatch.setattr(stage.publications, "_publish", lambda *sent: published.append(sent[-1]))
    for action in ("wait", "navigate_to_pose"):
        stage.publications.emit(GoalChanged(10**9, "eve", action, GOAL, GoalStatus.SUCCEEDED))
        if action == "wait":
            stage.simulator.robots["eve"].move_to(Pose(3.0, 4.0))

    assert [3.0] == [message["pose"].pose.position.x for message in published]


def test_a_subscriber_of_the_pose_turns_on_odometry(stage):
    stage.start()
    before = stage.publications.wants(Topic.ODOM)
    stage.hear("/eve/amcl_pose", stage.endpoints.message_type("amcl_pose"))

    assert (False, True) == (before, stage.publications.wants(Topic.ODOM))


def test_each_layout_with_a_subscriber_is_published_on_its_key(stage):
    stage.start()
    kilted, lyrical = stage.endpoints.feedback_types("navigate_to_pose")
    name = "/wall_e/navigate_to_pose/_action/feedback"
    first = stage.hear(name, kilted)
    stage.publications.emit(FeedbackSent("wall_e", "navigate_to_pose", GOAL, FEEDBACK))
    second = stage.hear(name, lyrical)
    stage.publications.look()
    stage.publications.emit(FeedbackSent("wall_e", "navigate_to_pose", GOAL, FEEDBACK, last=True))

    short, long = first.sample(), second.sample()
    assert 8 == len(long.payload.to_bytes()) - len(short.payload.to_bytes())


def test_layout_without_a_subscriber_is_not_encoded(stage, monkeypatch):
    stage.start()
    kilted, lyrical = stage.endpoints.feedback_types("navigate_to_pose")
    monkeypatch.setitem(vars(lyrical), "encode", lambda _values: pytest.fail("encoded"))
    heard = stage.hear("/wall_e/navigate_to_pose/_action/feedback", kilted)
    stage.publications.emit(FeedbackSent("wall_e", "navigate_to_pose", GOAL, FEEDBACK))

    assert list(bytes.fromhex(GOAL)) == list(heard.next()["goal_id"]["uuid"])


def test_feedback_without_a_subscriber_is_not_encoded(stage, monkeypatch):
    stage.start()
    for type_ in stage.endpoints.feedback_types("navigate_to_pose"):
        monkeypatch.setitem(vars(type_), "encode", lambda _values: pytest.fail("encoded"))
    wanted = stage.publications.wants(Topic.FEEDBACK)
    stage.publications.emit(FeedbackSent("wall_e", "navigate_to_pose", GOAL, FEEDBACK))

    assert wanted is False


def test_feedback_that_can_not_be_encoded_is_logged(stage, caplog):
    stage.start()
    stage.hear("/wall_e/navigate_to_pose/_action/feedback", stage.endpoints.feedback_types("navigate_to_pose")[0])
    stage.publications.emit(FeedbackSent("wall_e", "navigate_to_pose", GOAL, {}))

    assert "not published in ROS" in caplog.text


def test_frames_of_all_robots_have_the_robots_names(stage):
    stage.start()
    heard = stage.hear("/tf", stage.endpoints.message_type("tf"))
    stage.publications.emit(stage.odom("eve"))

    (transform,) = heard.next()["transforms"]
    assert ("map", "eve/base_link") == (transform["header"]["frame_id"], transform["child_frame_id"])
    assert {"x": 9.0, "y": 2.0, "z": 0.0} == transform["transform"]["translation"]


def test_the_transforms_of_one_robot_have_no_prefix(stage):
    stage.start()
    heard = stage.hear("/eve/tf", stage.endpoints.message_type("tf"))
    stage.publications.emit(stage.odom("eve"))

    found = [(one["header"]["frame_id"], one["child_frame_id"]) for one in heard.next()["transforms"]]
    assert [("map", "base_footprint"), ("base_footprint", "base_link")] == found


@pytest.mark.parametrize(("topic", "robot"), [(Topic.CLOCK, ""), (Topic.ODOM, "eve")])
def test_a_sample_is_published_unchanged(stage, topic, robot):
    stage.start()
    sample = stage.odom("eve") if robot else stage.simulator.readings.clock()
    type_ = stage.endpoints.message_type(topic.value)
    heard = stage.hear(f"/{robot}/{topic.value}" if robot else "/clock", type_)
    stage.publications.emit(sample)

    assert type_.decode(type_.encode(sample.message)) == heard.next()


def test_a_lost_robot_disappears_until_it_is_back(stage):
    stage.start()
    stage.publications.follow(names_of(stage.simulator), {"eve"})
    stage.token("/eve/navigate_to_pose/_action/status", zenoh.SampleKind.DELETE)
    stage.publications.follow(names_of(stage.simulator))

    assert stage.token("/eve/navigate_to_pose/_action/status")


def test_served_types_are_known_before_they_are_declared(stage):
    served = stage.publications.served("/wall_e/navigate_to_pose/_action/feedback")

    assert {"9d1f6fa2", "2c1b4ec1"} == {hash_.removeprefix("RIHS01_")[:8] for _, hash_ in served}


def test_a_lost_robot_serves_nothing_until_it_is_back(stage):
    names = names_of(stage.simulator)
    before = stage.publications.served("/eve/odom")
    stage.publications.follow(names, {"eve"})
    lost = stage.publications.served("/eve/odom")
    stage.publications.follow(names)

    assert before
    assert not lost
    assert before == stage.publications.served("/eve/odom")


def test_parts_of_a_large_fleet_are_declared_when_asked_for(stage, monkeypatch):
    monkeypatch.setattr("hmrsim_zenoh.ros2.publishing.parts.MAX_STANDING", 0)
    stage.publications.start()
    stage.publications.ask("/cart/nothing")
    stage.publications.ask("/cart/wait/_action/get_result")

    # Those that stand may still come, in any order.
    tokens = iter(lambda: read_token(str(stage._tokens.get(timeout=PATIENCE).key_expr)), None)
    of_robots = (token for token in tokens if token.node.full_name.count("/") > 1)
    first_other = next(token for token in of_robots if token.node.name != "bt_navigator")
    assert first_other.node.full_name == "/cart/behavior_server"
    assert stage.token("/cart/wait/_action/status")


def test_only_names_of_new_robots_are_new(stage):
    stage.start()
    names = names_of(stage.simulator)
    seen = []
    for lost in (("eve",), ()):
        stage.publications.follow(names, lost)
        seen.append([stage.publications.is_new(f"/{robot}/odom") for robot in ("eve", "wall_e", "nobody")])

    assert [[False, False, False], [True, False, False]] == seen


def test_the_same_robots_are_no_change(stage):
    names = names_of(stage.simulator)
    found = [stage.publications.follow(names, lost) for lost in ((), ("eve",), ("eve",))]

    assert [False, True, False] == found


def test_feedback_before_the_declaration_is_kept_without_tokens():
    stage = Stage(Ros2Dds())
    try:
        stage.publications._declarations.want = lambda *_parts: None
        stage.publications.start()
        (type_,) = stage.endpoints.feedback_types("navigate_to_pose")
        heard = stage.hear("/wall_e/navigate_to_pose/_action/feedback", type_)
        stage.publications.emit(FeedbackSent("wall_e", "navigate_to_pose", GOAL, FEEDBACK))
        found = heard.next()
    finally:
        stage.close()

    assert list(bytes.fromhex(GOAL)) == list(found["goal_id"]["uuid"])


def test_on_the_bridges_wire_the_key_is_the_name():
    stage = Stage(Ros2Dds())
    try:
        stage.publications.start()
        heard = stage.hear_latched(STATUS, stage.endpoints.status_type)
        stage.publications.emit(ACCEPTED)
        sample = heard.sample()
    finally:
        stage.close()

    assert ("wall_e/navigate_to_pose/_action/status", None) == (str(sample.key_expr), sample.attachment)


def test_a_reopened_latched_publisher_starts_with_the_last_message():
    said: list[tuple[bytes, int]] = []

    def put(payload: bytes, attachment: bytes) -> None:
        said.append((payload, read_attachment(attachment).sequence))

    publisher = LatchedPublisher()
    publisher.publish(b"a")
    publisher.open(put, bytes(16))
    publisher.publish(b"b")
    publisher.close()
    publisher.publish(b"c")
    publisher.open(put, bytes(16))

    assert [(b"a", 1), (b"b", 2), (b"c", 1)] == said


@pytest.mark.parametrize("kind", [Publisher, LatchedPublisher])
def test_shut_waits_for_a_put_that_is_running(kind):
    """Zenoh refuses to undeclare a publisher during a put."""
    publisher = kind()
    waited: list[bool] = []
    shutting = threading.Thread(target=publisher.close)

    def put(_payload: bytes) -> None:
        shutting.start()
        shutting.join(0.05)
        waited.append(shutting.is_alive())

    publisher.open(put, None)
    publisher.publish(b"a")
    shutting.join(PATIENCE)
    publisher.publish(b"b")

    assert [True] == waited

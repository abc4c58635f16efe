"""The content of recordings, read with the reader of mcap and the decoder of rosbags."""

from __future__ import annotations

import json
from collections import Counter

import pytest
from mcap.reader import make_reader
from rosbags.interfaces import QosDurability, QosReliability
from rosbags.rosbag2.metadata import parse_qos
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hmrsim.events.robots import ItemPicked, Stopped
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import CallService, SendGoal
from hmrsim.services import registry as services
from hmrsim_zenoh.recording import Recording
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.writer import RecordingFile
from tests.simulation import SMALL_WORLD
from tests.unit.hmrsim_zenoh.recording.conftest import recorded

ID = "00112233445566778899aabbccddeeff"
BATTERY = {"battery": {"capacity": 100.0}}


def go(x, y, robot="wall_e", goal_id=ID):
    pose = {"pose": {"pose": {"position": {"x": x, "y": y}}}}
    return SendGoal(robot, "navigate_to_pose", NavigateToPose.Goal.model_validate(pose), goal_id)


def call(service, **request):
    return CallService(service, services()[service].request.model_validate(request))


def at(x):
    """Return the state of a robot for the service."""
    return {"pose": {"position": {"x": x, "y": 8.0}}}


def messages(path, topic):
    """Return time and content of a topic's messages, decoded with the schemas in the file."""
    ros = get_typestore(Stores.EMPTY)
    with path.open("rb") as file:
        found = []
        for schema, channel, message in make_reader(file).iter_messages(topics=[topic]):
            if channel.message_encoding == "json":
                found.append((message.log_time, json.loads(message.data)))
                continue
            if schema.name not in ros.fielddefs:
                ros.register(get_types_from_msg(schema.data.decode(), schema.name))
            found.append((message.log_time, ros.deserialize_cdr(message.data, schema.name)))
    return found


def topics(path):
    """Return the type of each channel."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
        return {channel.topic: summary.schemas[channel.schema_id].name for channel in summary.channels.values()}


def log(path):
    """Return time in seconds, level, name and text of all lines of /rosout."""
    return [(time / 1e9, line.level, line.name, line.msg) for time, line in messages(path, "/rosout")]


def test_channels_have_the_types_of_ros(record):
    """Our own channels have the payloads of the keys of the same names."""
    assert {
        "/_world/events": "hmrsim/Event",
        "/_world/world": "hmrsim/World",
        "/_world/info": "hmrsim/WorldInfo",
        "/_world/scene": "hmrsim/Scene",
        "/world/markers": "visualization_msgs/msg/MarkerArray",
        "/world/things": "visualization_msgs/msg/MarkerArray",
        "/rosout": "rcl_interfaces/msg/Log",
        "/clock": "rosgraph_msgs/msg/Clock",
        "/tf": "tf2_msgs/msg/TFMessage",
        "/wall_e/odom": "nav_msgs/msg/Odometry",
        "/eve/odom": "nav_msgs/msg/Odometry",
        "/cart/odom": "nav_msgs/msg/Odometry",
        "/wall_e/navigate_to_pose/_action/status": "action_msgs/msg/GoalStatusArray",
        "/wall_e/navigate_to_pose/_action/feedback": "nav2_msgs/action/NavigateToPose_FeedbackMessage",
    } == topics(record((1.0, go(5.0, 2.0))))


def test_the_profile_is_ros_2s(record):
    """The profile tells Foxglove that it opens ROS 2 messages."""
    with record().open("rb") as file:
        assert "ros2" == make_reader(file).get_header().profile


def test_messages_are_at_their_simulated_time(record):
    """A goal of 4 m at 1 m/s that was sent at 1 s ends at 5 s."""
    ends = messages(record((1.0, go(5.0, 2.0))), "/wall_e/navigate_to_pose/_action/status")

    assert [(1_000_000_000, 1), (1_000_000_000, 2), (5_000_000_000, 4)] == [
        (time, statuses.status_list[0].status) for time, statuses in ends
    ]


def test_a_status_says_whose_it_is(record):
    """The status list has the id of the sent goal."""
    ((_, first), *_) = messages(record((1.0, go(5.0, 2.0))), "/wall_e/navigate_to_pose/_action/status")

    assert bytes.fromhex(ID) == bytes(first.status_list[0].goal_info.goal_id.uuid)


def test_feedback_says_how_far_it_is(record):
    """After 1 s of 4 m there are 3 m left."""
    said = dict(messages(record((1.0, go(5.0, 2.0))), "/wall_e/navigate_to_pose/_action/feedback"))

    assert pytest.approx(3.0) == said[2_000_000_000].feedback.distance_remaining


def test_odometry_says_where_a_robot_is(record):
    """After 1 s the robot is 1 m from its start."""
    said = dict(messages(record((1.0, go(5.0, 2.0))), "/wall_e/odom"))

    assert pytest.approx(2.0) == said[2_000_000_000].pose.pose.position.x


def test_tf_has_a_frame_a_robot(record):
    """Each is in the frame of the map."""
    frames = {
        (each.header.frame_id, each.child_frame_id) for _, tf in messages(record(), "/tf") for each in tf.transforms
    }

    assert {("map", "wall_e/base_link"), ("map", "eve/base_link"), ("map", "cart/base_link")} == frames


def test_batteries_are_recorded(record):
    """Batteries are recorded once per simulated second."""
    world = {**SMALL_WORLD, "robot_types": {"nurse": {"components": BATTERY}}}
    levels = [state.percentage for _, state in messages(record(until=3.0, world=world), "/wall_e/battery_state")]

    assert [0.99, 0.98, 0.97] == [round(level, 2) for level in levels]


def test_rosout_says_how_goals_fare(record):
    """The log has goals and errors as text."""
    path = record((1.0, go(5.0, 2.0)), (6.0, go(15.0, 8.0, goal_id="1" * 32)))

    assert [
        (1.0, 20, "wall_e", "navigate_to_pose accepted: (5, 2)"),
        (5.0, 20, "wall_e", "navigate_to_pose SUCCEEDED"),
        (6.0, 20, "wall_e", "navigate_to_pose accepted: (15, 8)"),
        (6.0, 40, "wall_e", "navigate_to_pose ABORTED: no route from door to far"),
    ] == log(path)


def test_events_are_those_of_the_wire(record):
    """Events for watchers only are among them."""
    kinds = Counter(event["kind"] for _, event in messages(record((1.0, go(5.0, 2.0))), "/_world/events"))

    assert {"goal": 1, "status": 3, "route": 1, "motion": 1} == kinds


def test_the_world_is_attached(record):
    """The world is attached as a file that can be run again."""
    with record().open("rb") as file:
        (attachment,) = make_reader(file).iter_attachments()

    assert ("world.json", "small") == (attachment.name, json.loads(attachment.data)["name"])


def test_metadata_says_what_was_recorded(record):
    """The metadata names the program, the world, the unit of length and the seed."""
    with record().open("rb") as file:
        ((name, values),) = ((each.name, each.metadata) for each in make_reader(file).iter_metadata())

    assert ("hmrsim", "small", "m", "0") == (name, values["world"], values["units"], values["seed"])


def test_markers_show_the_world(record):
    """Lanes and walls as one marker each, the robots in their own frames."""
    ((_, array),) = messages(record(), "/world/markers")
    shown = Counter((marker.ns, marker.header.frame_id) for marker in array.markers[1:])

    assert {("lanes", "map"): 1, ("walls", "map"): 1} == {key: n for key, n in shown.items() if key[1] == "map"}
    assert 3 == shown["robots", "wall_e/base_link"]


def test_a_closed_outline_is_drawn_to_its_end(record):
    """One wall of one piece and a solid of four are five lines, so ten points."""
    ((_, array),) = messages(record(), "/world/markers")

    assert [10] == [len(marker.points) for marker in array.markers if marker.ns == "walls"]


def test_what_is_carried_is_where_its_carrier_is(record):
    """The marker of a carried item is in the robot's frame."""
    pickup = SendGoal("eve", "pickup", Pickup.Goal(target_name="parcel"), ID)
    *_, (_, array) = messages(record((1.0, pickup)), "/world/things")
    spheres = [marker.header.frame_id for marker in array.markers if marker.ns == "items" and marker.type == 2]

    assert ["eve/base_link", "map", "map"] == spheres


def test_pixels_are_looked_at_from_above(record):
    """`map` is upside down in a further frame, as y points down."""
    ((_, tf),) = messages(record(world={**SMALL_WORLD, "units": "px"}), "/tf_static")
    ((transform,),) = (tf.transforms,)

    assert ("world", "map", 1.0) == (
        transform.header.frame_id,
        transform.child_frame_id,
        transform.transform.rotation.x,
    )


def test_time_goes_on_after_a_reset(record):
    """An event 2 s after a reset at 3 s is recorded at 5 s, so that events stay in order."""
    wait = SendGoal("wall_e", "wait", Wait.Goal.model_validate({"time": {"sec": 1}}), ID)
    path = record((3.0, call("reset_simulation")), (2.0, wait), until=4.0)

    assert [5.0, 5.0, 6.0] == [
        event["stamp"]["sec"] + event["stamp"]["nanosec"] / 1e9
        for event in Recording(path).events()
        if event["kind"] == "status"
    ]


def test_a_reset_records_the_scene_anew(record):
    """The scene is written again with the next sample of the clock."""
    path = record((3.0, call("reset_simulation")), until=4.0)
    scenes = [time for time, key, _ in Recording(path).samples() if key == "_world/scene"]

    assert [1, 3_100_000_000] == scenes


def test_a_robot_that_is_spawned_is_drawn(record):
    """The markers are written again."""
    spawn = call("spawn_entity", name="new", uri="robot_type:carrier", initial_pose={"pose": {"position": {"x": 2.0}}})
    *_, (_, array) = messages(record((1.0, spawn), until=2.0), "/world/markers")

    assert "new/base_link" in {marker.header.frame_id for marker in array.markers}


def test_robots_that_come_one_after_the_other_make_one_scene_a_second(record):
    """A stale scene is written at intervals, and at the end at the latest."""
    spawns = [
        (0.5 + i / 10, call("spawn_entity", name=f"new{i}", uri="robot_type:carrier", initial_pose=at(2.0 + i)))
        for i in range(10)
    ]
    path = record(*spawns, until=1.45)
    scenes = [(at, len(scene["robots"])) for at, key, scene in Recording(path).samples() if key == "_world/scene"]

    assert [(1, 3), (1_100_000_000, 9), (1_450_000_000, 13)] == scenes


def test_what_changes_at_once_is_drawn_once(tmp_path):
    """All items are one message, written at most ten times a second."""
    path, items = tmp_path / "run.mcap", [{"name": f"i{n}", "at": [n, 0], "carrier": None} for n in range(3)]
    with RecordingFile(path) as file:
        recorder = Recorder(file, lambda _event: None)
        scene = {"robots": [], "items": items, "fixtures": [], "closed_lanes": [], "stamp": {"sec": 1, "nanosec": 0}}
        recorder.scene(scene)
        for milliseconds, item in ((2000, "i0"), (2000, "i1"), (2050, "i2"), (2200, "i2")):
            recorder.event(ItemPicked("wall_e", item), b"{}", milliseconds * 1_000_000)
        recorder.settle()

    assert [(1.0, 0), (2.0, 2), (2.2, 3)] == [
        (time / 1e9, sum(marker.header.frame_id == "wall_e/base_link" for marker in array.markers))
        for time, array in messages(path, "/world/things")
    ]


@pytest.mark.parametrize("rate", [3.0, 7.0, 30.0])
def test_the_clock_is_recorded_at_any_rate(tmp_path, rate):
    """This also holds for a rate whose period is not a whole number of nanoseconds."""
    path = tmp_path / "run.mcap"
    with RecordingFile(path, reproducible=True) as file:
        simulated, sink = recorded(file, rate=rate)
        simulated(until=2.0)
        sink.close()

    assert 2 * rate == len(messages(path, "/clock"))


def test_late_joiners_of_a_played_topic_get_the_latest(record):
    """The QoS profiles have all fields of rosbag2's format, checked with a third-party parser."""
    with record().open("rb") as file:
        channels = make_reader(file).get_summary().channels.values()
    said = {channel.topic: parse_qos(channel.metadata.get("offered_qos_profiles", "")) for channel in channels}
    (markers,) = said["/world/markers"]

    assert [] == said["/clock"]
    assert (QosDurability.TRANSIENT_LOCAL, QosReliability.RELIABLE, 1) == (
        markers.durability,
        markers.reliability,
        markers.depth,
    )


def test_the_same_run_makes_the_same_file(record, tmp_path):
    """Two recordings of the same run are equal if chunks end by simulated time."""
    first = record((1.0, go(5.0, 2.0)), until=30.0, path=tmp_path / "a.mcap")
    second = record((1.0, go(5.0, 2.0)), until=30.0, path=tmp_path / "b.mcap")

    assert first.read_bytes() == second.read_bytes()


def test_mcaps_reader_finds_all_in_order(record):
    """The index is complete: as many messages as its statistics say, none earlier than the one before."""
    with record((1.0, go(5.0, 2.0)), until=60.0).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        times = [message.log_time for _, _, message in reader.iter_messages()]
        statistics = reader.get_summary().statistics

    assert (sorted(times), statistics.message_count) == (times, len(times))
    assert 1 < statistics.chunk_count


def test_what_controllers_publish_of_their_trees_is_recorded(tmp_path):
    """The payload is unchanged, on a channel of the robot's, at the time of the message before."""
    path = tmp_path / "run.mcap"
    state = {"tree_id": "patrol", "nodes": []}
    with RecordingFile(path) as file:
        recorder = Recorder(file, lambda _event: None)
        recorder.event(
            Stopped("wall_e", (1.0, 2.0)), b'{"kind":"stopped","stamp":{"sec":2,"nanosec":0}}', 2_000_000_000
        )
        recorder.tree("wall_e", state)

    with path.open("rb") as file:
        ((schema, channel, message),) = make_reader(file).iter_messages(topics=["/wall_e/_tree"])
    assert ("hmrsim/Tree", "json") == (schema.name, channel.message_encoding)
    assert (2_000_000_000, state) == (message.log_time, json.loads(message.data))


def test_where_all_robots_are_at_an_instant_is_one_message(record):
    """The poses are sampled together, and are one message on /tf."""
    times = [time for time, _ in messages(record(), "/tf")]

    assert len(set(times)) == len(times)

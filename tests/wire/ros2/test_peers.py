"""Other nodes in the domain, and the warnings about them."""

from __future__ import annotations

import logging
import queue
import time

import pytest

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import NO_HASH, Address, Endpoint, Kind, Node
from hmrsim_zenoh.ros2.peers import Peers
from hmrsim_zenoh.ros2.rejection_log import RejectionLog
from hmrsim_zenoh.ros2.type_compat import difference, distros_of, known, ros_name
from hmrsim_zenoh.wire.session import SessionOptions, open_client, open_server
from tests.patience import PATIENCE

DOMAIN = 7
NAME = "/wall_e/navigate_through_poses/_action/send_goal"
TYPE = "nav2_msgs::action::dds_::NavigateThroughPoses_SendGoal_"
JAZZY = "RIHS01_5a590fa8e9a32b7b9c838fdf5939a2fb8858d6cfd25bdf2f2e5f0f7bbb25f52b"
KILTED = "RIHS01_0fb14135a40c3900a9a184f95b2ed6966a0ffd298739cc9de7903ebc6dc06a25"
OTHER = f"RIHS01_{'ab' * 32}"
NODE = Node("/", "nav_client")


def _until(condition):
    """Wait until *holds* returns true, or fail after the patience."""
    end = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)


class Network:
    """Our session, whose peers are watched, and another session that declares tokens."""

    def __init__(self, ours, theirs, caplog):
        self.ours = ours
        self.gone = queue.Queue()
        self.served = {NAME: {(TYPE, KILTED)}}
        self.came = []
        self.peers = self.watch()
        self._session = theirs
        self._caplog = caplog
        self._tokens = []

    def watch(self, gone=None):
        return Peers(
            self.ours,
            DOMAIN,
            served=lambda name: self.served.get(name, ()),
            rejections=RejectionLog(),
            came=self.came.append,
            gone=gone or self.gone.put,
        )

    def declare(self, kind=Kind.CLIENT, name=NAME, type_=TYPE, hash_=KILTED, session=None):
        """Declare an endpoint in the other session, or in a further one; return its text and its token."""
        session = session or self._session
        ids = (0, len(self._tokens) + 1)
        text = keys.endpoint_token(DOMAIN, str(session.info.zid()), ids, NODE, Endpoint(kind, name, type_, hash_))
        return text, self.token(text, session)

    def token(self, text, session=None):
        """Declare any token, which is there until it is undeclared."""
        token = (session or self._session).liveliness().declare_token(text)
        self._tokens.append(token)
        return token

    def warned(self, count):
        """Return the logged lines, once there are that many."""
        _until(lambda: len(self._caplog.records) >= count)
        return self.told()

    def told(self):
        """Return the lines logged by the time that a token, declared now, has come and gone."""
        text, token = self.declare(name="/last")
        token.undeclare()
        while self.gone.get(timeout=PATIENCE) != keys.gid(text):
            pass
        return [record.getMessage() for record in self._caplog.records]


@pytest.fixture
def network(caplog):
    caplog.set_level(logging.WARNING, "hmrsim_zenoh")
    ours, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
    with ours, open_client(SessionOptions(connect=endpoints)) as theirs:
        made = Network(ours, theirs, caplog)
        yield made
        made.peers.close()


def test_client_of_the_same_type_is_not_reported(network):
    network.declare()

    assert [] == network.told()


def test_a_client_of_another_distribution_is_reported_with_a_remedy(network):
    network.declare(hash_=JAZZY)

    (told,) = network.warned(1)
    assert (
        f"ROS domain 7: client /nav_client is incompatible with {NAME}: its hash is {JAZZY} (jazzy), the server's "
        f"{KILTED} (kilted, lyrical, rolling); start `hmrsim run --ros2` with --ros-distro jazzy, or without "
        "--ros-distro"
    ) == told


def test_the_same_warning_comes_once(network):
    """A program may have many clients of a type."""
    network.served["/eve/x"] = {(TYPE, KILTED)}
    network.declare(hash_=JAZZY)
    network.declare(hash_=JAZZY)
    network.declare(name="/eve/x", hash_=JAZZY)
    network.peers.look(lambda _name: True)

    assert 1 == len(network.warned(1))


def test_a_client_that_waits_for_a_later_server_is_reported(network):
    network.served.clear()
    network.declare(hash_=JAZZY)
    before = network.told()
    network.served[NAME] = {(TYPE, KILTED)}
    network.peers.look(lambda _name: True)

    assert (0, 1) == (len(before), len(network.told()))


def test_a_subscriber_of_another_type_is_reported_with_the_ros_name(network):
    network.served["/wall_e/odom"] = {("nav_msgs::msg::dds_::Odometry_", OTHER)}
    network.declare(Kind.SUBSCRIBER, "/wall_e/odom", "geometry_msgs::msg::dds_::Pose_", OTHER)

    (told,) = network.warned(1)
    assert (
        "ROS domain 7: subscriber /nav_client is incompatible with /wall_e/odom: its type is geometry_msgs/msg/Pose, "
        "the server's nav_msgs/msg/Odometry; use nav_msgs/msg/Odometry"
    ) == told


def test_a_second_server_of_an_action_is_reported(network):
    network.declare()
    network.declare(Kind.SERVICE)
    network.declare(Kind.SERVICE)

    (told,) = network.warned(1)
    assert (
        f"ROS domain 7: node /nav_client serves {NAME}, too: both execute each goal of wall_e, and a client gets "
        "the reply of either; run one of them with another --ros-domain-id, or rename its robots"
    ) == told


@pytest.mark.parametrize("name", ["/get_entities", "/simulate_steps/_action/send_goal"])
def test_a_second_server_of_a_world_service_is_reported_without_a_robot(network, name):
    network.served[name] = {(TYPE, KILTED)}
    network.declare()
    network.declare(Kind.SERVICE, name)

    (told,) = network.warned(1)
    assert "both execute each goal, and a client" in told


def test_sessions_that_have_gone_do_not_count(network, monkeypatch):
    """Each ``ros2`` command has a session, and the number of sessions is limited."""
    monkeypatch.setattr("hmrsim_zenoh.ros2.peers._MAX_SESSIONS", 1)
    others = f"@ros2_lv/{DOMAIN}/{'ab' * 16}/0/1/SC/%/%/x/%x/a::srv::dds_::X_/{OTHER}/::,10:,:,:,,"
    for token in [network.token(text) for text in (others, others.replace("/0/1/", "/0/2/"))]:
        token.undeclare()
    network.told()
    network.declare()
    network.declare(Kind.SERVICE)

    assert 1 == len(network.warned(1))


def test_names_that_are_not_new_are_not_looked_at_again(network):
    """Otherwise each robot that joins a large fleet would cost a scan of all clients."""
    network.declare()
    network.declare(name="/eve/x")
    network.told()
    network.came.clear()
    network.peers.look(lambda name: name.startswith("/eve/"))

    assert ["/eve/x"] == network.came


def test_a_client_is_named_by_its_node_or_its_shortened_id(network):
    text, _ = network.declare()
    network.told()

    assert ["client /nav_client", "client 10ffffff", "client nonsense", "a client without an id"] == [
        network.peers.name_of(who) for who in (keys.gid(text).hex(), "10" + "f" * 30, "nonsense", "")
    ]


def test_request_of_a_reported_client_is_not_reported_again(network):
    text, _ = network.declare(hash_=JAZZY)
    network.told()
    network.peers.wrong_hash(Address(NAME, TYPE, JAZZY), keys.gid(text).hex())

    assert 1 == len(network.warned(1))


def test_a_client_without_a_token_is_reported_at_its_first_request(network):
    network.peers.wrong_hash(Address(NAME, TYPE, OTHER), "10.0.0.7")
    network.peers.wrong_hash(Address(NAME, TYPE, OTHER), "10.0.0.7")

    (told,) = network.warned(1)
    assert f"{OTHER} (of an unknown distribution)" in told
    assert told.endswith("build the client's workspace against nav2_msgs of kilted, lyrical or rolling")


def test_the_id_of_a_client_that_goes_is_the_hash_of_its_declared_token(network):
    text, token = network.declare()
    token.undeclare()
    with_memory = network.token(f"{text}/backends:cpu:")
    with_memory.undeclare()

    assert [keys.gid(text), keys.gid(f"{text}/backends:cpu:")] == [network.gone.get(timeout=PATIENCE) for _ in range(2)]


def test_only_other_clients_are_reported_as_gone(network):
    for kind, session in ((Kind.SUBSCRIBER, None), (Kind.SERVICE, None), (Kind.CLIENT, network.ours)):
        network.declare(kind, name="/x", session=session)[1].undeclare()
    text, token = network.declare()
    token.undeclare()

    assert keys.gid(text) == network.gone.get(timeout=PATIENCE)


def test_a_second_clock_is_reported_once(network):
    for name in ("/clock", "/clock", "/other"):
        network.declare(Kind.PUBLISHER, name=name)

    (line,) = network.warned(1)
    assert "publishes /clock, too" in line
    assert "--ros-domain-id" in line


def test_tokens_from_before_the_watch_are_seen(network):
    network.declare(hash_=JAZZY)
    gone = queue.Queue()
    later = network.watch(gone.put)
    text, token = network.declare()
    token.undeclare()

    assert keys.gid(text) == gone.get(timeout=PATIENCE)
    assert 2 == len(network.warned(2))
    later.close()


def test_names_of_clients_and_subscribers_are_reported(network):
    """A large fleet declares their servers only when asked."""
    network.declare()
    network.declare(Kind.SUBSCRIBER, "/wall_e/odom")
    network.declare(Kind.PUBLISHER, "/wall_e/cmd_vel")
    network.told()
    _until(lambda: len({*network.came}) > 2)  # Zenoh may bring tokens in another order.

    assert {NAME, "/wall_e/odom", "/last"} == {*network.came}


def test_own_tokens_are_ignored(network):
    network.declare(hash_=JAZZY, session=network.ours)

    assert [] == network.told()


@pytest.mark.parametrize(
    "tail", ["/1/2/3/SC", "/s/0/0/NN/%/%/n/more", "/s/0/1/SC/%/%/n/%a/t/h", f"/1/2/3/SC{'/ü' * 300}"]
)
def test_a_malformed_token_is_logged_and_skipped(network, tail):
    text = f"@ros2_lv/{DOMAIN}{tail}"
    network.token(text)
    (told,) = network.warned(1)

    assert f"ROS domain 7: ignored {text[:200]!r}, which is not a token of rmw_zenoh" == told


def test_thousands_of_malformed_tokens_do_not_fill_the_log(network):
    for number in range(50):
        network.token(f"@ros2_lv/{DOMAIN}/{number}/0/1/SC")

    assert 20 == len(network.warned(20))


def test_thousands_of_invented_sessions_do_not_fill_the_log(network):
    for number in range(50):
        ids = (0, number)
        network.token(keys.endpoint_token(DOMAIN, f"{number:x}", ids, NODE, Endpoint(Kind.CLIENT, NAME, TYPE, JAZZY)))

    assert 20 == len(network.warned(20))


def test_distributions_can_share_a_type():
    assert {JAZZY: ("jazzy",), KILTED: ("kilted", "lyrical", "rolling")} == known()[TYPE]


def test_a_distribution_is_served_if_all_its_types_are():
    feedback = "nav2_msgs::action::dds_::NavigateThroughPoses_FeedbackMessage_"
    (kilteds,) = (hash_ for hash_, distros in known()[feedback].items() if distros == ("kilted",))

    assert ("kilted", "lyrical", "rolling") == distros_of({(TYPE, KILTED)})
    assert ("kilted",) == distros_of({(TYPE, KILTED), (feedback, kilteds), ("x", "y")})
    assert () == distros_of({("x", "y")})


def test_humble_is_not_served():
    """Its keys have no hash."""
    remedy = difference((TYPE, NO_HASH), [(TYPE, JAZZY)]).remedy

    assert "humble is not supported; use jazzy, kilted, lyrical or rolling" == remedy


@pytest.mark.parametrize(
    ("type_", "name"), [(TYPE, "nav2_msgs/action/NavigateThroughPoses_SendGoal"), ("", ""), ("a::b", "a::b")]
)
def test_types_are_shown_as_ros_tools_show_them(type_, name):
    assert name == ros_name(type_)

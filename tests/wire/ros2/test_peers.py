"""Other nodes in our domain, and the warnings about them."""

from __future__ import annotations

import logging
import queue
import time

import pytest

from hmrsim_zenoh.ros2 import keys
from hmrsim_zenoh.ros2.keys import NO_HASH, Address, Endpoint, Kind, Node
from hmrsim_zenoh.ros2.peers import Peers
from hmrsim_zenoh.ros2.requests.requests import RejectionLog
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
    """Wait until something holds, or patience has an end."""
    end = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < end:
        time.sleep(0.01)


class Network:
    """Our session with peers watched on it, and another's that declares tokens."""

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
        """Return peers that are watched."""
        return Peers(
            self.ours,
            DOMAIN,
            served=lambda name: self.served.get(name, ()),
            rejections=RejectionLog(),
            came=self.came.append,
            gone=gone or self.gone.put,
        )

    def declare(self, kind=Kind.CLIENT, name=NAME, type_=TYPE, hash_=KILTED, session=None):
        """Declare an endpoint in the other's session, or in another one; return its text and its token."""
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
        """Return what was logged, once it is that many lines."""
        _until(lambda: len(self._caplog.records) >= count)
        return self.told()

    def told(self):
        """Return what was logged by the time that a token, declared now, has come and gone."""
        text, token = self.declare(name="/last")
        token.undeclare()
        while self.gone.get(timeout=PATIENCE) != keys.gid(text):
            pass
        return [record.getMessage() for record in self._caplog.records]


@pytest.fixture
def network(caplog):
    """Return a network of two sessions."""
    caplog.set_level(logging.WARNING, "hmrsim_zenoh")
    ours, endpoints = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))
    with ours, open_client(SessionOptions(connect=endpoints)) as theirs:
        made = Network(ours, theirs, caplog)
        yield made
        made.peers.close()


def test_client_of_the_same_type_is_not_reported(network):
    """A client with the same type is not logged."""
    network.declare()

    assert [] == network.told()


def test_client_of_another_distribution(network):
    """The warning has both hashes, the nodes, and how to serve the client."""
    network.declare(hash_=JAZZY)

    (told,) = network.warned(1)
    assert (
        f"ROS domain 7: client /nav_client is incompatible with {NAME}: its hash is {JAZZY} (jazzy), the server's "
        f"{KILTED} (kilted, lyrical); start `hmrsim run --ros2` with --ros-distro jazzy, or without --ros-distro"
    ) == told


def test_the_same_warning_comes_once(network):
    """A program with many clients of a type causes one warning."""
    network.served["/eve/x"] = {(TYPE, KILTED)}
    network.declare(hash_=JAZZY)
    network.declare(hash_=JAZZY)
    network.declare(name="/eve/x", hash_=JAZZY)
    network.peers.look(lambda _name: True)

    assert 1 == len(network.warned(1))


def test_a_client_from_before_the_name_is_reported_on_a_second_look(network):
    """A client may have waited for a server before that was there."""
    network.served.clear()
    network.declare(hash_=JAZZY)
    before = network.told()
    network.served[NAME] = {(TYPE, KILTED)}
    network.peers.look(lambda _name: True)

    assert (0, 1) == (len(before), len(network.told()))


def test_subscriber_of_another_type(network):
    """A subscriber is reported likewise; another type is named as ROS names it."""
    network.served["/wall_e/odom"] = {("nav_msgs::msg::dds_::Odometry_", OTHER)}
    network.declare(Kind.SUBSCRIBER, "/wall_e/odom", "geometry_msgs::msg::dds_::Pose_", OTHER)

    (told,) = network.warned(1)
    assert (
        "ROS domain 7: subscriber /nav_client is incompatible with /wall_e/odom: its type is geometry_msgs/msg/Pose, "
        "the server's nav_msgs/msg/Odometry; use nav_msgs/msg/Odometry"
    ) == told


def test_second_server_of_a_name(network):
    """Two simulators on one domain, or a simulator and a robot, get in each other's way."""
    network.declare()
    network.declare(Kind.SERVICE)
    network.declare(Kind.SERVICE)

    (told,) = network.warned(1)
    assert (
        f"ROS domain 7: node /nav_client serves {NAME}, too: both execute each goal of wall_e, and a client gets "
        "the reply of either; run one of them with another --ros-domain-id, or rename its robots"
    ) == told


@pytest.mark.parametrize("name", ["/get_entities", "/simulate_steps/_action/send_goal"])
def test_second_server_of_the_world(network, name):
    """What belongs to the world has no robot's name in it."""
    network.served[name] = {(TYPE, KILTED)}
    network.declare()
    network.declare(Kind.SERVICE, name)

    (told,) = network.warned(1)
    assert "both execute each goal, and a client" in told


def test_sessions_that_have_gone_do_not_count(network, monkeypatch):
    """As each ``ros2`` command has a session of its own: their number is limited."""
    monkeypatch.setattr("hmrsim_zenoh.ros2.peers._MAX_SESSIONS", 1)
    others = f"@ros2_lv/{DOMAIN}/{'ab' * 16}/0/1/SC/%/%/x/%x/a::srv::dds_::X_/{OTHER}/::,10:,:,:,,"
    for token in [network.token(text) for text in (others, others.replace("/0/1/", "/0/2/"))]:
        token.undeclare()
    network.told()
    network.declare()
    network.declare(Kind.SERVICE)

    assert 1 == len(network.warned(1))


def test_names_that_are_not_new_are_not_looked_at_again(network):
    """Each robot that comes to a large fleet would take time for all clients of the others."""
    network.declare()
    network.declare(name="/eve/x")
    network.told()
    network.came.clear()
    network.peers.look(lambda name: name.startswith("/eve/"))

    assert ["/eve/x"] == network.came


def test_name_of_a_client(network):
    """It is its node's if its token is known, else its id, shortened."""
    text, _ = network.declare()
    network.told()

    assert ["client /nav_client", "client 10ffffff", "client nonsense", "a client without an id"] == [
        network.peers.name_of(who) for who in (keys.gid(text).hex(), "10" + "f" * 30, "nonsense", "")
    ]


def test_request_of_a_reported_client_is_not_reported_again(network):
    """A client that was reported by its token is not reported again by its request."""
    text, _ = network.declare(hash_=JAZZY)
    network.told()
    network.peers.wrong_hash(Address(NAME, TYPE, JAZZY), keys.gid(text).hex())

    assert 1 == len(network.warned(1))


def test_request_of_a_client_without_a_token(network):
    """A client without a token is reported once, when it sends a request."""
    network.peers.wrong_hash(Address(NAME, TYPE, OTHER), "10.0.0.7")
    network.peers.wrong_hash(Address(NAME, TYPE, OTHER), "10.0.0.7")

    (told,) = network.warned(1)
    assert f"{OTHER} (of an unknown distribution)" in told
    assert told.endswith("build the client's workspace against nav2_msgs of kilted or lyrical")


def test_id_of_a_client_that_goes(network):
    """It is the hash of the token as it was declared, chunk 14 and all."""
    text, token = network.declare()
    token.undeclare()
    with_memory = network.token(f"{text}/backends:cpu:")
    with_memory.undeclare()

    assert [keys.gid(text), keys.gid(f"{text}/backends:cpu:")] == [network.gone.get(timeout=PATIENCE) for _ in range(2)]


def test_other_endpoints_go_unnoticed(network):
    """Subscribers and servers, and clients of our own, wait for no result."""
    for kind, session in ((Kind.SUBSCRIBER, None), (Kind.SERVICE, None), (Kind.CLIENT, network.ours)):
        network.declare(kind, name="/x", session=session)[1].undeclare()
    text, token = network.declare()
    token.undeclare()

    assert keys.gid(text) == network.gone.get(timeout=PATIENCE)


def test_tokens_from_before_the_watch_are_seen(network):
    """Tokens that are older than the watch count, too."""
    network.declare(hash_=JAZZY)
    gone = queue.Queue()
    later = network.watch(gone.put)
    text, token = network.declare()
    token.undeclare()

    assert keys.gid(text) == gone.get(timeout=PATIENCE)
    assert 2 == len(network.warned(2))
    later.close()


def test_names_of_clients_and_subscribers_are_reported(network):
    """So that what they look for is declared, in a fleet that does not declare all."""
    network.declare()
    network.declare(Kind.SUBSCRIBER, "/wall_e/odom")
    network.declare(Kind.PUBLISHER, "/wall_e/cmd_vel")
    network.told()
    _until(lambda: len({*network.came}) > 2)  # Zenoh may bring tokens in another order.

    assert {NAME, "/wall_e/odom", "/last"} == {*network.came}


def test_own_tokens_are_ignored(network):
    """The simulator does not warn of itself."""
    network.declare(hash_=JAZZY, session=network.ours)

    assert [] == network.told()


@pytest.mark.parametrize(
    "tail", ["/1/2/3/SC", "/s/0/0/NN/%/%/n/more", "/s/0/1/SC/%/%/n/%a/t/h", f"/1/2/3/SC{'/ü' * 300}"]
)
def test_garbage_is_logged_and_ignored(network, tail):
    """One bad token is logged in one line, and the next good one is read."""
    text = f"@ros2_lv/{DOMAIN}{tail}"
    network.token(text)
    (told,) = network.warned(1)

    assert f"ROS domain 7: ignored {text[:200]!r}, which is not a token of rmw_zenoh" == told


def test_much_garbage_is_not_logged(network):
    """A client that declares thousands of them does not fill the log."""
    for number in range(50):
        network.token(f"@ros2_lv/{DOMAIN}/{number}/0/1/SC")

    assert 20 == len(network.warned(20))


def test_invented_sessions_are_not_logged(network):
    """A client that declares incompatible ones in the name of ever new sessions does not fill the log either."""
    for number in range(50):
        ids = (0, number)
        network.token(keys.endpoint_token(DOMAIN, f"{number:x}", ids, NODE, Endpoint(Kind.CLIENT, NAME, TYPE, JAZZY)))

    assert 20 == len(network.warned(20))


def test_hashes_of_a_type():
    """Two distributions may have the same type."""
    assert {JAZZY: ("jazzy",), KILTED: ("kilted", "lyrical")} == known()[TYPE]


def test_distributions_that_are_spoken():
    """A distribution is spoken where all its types are."""
    feedback = "nav2_msgs::action::dds_::NavigateThroughPoses_FeedbackMessage_"
    (kilteds,) = (hash_ for hash_, distros in known()[feedback].items() if distros == ("kilted",))

    assert ("kilted", "lyrical") == distros_of({(TYPE, KILTED)})
    assert ("kilted",) == distros_of({(TYPE, KILTED), (feedback, kilteds), ("x", "y")})
    assert () == distros_of({("x", "y")})


def test_humble_is_not_served():
    """Its keys have no hash at all."""
    assert (
        "humble is not supported; use jazzy, kilted or lyrical" == difference((TYPE, NO_HASH), [(TYPE, JAZZY)]).remedy
    )


@pytest.mark.parametrize(
    ("type_", "name"), [(TYPE, "nav2_msgs/action/NavigateThroughPoses_SendGoal"), ("", ""), ("a::b", "a::b")]
)
def test_type_as_ros_names_it(type_, name):
    """A type is shown as ROS's tools do; what is none is shown as it is."""
    assert name == ros_name(type_)

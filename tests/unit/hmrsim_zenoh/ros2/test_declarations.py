"""Declarations on the network: contents, order and end."""

from __future__ import annotations

import threading
from collections import Counter
from types import SimpleNamespace
from typing import Any

import pytest
import zenoh

from hmrsim.actions import registry as actions
from hmrsim.services import registry as services
from hmrsim_zenoh.ros2.keys import Endpoint, gid, read_token
from hmrsim_zenoh.ros2.names import Names
from hmrsim_zenoh.ros2.publishing.declarations import Declarations
from hmrsim_zenoh.ros2.publishing.endpoints import Endpoints
from hmrsim_zenoh.ros2.publishing.parts import Parts
from hmrsim_zenoh.ros2.wires import RmwZenoh, Ros2Dds, Wire
from tests.patience import PATIENCE

BOTH = Names({"wall_e": ["navigate_to_pose", "wait"], "eve": ["navigate_to_pose"]})
ONE = Names({"wall_e": ["navigate_to_pose", "wait"]})


class Network:
    """A session and its publishers, which record all operations in order.

    Attributes:
        said: Pairs of what was done and to what.
        there: The tokens that are declared.
        gids: The ids with which publishers were opened, by name.
        refused: Part of tokens that can't be declared.
        stuck: Part of tokens that can't be undeclared.
    """

    def __init__(self) -> None:
        self.said: list[tuple[str, str]] = []
        self.there: list[str] = []
        self.gids: dict[str, bytes | None] = {}
        self.refused = self.stuck = "nothing"
        self.error: Exception = zenoh.ZError("no")
        self.info = SimpleNamespace(zid=lambda: "abc")

    def liveliness(self) -> Network:
        """Return the object that declares tokens."""
        return self

    def declare_token(self, token: str) -> Any:
        """Record that a token was declared."""
        if self.refused in token:
            raise self.error
        self.said.append(("token", token))
        self.there.append(token)
        return SimpleNamespace(undeclare=lambda: self._undeclare(token))

    def open(self, endpoint: Endpoint, gid: bytes | None) -> None:
        """Record that a publisher was opened."""
        self.said.append(("open", endpoint.name))
        self.gids[endpoint.name] = gid

    def close(self, endpoint: Endpoint) -> None:
        """Record that a publisher was closed."""
        self.said.append(("close", endpoint.name))

    def _undeclare(self, token: str) -> None:
        if self.stuck in token:
            raise self.error
        self.said.append(("gone", token))
        self.there.remove(token)

    def names(self) -> list[str]:
        """Return the names of the nodes and endpoints with tokens."""
        read = [read_token(token) for token in self.there]
        return [each.endpoint.name if each.endpoint else each.node.full_name for each in read if each]


def declared(network: Network, *followed: Names, wire: Wire | None = None) -> Declarations:
    """Return declarations that have followed several names in turn."""
    wire = wire or RmwZenoh(distros=("jazzy",))
    session: Any = network
    declarations = Declarations(session, wire, Endpoints(wire, actions(), services()).of, session)
    for names in followed:
        declarations._apply(Parts(names).all)
    return declarations


def token_of(network: Network, name: str) -> str:
    """Return the token of an endpoint."""
    (found,) = [
        token for token in network.there if (read := read_token(token)) and read.endpoint and read.endpoint.name == name
    ]
    return found


def test_publisher_before_its_token() -> None:
    """A node that discovers a publisher may query it for the last message at once."""
    network = Network()
    declared(network, ONE)

    status = "/wall_e/navigate_to_pose/_action/status"
    order = network.said.index(("open", status)), network.said.index(("token", token_of(network, status)))
    assert order[0] + 1 == order[1]


def test_publisher_s_id_is_that_of_its_token() -> None:
    """Messages have the id by which ROS's tools identify the publisher."""
    network = Network()
    declared(network, ONE)

    assert gid(token_of(network, "/wall_e/odom")) == network.gids["/wall_e/odom"]


def test_node_before_what_it_has() -> None:
    """A node has one token, which comes before those of its endpoints."""
    network = Network()
    declared(network, BOTH)

    assert 1 == network.names().count("/wall_e/bt_navigator")
    found = [name for name in network.names() if name.startswith("/wall_e/")]
    assert ["/wall_e/bt_navigator", "/wall_e/navigate_to_pose/_action/send_goal"] == found[:2]


def test_all_can_be_driven_first() -> None:
    """All robots' navigate_to_pose comes before any other endpoint."""
    network = Network()
    declared(network, BOTH)

    names = network.names()
    assert names.index("/eve/navigate_to_pose/_action/status") < names.index("/wall_e/wait/_action/send_goal")


def test_tokens_are_the_same_in_each_run() -> None:
    """Ids are counted, so two runs of the same world have the same tokens."""
    first, second = Network(), Network()
    declared(first, BOTH)
    declared(second, BOTH)

    assert first.there == second.there


def test_ids_are_counted_once() -> None:
    """No two endpoints have the same number."""
    network = Network()
    declared(network, BOTH)

    numbers = [token.split("/")[4] for token in network.there if "/NN/" not in token]
    assert len(numbers) == len(set(numbers))


def test_nodes_of_some_robots_share_a_number() -> None:
    """Tokens of 32 robots share their beginning, which saves Zenoh time; those of a robot always do."""
    network = Network()
    declared(network, Names({f"r{number}": ["navigate_to_pose", "wait"] for number in range(70)}))

    pairs = {(token.split("/")[7], token.split("/")[3]) for token in network.there}
    assert 71 == len(pairs)
    assert [7, 32, 32] == sorted(Counter(number for _, number in pairs).values())


def test_robot_that_goes() -> None:
    """All declarations of a gone robot are removed, and no others."""
    network = Network()
    declared(network, BOTH, ONE)

    assert not [name for name in network.names() if name.startswith("/eve")]
    assert not [token for what, token in network.said if what == "gone" and "wall_e" in token]
    assert ("close", "/eve/odom") in network.said


def test_robot_that_comes() -> None:
    """The tokens of a later robot are declared without changing existing ones."""
    network = Network()
    declarations = declared(network, ONE)
    before = len(network.said)
    declarations._apply(Parts(BOTH).all)

    told = [token for what, token in network.said[before:] if what != "open"]
    assert {"%eve"} == {token.split("/")[7] for token in told}


def test_no_tokens_where_the_wire_has_none() -> None:
    """With zenoh-bridge-ros2dds there are no tokens, and publications have no sender."""
    network = Network()
    declared(network, ONE, wire=Ros2Dds())

    assert [] == network.there
    assert network.gids["/wall_e/odom"] is None


def test_one_that_fails(caplog: pytest.LogCaptureFixture) -> None:
    """A failed declaration is logged, and the others are still declared."""
    network = Network()
    network.refused = "%wall_e%odom/"
    declared(network, ONE)

    assert "/wall_e/odom" not in network.names()
    assert "/wall_e/amcl_pose" in network.names()
    assert "/wall_e/odom could not be declared to ROS: no" in caplog.text


def test_outlet_of_one_that_fails() -> None:
    """A publisher whose token can't be declared is closed."""
    network = Network()
    network.refused = "%wall_e%odom/"
    declared(network, ONE)

    assert [("open", "/wall_e/odom"), ("close", "/wall_e/odom")] == [
        each for each in network.said if each[1] == "/wall_e/odom"
    ]


def test_node_of_one_that_fails() -> None:
    """A failed declaration keeps no node: the nodes go with the robot."""
    network = Network()
    network.refused = "%eve%odom/"
    declared(network, BOTH, ONE)

    assert not [name for name in network.names() if name.startswith("/eve")]


@pytest.mark.parametrize("error", [zenoh.ZError("no"), RuntimeError("no")])
def test_failure_to_undeclare_is_logged(caplog: pytest.LogCaptureFixture, error: Exception) -> None:
    """A token that can't be undeclared is logged, and others are still changed."""
    network = Network()
    declarations = declared(network, BOTH)
    network.stuck, network.error = "%eve%odom/", error
    declarations._apply(Parts(Names({"cart": ["navigate_to_pose"]})).all)

    assert ["/eve/odom"] == [name for name in network.names() if name.startswith(("/eve", "/wall_e"))]
    assert ("close", "/eve/odom") in network.said
    assert "/cart/odom" in network.names()
    assert "/eve/odom could not be undeclared, and ROS may still see it: no" in caplog.text


def test_end() -> None:
    """The thread ends before the session is closed."""
    network = Network()
    declarations = declared(network)
    declarations.want(Parts(BOTH).all)
    declarations.close()

    assert declarations._thread is not None
    assert not declarations._thread.is_alive()


def test_session_that_is_closed_during_a_declaration(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A declaration that fails at the end is not logged, and the thread ends."""
    monkeypatch.setattr("hmrsim_zenoh.ros2.publishing.declarations._JOIN_SECONDS", 0.01)
    network = Network()
    begun, closed = threading.Event(), threading.Event()

    def declare_token(token: str) -> None:
        begun.set()
        closed.wait(PATIENCE)
        raise zenoh.ZError(f"session closed, and {token} not declared")

    monkeypatch.setattr(network, "declare_token", declare_token)
    declarations = declared(network)
    declarations.want(Parts(ONE).all)
    assert begun.wait(PATIENCE)
    declarations.close()
    closed.set()
    assert declarations._thread is not None
    declarations._thread.join(PATIENCE)

    assert not declarations._thread.is_alive()
    assert "" == caplog.text


def test_what_is_wanted_by_now() -> None:
    """A newer request takes effect at once, not after all earlier declarations."""
    network = Network()
    declarations = declared(network)
    declarations._wanted = Parts(ONE).all

    declarations._apply(Parts(BOTH).all)

    assert [] == network.there


def test_what_is_asked_for_while_others_are_declared() -> None:
    """A part can be requested before the busy thread has seen it."""
    network = Network()
    declarations = declared(network, ONE)
    declarations._wanted = (parts := Parts(BOTH)).all, 0
    asked = parts.of("/eve/navigate_to_pose/_action/status")
    assert asked is not None
    declarations.ask(asked)
    declarations._declare_requested()
    before = network.names()
    wanted = declarations._next()
    assert wanted is not None
    declarations._apply(*wanted)
    declarations._declare_requested()

    assert "/eve/navigate_to_pose/_action/status" not in before
    assert "/eve/navigate_to_pose/_action/status" in network.names()

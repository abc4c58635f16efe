"""Keys, tokens and ids are spelled as rmw_zenoh spells them."""

from __future__ import annotations

import pytest

from hmrsim_zenoh.ros2.keys import (
    LATCHED_QOS,
    Address,
    Endpoint,
    Kind,
    Node,
    Token,
    endpoint_token,
    gid,
    key,
    node_token,
    read_key,
    read_token,
)
from hmrsim_zenoh.ros2.wires import Attachment, read_attachment

SESSION = "5e65be91e5062821801d353a23e9dbeb"
STATUS = Endpoint(
    Kind.PUBLISHER,
    "/wall_e/navigate_to_pose/_action/status",
    "action_msgs::msg::dds_::GoalStatusArray_",
    "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
    LATCHED_QOS,
)
NAVIGATOR = Node("/wall_e", "bt_navigator")
STATUS_TOKEN = (
    "@ros2_lv/0/5e65be91e5062821801d353a23e9dbeb/0/2/MP/%/%wall_e/bt_navigator/"
    "%wall_e%navigate_to_pose%_action%status/action_msgs::msg::dds_::GoalStatusArray_/"
    "RIHS01_6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e/:1:,1:,:,:,,"
)


def test_endpoint_token() -> None:
    """A publisher's token is one that rmw_zenoh's own parser accepts."""
    assert STATUS_TOKEN == endpoint_token(0, SESSION, (0, 2), NAVIGATOR, STATUS)


def test_node_token_of_the_root_namespace() -> None:
    """An empty namespace is a percent sign."""
    assert f"@ros2_lv/7/{SESSION}/3/3/NN/%/%/hmrsim" == node_token(7, SESSION, 3, Node("/", "hmrsim"))


def test_token_is_read_back() -> None:
    """A parsed token has the values that it was created from."""
    assert Token(SESSION, NAVIGATOR, STATUS) == read_token(STATUS_TOKEN)


def test_token_of_a_node_is_read_back() -> None:
    """A node's token has no endpoint."""
    node = Node("/", "hmrsim")

    assert Token(SESSION, node) == read_token(node_token(0, SESSION, 1, node))


def test_token_with_memory_is_read() -> None:
    """A token with the fourteenth chunk of newer distributions is not ignored."""
    assert Token(SESSION, NAVIGATOR, STATUS) == read_token(f"{STATUS_TOKEN}/backends:cpu:")


@pytest.mark.parametrize("text", ["", "a/b", "@ros2_lv/0/s/0/0/XX/%/%/n", "@ros2_lv/0/s/0/0/NN/%/%/n/x", "@ros2_lv"])
def test_malformed_tokens(text: str) -> None:
    """Other keys are not tokens."""
    assert read_token(text) is None


def test_key_is_read_back() -> None:
    """A key has the domain, the name without its first slash, the type and the hash."""
    text = key(3, "/wall_e/odom", "nav_msgs::msg::dds_::Odometry_", "RIHS01_00")

    assert text == "3/wall_e/odom/nav_msgs::msg::dds_::Odometry_/RIHS01_00"
    assert Address("/wall_e/odom", "nav_msgs::msg::dds_::Odometry_", "RIHS01_00") == read_key(3, text)


@pytest.mark.parametrize("text", ["3/a/b", "", "4/a/b/c", "3//b/c"])
def test_malformed_keys(text: str) -> None:
    """A key of another domain, or with missing parts, is not parsed."""
    assert read_key(3, text) is None


def test_attachment() -> None:
    """The attachment of a publisher's first message equals rmw_zenoh's, with the gid of its token."""
    expected = "010000000000000015cd853dfe9c971710b27116487bb0cd3f30985f833c5fc05a"

    assert expected == Attachment(1, 1700000000123456789, gid(STATUS_TOKEN)).to_bytes().hex()


@pytest.mark.parametrize("data", [b"", bytes(32), bytes(33), bytes(34)])
def test_malformed_attachments(data: bytes) -> None:
    """Attachments and ids of other lengths are rejected."""
    with pytest.raises(ValueError, match="rmw_zenoh's has"):
        read_attachment(data)

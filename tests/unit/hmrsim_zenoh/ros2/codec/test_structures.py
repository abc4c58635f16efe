"""The models have the hashes of ROS's own types, in each distribution.

``rihs01.json`` holds the hashes by the distributions that have them, also of the types that ROS derives.
They come from ROS's generator, and some from `ros2 topic info -v` on other machines.
It has none of some packages (moveit_msgs/msg, shape_msgs and others).
A wrong field there changes the hash of the action that nests it: these are checked through Pickup and Place.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim_zenoh.ros2.codec.structures import structure
from hmrsim_zenoh.ros2.codec.types import DISTROS
from tests.ros_types import messages, structures

TABLE: dict[str, dict[str, str]] = json.loads((Path(__file__).parent / "rihs01.json").read_text())
HASHES = {
    (distro, ros_type): expected
    for distros, hashes in TABLE.items()
    for distro in distros.split()
    for ros_type, expected in hashes.items()
}

# The table has few types of these packages.
WITHOUT_HASHES = {
    *("simulation_interfaces", "vision_msgs", "tf2_msgs", "hmrsim_msgs"),
    "type_description_interfaces",  # GetTypeDescription nests all of its types
}


def checked_types() -> set[str]:
    """Return the types in the table and all that Pickup and Place nest."""
    actions = (Pickup.Goal, Pickup.Result, Place.Goal, Place.Result)
    nested = [one for cls in actions for one in structure(cls).describe()["referenced_type_descriptions"]]
    return {*(name for _, name in HASHES), *(one["type_name"] for one in nested)}


@pytest.mark.parametrize("distro", DISTROS)
def test_hashes_are_ros(distro: str) -> None:
    """The types in the table have the hashes that are in the table."""
    expected = {name: found for (of, name), found in HASHES.items() if of == distro}

    assert expected == {name: structures(distro)[name].hash() for name in expected}


def test_every_hash_is_checked() -> None:
    """Each message is in the table, or nested in one that is."""
    unchecked = messages().keys() - checked_types()

    assert set() == {name for name in unchecked if name.partition("/")[0] not in WITHOUT_HASHES}


@pytest.mark.parametrize("distro", DISTROS)
def test_every_distribution_has_all_actions(distro: str) -> None:
    """The table has the same actions for all distributions."""
    expected = {name for has, name in HASHES if has == "kilted" and "/action/" in name}

    assert expected == {name for has, name in HASHES if has == distro and "/action/" in name}

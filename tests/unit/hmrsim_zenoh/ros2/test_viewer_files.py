"""The shipped configurations of RViz and Foxglove show topics that the simulator has."""

from __future__ import annotations

import json
from pathlib import Path

import yaml

from hmrsim_zenoh.ros2.publishing.endpoints import TOPICS

FOLDER = Path(__file__).parents[4] / "examples" / "viewers"


def topics_in(value):
    """Return the topics of an RViz configuration."""
    if isinstance(value, dict):
        own = [value["Value"]] if "Durability Policy" in value else []
        return own + [topic for inner in value.values() for topic in topics_in(inner)]
    return [topic for inner in value for topic in topics_in(inner)] if isinstance(value, list) else []


def test_rviz():
    topics = topics_in(yaml.safe_load((FOLDER / "hmrsim.rviz").read_text()))

    assert "goal_pose" in topics
    assert TOPICS.keys() > {topic.removeprefix("/") for topic in topics}


def test_foxglove():
    panels = json.loads((FOLDER / "foxglove.json").read_text())["configById"]
    shown = panels["3D!map"]
    topics = [*shown["topics"], shown["publish"]["poseTopic"], shown["publish"]["poseEstimateTopic"]]

    assert TOPICS.keys() > {topic.removeprefix("/wall_e").removeprefix("/") for topic in topics}

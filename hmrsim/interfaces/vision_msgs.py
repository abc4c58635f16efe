"""The messages of object detection."""

from __future__ import annotations

from pydantic import Field

from hmrsim.interfaces.geometry_msgs import Pose, PoseWithCovariance, Vector3
from hmrsim.interfaces.message import Float64, Message, String
from hmrsim.interfaces.std_msgs import Header


class ObjectHypothesis(Message):
    """A class of object and the confidence, from 0 to 1."""

    class_id: String = ""
    score: Float64 = 0.0


class ObjectHypothesisWithPose(Message):
    """A class of object with its pose."""

    hypothesis: ObjectHypothesis = Field(default_factory=ObjectHypothesis)
    pose: PoseWithCovariance = Field(default_factory=PoseWithCovariance)


class BoundingBox3D(Message):
    """A box by its center and its size."""

    center: Pose = Field(default_factory=Pose)
    size: Vector3 = Field(default_factory=Vector3)


class Detection3D(Message):
    """One detected object; *id* is the same in all messages."""

    header: Header = Field(default_factory=Header)
    results: list[ObjectHypothesisWithPose] = Field(default_factory=list)
    bbox: BoundingBox3D = Field(default_factory=BoundingBox3D)
    id: String = ""


class Detection3DArray(Message):
    """All objects that were detected at once."""

    header: Header = Field(default_factory=Header)
    detections: list[Detection3D] = Field(default_factory=list)

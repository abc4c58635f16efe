"""Nav2's actions that cut and join paths."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.ports import DOUBLE, FINITE, INT, PATH, POSE, input_port, output_port, pose_stamped
from bt_controller.nodes import Family
from bt_controller.nodes.located import BASE_FRAME, Located
from bt_controller.nodes.paths import Trail, length_of, part_of, point_of
from hmrsim.geometry import SAME_PLACE, heading
from hmrsim.interfaces.nav_msgs import Path

_NONE = Path()


class TruncatePath(Leaf):
    """Puts a path on ``output_path`` without its last part, ``distance`` long; its last pose faces the goal."""

    INPUTS: ClassVar = {
        "input_path": input_port(PATH, "The path", required=False),
        "distance": input_port(FINITE, "How much to leave out, in the world's unit of length", default=1.0),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "What is left of it")}

    def update(self) -> Status:
        """Cut the path."""
        path = self.read("input_path") or _NONE
        if path.poses:
            end = path.poses[-1]
            path = part_of(path, 0.0, max(0.0, length_of(path) - self.read("distance")))
            x, y = point_of(path.poses[-1])
            if math.dist((x, y), point_of(end)) > SAME_PLACE:
                faced = pose_stamped(x, y, heading((x, y), point_of(end)))
                last = faced.model_copy(update={"header": end.header})
                path = Path(header=path.header, poses=[*path.poses[:-1], last])
        self.write("output_path", path)
        return Status.SUCCESS


class TruncatePathLocal(Located, Leaf):
    """Puts the part of a path on ``output_path`` that is around the robot.

    It begins ``distance_backward`` before the point of the path that is closest to the robot, or to ``pose``, and
    ends ``distance_forward`` after it, or with the path if that is negative. The closest point is looked for on the
    whole path, or only so far after the last one as ``max_robot_pose_search_dist`` says. Distances are along the
    path, in the world's unit of length.
    """

    INPUTS: ClassVar = {
        "input_path": input_port(PATH, "The path", required=False),
        "distance_forward": input_port(FINITE, "How much of it after the robot; negative for all", default=8.0),
        "distance_backward": input_port(FINITE, "How much of it before the robot", default=4.0),
        "robot_frame": BASE_FRAME,
        "robot_base_frame": BASE_FRAME,
        "transform_tolerance": input_port(DOUBLE, "Read and not needed", default=0.2),
        "pose": input_port(POSE, "In place of the robot's", required=False),
        "angular_distance_weight": input_port(DOUBLE, "How much a radian counts beside a length of one", default=0.0),
        "max_robot_pose_search_dist": input_port(DOUBLE, "How far to look after the last point", default=math.inf),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The part")}

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, behaviour_class_name=behaviour_class_name)
        self._trail = Trail()

    def update(self) -> Status:
        """Cut the path."""
        path = self.read("input_path") or _NONE
        if path.poses:
            at = self._trail.reached(
                path,
                self.read("pose") or self.here,
                ahead=self.read("max_robot_pose_search_dist"),
                weight=self.read("angular_distance_weight"),
            )
            forward = self.read("distance_forward")
            end = math.inf if forward < 0.0 else at + forward
            path = part_of(path, at - self.read("distance_backward"), end)
        self.write("output_path", path)
        return Status.SUCCESS


class ConcatenatePaths(Leaf):
    """Puts two paths, one after the other, on ``output_path``; fails if there is nothing to put there."""

    INPUTS: ClassVar = {
        "input_path1": input_port(PATH, "The first path", required=False),
        "input_path2": input_port(PATH, "The second path", required=False),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "Both")}

    def update(self) -> Status:
        """Join the paths."""
        first, second = (self.read(port) or _NONE for port in self.INPUTS)
        if not first.poses and not second.poses:
            self.feedback_message = "there are no poses"
            return Status.FAILURE
        header = first.header if first.header != _NONE.header else second.header
        self.write("output_path", Path(header=header, poses=[*first.poses, *second.poses]))
        return Status.SUCCESS


class GetPoseFromPath(Leaf):
    """Puts one pose of a path on ``pose``; fails if it has no such pose."""

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "index": input_port(INT, "Which pose, from 0; negative from the end", default=-1),
    }
    OUTPUTS: ClassVar = {"pose": output_port(POSE, "The pose")}

    def update(self) -> Status:
        """Take the pose."""
        path, index = self.read("path") or _NONE, self.read("index")
        if not -len(path.poses) <= index < len(path.poses):
            self.feedback_message = f"no pose {index} in a path of {len(path.poses)}"
            return Status.FAILURE
        pose = path.poses[index]
        self.write("pose", pose if pose.header.frame_id else pose.model_copy(update={"header": path.header}))
        return Status.SUCCESS


_NODES = (ConcatenatePaths, GetPoseFromPath, TruncatePath, TruncatePathLocal)

FAMILY = Family("path_parts", {node.__name__: node for node in _NODES})

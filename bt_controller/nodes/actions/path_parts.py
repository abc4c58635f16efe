"""Nav2's actions that cut and join paths."""

from __future__ import annotations

import math
from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.ports import DOUBLE, FINITE, INT, PATH, POSE, input_port, output_port
from bt_controller.nodes import Family
from bt_controller.nodes.located import BASE_FRAME, Located
from bt_controller.nodes.paths import Trail, length_of, part_of, point_of
from hmrsim.geometry import SAME_PLACE, heading
from hmrsim.interfaces.nav_msgs import Path
from hmrsim_zenoh.client.places import pose_at

_NONE = Path()


class TruncatePath(Leaf):
    """Writes a path without its last ``distance`` to ``output_path``; the new last pose faces the goal."""

    INPUTS: ClassVar = {
        "input_path": input_port(PATH, "The path", required=False),
        "distance": input_port(FINITE, "Length to remove, in the world's unit of length", default=1.0),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The truncated path")}

    def update(self) -> Status:
        """Cut the path."""
        path = self.read("input_path") or _NONE
        if path.poses:
            end = path.poses[-1]
            path = part_of(path, 0.0, max(0.0, length_of(path) - self.read("distance")))
            x, y = point_of(path.poses[-1])
            if math.dist((x, y), point_of(end)) > SAME_PLACE:
                faced = pose_at(x, y, heading((x, y), point_of(end)))
                last = faced.model_copy(update={"header": end.header})
                path = Path(header=path.header, poses=[*path.poses[:-1], last])
        self.write("output_path", path)
        return Status.SUCCESS


class TruncatePathLocal(Located, Leaf):
    """Writes the part of a path around the robot to ``output_path``.

    It begins ``distance_backward`` before the path's point closest to the robot, or to ``pose``, and ends
    ``distance_forward`` after it, or with the path if that is negative. The search for the closest point covers the
    whole path, or ``max_robot_pose_search_dist`` after the previous one. Distances are along the path, in the world's
    unit of length.
    """

    INPUTS: ClassVar = {
        "input_path": input_port(PATH, "The path", required=False),
        "distance_forward": input_port(FINITE, "Length after the robot; negative for the whole rest", default=8.0),
        "distance_backward": input_port(FINITE, "Length before the robot", default=4.0),
        "robot_frame": BASE_FRAME,
        "robot_base_frame": BASE_FRAME,
        "transform_tolerance": input_port(DOUBLE, "Ignored", default=0.2),
        "pose": input_port(POSE, "Pose to use instead of the robot's", required=False),
        "angular_distance_weight": input_port(DOUBLE, "Weight of a radian relative to a unit of length", default=0.0),
        "max_robot_pose_search_dist": input_port(DOUBLE, "Search distance after the previous point", default=math.inf),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The part of the path")}

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
    """Writes the concatenation of two paths to ``output_path``; fails if it has no poses."""

    INPUTS: ClassVar = {
        "input_path1": input_port(PATH, "The first path", required=False),
        "input_path2": input_port(PATH, "The second path", required=False),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The concatenation")}

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
    """Writes one pose of a path to ``pose``; fails if there is no such pose."""

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "index": input_port(INT, "Index of the pose, from 0; negative from the end", default=0),
    }
    OUTPUTS: ClassVar = {"pose": output_port(POSE, "The pose")}

    def update(self) -> Status:
        """Write the pose."""
        path, index = self.read("path") or _NONE, self.read("index")
        if not -len(path.poses) <= index < len(path.poses):
            self.feedback_message = f"no pose {index} in a path of {len(path.poses)}"
            return Status.FAILURE
        pose = path.poses[index]
        self.write("pose", pose if pose.header.frame_id else pose.model_copy(update={"header": path.header}))
        return Status.SUCCESS


FAMILY = Family.of("path_parts", ConcatenatePaths, GetPoseFromPath, TruncatePath, TruncatePathLocal)

"""Messages for RViz, Foxglove and costmaps: the map, the robots' models, their fixed frames, plans and footprints.

They are plain values, which take a fraction of the time of messages. All poses are in the frame ``map``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, NamedTuple
from xml.sax.saxutils import quoteattr

from hmrsim.engine.sim_time import stamp
from hmrsim.geometry import METER, Pose
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.protocol.goal import WORLD
from hmrsim.world.model import Derived, Solid
from hmrsim_zenoh.ros2.publishing.markers import BASE, MAP, UP, static_frames, transform, xyz

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

FOOTPRINT_FRAME, SCAN_FRAME, ODOM_FRAME = "base_footprint", "base_scan", "odom"

_OCCUPIED: Final = 100
"""The value of an occupied cell in a map; 0 is free."""
_LETHAL: Final = 254
"""Its value in a costmap."""
_RESOLUTION: Final = 0.05
"""The length of a map's cell in meters, as in Nav2's maps."""
_MAX_CELLS: Final = 4_000_000
"""The largest number of cells; the cells of a larger map are 2, 4, … times as long."""
_MARGIN: Final = 1.0
"""Meters around the contents of a world without bounds."""

_RADIUS, _HEIGHT, _SCAN_HEIGHT = 0.3, 0.3, 0.2
"""Meters: the radius of a model without a footprint, the height of all models and that of the scan."""
_CORNERS: Final = 16
"""The corners of a footprint."""


class Grid(NamedTuple):
    """The walls of a world as cells.

    Attributes:
        x: The least x.
        y: The least y.
        resolution: The length of a cell.
        width: Cells in a row.
        cells: One byte a cell, row by row; 0 is free and 100 is a wall or inside a solid.
    """

    x: float
    y: float
    resolution: float
    width: int
    cells: bytes

    @property
    def height(self) -> int:
        """The number of rows of the grid."""
        return len(self.cells) // self.width


def _grid(world: World) -> Grid:
    meter = METER[world.units]
    x0, y0, x1, y1 = world.bounds or _extent(world, _MARGIN * meter)
    resolution = _RESOLUTION * meter
    while math.ceil((x1 - x0) / resolution) * math.ceil((y1 - y0) / resolution) > _MAX_CELLS:
        resolution *= 2.0
    width, height = (max(1, math.ceil(length / resolution)) for length in (x1 - x0, y1 - y0))
    cells = bytearray(width * height)
    for wall, outline in zip(world.walls, world.outlines, strict=True):
        points = [((x - x0) / resolution, (y - y0) / resolution) for x, y in outline]
        for start, end in _inner(points, width, height) if isinstance(wall, Solid) else ():
            cells[start:end] = bytes((_OCCUPIED,)) * (end - start)
        for column, row in _outer(points):
            if 0 <= column < width and 0 <= row < height:
                cells[row * width + column] = _OCCUPIED
    return Grid(x0, y0, resolution, width, bytes(cells))


grid_of: Final = Derived(_grid)
"""Returns the walls of a world as cells; doors are not walls."""


def _extent(world: World, margin: float) -> tuple[float, float, float, float]:
    points: list[Point] = [*world.points.values(), *(place.at for place in world.places.values())]
    points += [point for outline in world.outlines for point in outline]
    points += [world.point(robot.at) for robot in world.robots.values()]
    xs, ys = zip(*(points or [(0.0, 0.0)]), strict=True)
    return min(xs) - margin, min(ys) - margin, max(xs) + margin, max(ys) + margin


def _outer(points: Sequence[Point]) -> Iterator[tuple[int, int]]:
    """Yield the cells on a polyline, whose points are in cells."""
    for (ax, ay), (bx, by) in pairwise(points):
        steps = math.ceil(max(abs(bx - ax), abs(by - ay))) or 1
        for i in range(steps + 1):
            yield math.floor(ax + (bx - ax) * i / steps), math.floor(ay + (by - ay) * i / steps)


def _inner(points: Sequence[Point], width: int, height: int) -> Iterator[tuple[int, int]]:
    """Yield the ranges of cells whose centers are inside a closed outline, which is in cells (even-odd rule)."""
    for row in range(max(0, math.floor(min(y for _, y in points))), min(height, math.ceil(max(y for _, y in points)))):
        y = row + 0.5
        crossings = sorted(
            ax + (bx - ax) * (y - ay) / (by - ay) for (ax, ay), (bx, by) in pairwise(points) if (ay > y) != (by > y)
        )
        for start, end in zip(crossings[::2], crossings[1::2], strict=True):
            first, last = (min(width, max(0, round(x))) for x in (start, end))
            yield row * width + first, row * width + last


def occupancy_grid(simulator: Simulator, _robot: str = WORLD) -> dict[str, Any]:
    """Return the map as an OccupancyGrid."""
    grid, now = grid_of(simulator.world), values_of(stamp(simulator.now))
    info = {
        "map_load_time": now,
        "resolution": grid.resolution,
        "width": grid.width,
        "height": grid.height,
        "origin": pose_values(Pose(grid.x, grid.y)),
    }
    return {"header": {"stamp": now, "frame_id": MAP}, "info": info, "data": grid.cells}


def costmap(simulator: Simulator) -> dict[str, Any]:
    """Return the map as a Costmap of Nav2, whose walls are lethal."""
    grid, now = grid_of(simulator.world), values_of(stamp(simulator.now))
    metadata = {
        "map_load_time": now,
        "update_time": now,
        "layer": "master",
        "resolution": grid.resolution,
        "size_x": grid.width,
        "size_y": grid.height,
        "origin": pose_values(Pose(grid.x, grid.y)),
    }
    data = grid.cells.replace(bytes((_OCCUPIED,)), bytes((_LETHAL,)))
    return {"header": {"stamp": now, "frame_id": MAP}, "metadata": metadata, "data": data}


def pose_values(pose: Pose) -> dict[str, Any]:
    """Return a pose as the values of a geometry_msgs Pose."""
    return {"position": xyz(pose.x, pose.y), "orientation": _about_z(pose.yaw)}


def _about_z(yaw: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}


def urdf(simulator: Simulator, name: str) -> dict[str, Any]:
    """Return a robot's model as a String: a cylinder of its footprint and an arrow-like bar that shows its front."""
    robot, up = simulator.roster.robots[name], UP[simulator.world.units]
    meter = METER[simulator.world.units]
    radius, height = robot.radius or _RADIUS * meter, _HEIGHT * meter
    body = f'<cylinder radius="{radius:g}" length="{height:g}"/>'
    front = f'<box size="{radius:g} {radius / 5:g} {height / 10:g}"/>'
    text = f"""<?xml version="1.0"?>
<robot name={quoteattr(name)}>
  <material name="body"><color rgba="0.3 0.5 0.8 1"/></material>
  <material name="front"><color rgba="1 1 1 1"/></material>
  <link name="{BASE}">
    <visual>
      <origin xyz="0 0 {up * height / 2:g}"/><geometry>{body}</geometry><material name="body"/>
    </visual>
    <visual>
      <origin xyz="{radius / 2:g} 0 {up * height:g}"/><geometry>{front}</geometry><material name="front"/>
    </visual>
    <collision><origin xyz="0 0 {up * height / 2:g}"/><geometry>{body}</geometry></collision>
  </link>
  <link name="{SCAN_FRAME}"/>
  <joint name="scan_joint" type="fixed">
    <parent link="{BASE}"/><child link="{SCAN_FRAME}"/><origin xyz="0 0 {up * _SCAN_HEIGHT * meter:g}"/>
  </joint>
</robot>
"""
    return {"data": text}


def static_transforms(simulator: Simulator, name: str) -> dict[str, Any]:
    """Return the fixed frames as a TFMessage.

    Args:
        simulator: The simulation.
        name: The robot, whose frames then lack its name, as in Nav2; those with its name are below them, as messages
            have them. `WORLD` for all robots, whose frames have their names.
    """
    world, now = simulator.world, stamp(simulator.now)
    height = UP[world.units] * _SCAN_HEIGHT * METER[world.units]

    def fixed(parent: str, child: str, z: float = 0.0) -> dict[str, Any]:
        return transform({"stamp": values_of(now), "frame_id": parent}, child, xyz(z=z))

    def of_robot(robot: str, within: str) -> list[dict[str, Any]]:
        return [fixed(MAP, within + ODOM_FRAME), fixed(f"{robot}/{BASE}", f"{robot}/{SCAN_FRAME}", height)]

    if name != WORLD:
        own = [fixed(BASE, f"{name}/{BASE}"), fixed(BASE, SCAN_FRAME, height)]
        return {"transforms": [*of_robot(name, ""), *own]}
    transforms = static_frames(world.units, now)
    for robot in simulator.roster.robots:
        transforms += [*of_robot(robot, f"{robot}/"), fixed(f"{robot}/{BASE}", f"{robot}/{FOOTPRINT_FRAME}")]
    return {"transforms": transforms}


def plan(robot: Robot) -> dict[str, Any]:
    """Return the rest of a robot's route as a Path, which begins where the robot is; only that pose if it stands."""
    here = robot.stamped(robot.estimated(robot.pose()))
    header, poses, before = here["header"], [here], robot.pose().point
    for point in (leg.end for leg in robot.legs_ahead):
        yaw = math.atan2(point[1] - before[1], point[0] - before[0])
        poses.append({"header": header, "pose": pose_values(Pose(*point, yaw))})
        before = point
    return {"header": header, "poses": poses}


def footprint(robot: Robot) -> dict[str, Any]:
    """Return the footprint of a robot where it is, as a PolygonStamped; a point if it has none."""
    pose = robot.estimated(robot.pose())
    angles = (pose.yaw + math.tau * i / _CORNERS for i in range(_CORNERS if robot.radius else 1))
    corners = [xyz(pose.x + robot.radius * math.cos(at), pose.y + robot.radius * math.sin(at)) for at in angles]
    return {"header": robot.stamped(pose)["header"], "polygon": {"points": corners}}

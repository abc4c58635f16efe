"""Small trees of XML nodes without XML: leaves with scripted statuses, and ports that are wired by hand."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import count
from typing import NamedTuple

import pytest
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from bt_controller.core.blackboards import Board
from bt_controller.core.node import Decoration, Leaf
from bt_controller.core.sim_time import simulated_time
from bt_controller.running.schedule import due
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from hmrsim.interfaces.nav_msgs import Odometry, Path
from hmrsim.interfaces.std_msgs import Header
from hmrsim_zenoh.client.places import pose_at
from tests.cases import case
from tests.unit.bt_controller.conftest import FakeTopics

NEVER = math.inf
STATUSES = {"S": Status.SUCCESS, "F": Status.FAILURE, "R": Status.RUNNING, "-": Status.INVALID}
LETTERS = {status: letter for letter, status in STATUSES.items()}


class Told(Leaf):
    """A leaf that returns given statuses, one per tick and the last one forever, and counts its calls.

    Attributes:
        begun: How often it was begun.
        ticks: How often it was ticked.
        halts: How often it was halted while it ran.
    """

    def __init__(self, name, statuses):
        super().__init__(name)
        self._statuses = [STATUSES[letter] for letter in statuses]
        self.begun = self.ticks = self.halts = 0

    def initialise(self):
        self.begun += 1

    def update(self):
        self.ticks += 1
        return self._statuses.pop(0) if len(self._statuses) > 1 else self._statuses[0]

    def terminate(self, new_status):
        """Count it if it is a halt."""
        self.halts += new_status is Status.INVALID and self.status is Status.RUNNING


class Topics(FakeTopics):
    """The topics of a robot, whose pose the test sets.

    Attributes:
        known: The arguments with which nodes are set up.
    """

    def __init__(self):
        super().__init__()
        self.known = {"topics": self, "robot": "wall_e"}
        self.at()

    def at(self, x=0.0, y=0.0, yaw=0.0, speed=0.0, seconds=0.0):
        """Set the robot's pose and velocity."""
        self.messages["odom"] = Odometry(
            header=Header(frame_id="map", stamp=Time.from_nanoseconds(round(seconds * 1e9))),
            pose=PoseWithCovariance(pose=pose_at(x, y, yaw).pose),
            twist=TwistWithCovariance(twist=Twist(linear=Vector3(x=speed))),
        )


class Tree:
    """A tree that is ticked by hand; its clock stands still unless a tick is given the time."""

    def __init__(self, root, **known):
        self.root = root
        self.now = 0.0
        for node in root.iterate():
            if getattr(node, "_subtree_namespace", "/") is None:
                node.setup_ports()
        for node in root.iterate():
            node.setup(**known)

    def tick(self, now=None):
        """Tick the tree, and return the root's status as a letter."""
        self.now = self.now if now is None else now
        with simulated_time(self.now):
            self.root.tick_once()
        return LETTERS[self.root.status]

    def ticks(self, *times):
        """Tick the tree at each of these times, and return the root's statuses as letters."""
        return "".join(self.tick(now) for now in times)

    def halt(self):
        """Interrupt the tree at its root."""
        with simulated_time(self.now):
            self.root.stop(Status.INVALID)

    def due(self, period=1.0):
        """Return when the tree has to be ticked again."""
        return due(self.root, self.now, period).time

    def awaited(self):
        """Return the conditions that the tree waits for: key, path, operator and value of each."""
        return [(each.key, *when) for each in due(self.root, self.now, 1.0).awaited for when in each.when]


class At(NamedTuple):
    """A robot's pose in m and rad, and its speed in m/s; the stamp of the message is in seconds."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    speed: float = 0.0
    seconds: float = 0.0


@dataclass(frozen=True)
class Row:
    """The expected behavior of a node when it is ticked and halted.

    Attributes:
        kinds: The node's class, or all classes that behave so.
        children: The statuses of its leaves, one word each.
        steps: The statuses that its ticks return, and `!` for a halt; in a list, blackboard entries or where the
            robot is come between them.
        ports: The node's ports.
        times: When it is ticked, in seconds; at 0, 1, 2, … without any.
        before: Entries of the blackboard when the node is set up.
        at: Where the robot is when the node is set up.
        after: Entries of the blackboard afterwards.
        due: When the node has to be ticked again, if others are looked at each `period`.
        ticks: How often each leaf was ticked.
        begun: How often each leaf was begun.
        halts: How often each leaf was halted while it ran.
    """

    kinds: type | list[type]
    children: str
    steps: str | list
    ports: dict = field(default_factory=dict)
    times: tuple = ()
    before: dict = field(default_factory=dict)
    at: tuple = ()
    after: dict = field(default_factory=dict)
    due: float | None = None
    period: float = 1.0
    ticks: str = ""
    begun: str = ""
    halts: str = ""


def rows(table):
    """Parametrize a test with a table of rows by their sentences."""
    return pytest.mark.parametrize("row", table.values(), ids=table)


@pytest.fixture
def behaves(node, tree, told, topics, board):
    """Return what fails unless nodes do what a row says."""

    def write(entries):
        for key, value in entries.items():
            board[f"/{key}"] = [*value] if isinstance(value, list) else value

    def step(root, step, times):
        if isinstance(step, str):
            return "".join(root.halt() or "!" if letter == "!" else root.tick(next(times)) for letter in step)
        if isinstance(step, dict):
            write(step)
        else:
            topics.at(*step)
        return step

    def check_one(kind, row):
        board.clear()
        write(row.before)
        topics.at(*row.at)
        leaves = [told(statuses) for statuses in row.children.split()]
        root = tree(node(kind, *leaves, **row.ports), **topics.known)
        times = iter(row.times or count())
        counted = [counter for counter in ("ticks", "begun", "halts") if getattr(row, counter)]

        steps = [row.steps] if isinstance(row.steps, str) else row.steps
        assert steps == [step(root, each, times) for each in steps]
        assert [getattr(row, counter) for counter in counted] == [
            " ".join(str(getattr(leaf, counter)) for leaf in leaves) for counter in counted
        ]
        assert row.due in (None, pytest.approx(root.due(row.period)))
        assert row.after == {key: board.get(f"/{key}") for key in row.after}

    def check(row):
        for kind in row.kinds if isinstance(row.kinds, list) else [row.kinds]:
            with case(kind.__name__):
                check_one(kind, row)

    return check


@pytest.fixture(autouse=True)
def _own_board():
    """Give each test a blackboard as missions have it."""
    with Board().in_use:
        yield


@pytest.fixture
def told():
    """Return what makes a leaf that returns these statuses: S, F, R, and - for skipped."""

    def make(statuses, name="leaf"):
        return Told(name, statuses)

    return make


@pytest.fixture
def node():
    """Return what makes a node with these children; ports are values, or keys of the blackboard if they are {key}.

    Texts are texts as they are in a file, other values are on the blackboard as such.
    """
    count = 0

    def make(kind, *children, **ports):
        nonlocal count
        count += 1
        name = f"{kind.__name__}{count}"
        made = kind(name, *children) if issubclass(kind, Decoration) else kind(name)
        if children and not issubclass(kind, Decoration):
            made.add_children(list(children))
        keys = {}
        for port, value in ports.items():
            name_of_port = port.rstrip("_")
            if isinstance(value, str) and value.startswith("{"):
                keys[name_of_port] = f"/{value[1:-1]}"
            else:
                keys[name_of_port] = f"/ports/{name}/{name_of_port}"
                Blackboard.set(keys[name_of_port], value)
        for port in made.INPUTS:
            default = made.INPUTS[port].default_value
            if isinstance(default, str) and default.startswith("{"):
                keys.setdefault(port, f"/{default[1:-1]}")
        for script in getattr(kind, "scripts", {}).values():
            for entry in (*script.names, *(f"{name}>" for name in script.changed)):
                keys[entry] = f"/{entry.removeprefix('@').removesuffix('>')}"
        made.setup_ports(keys)
        return made

    return make


@pytest.fixture
def topics():
    """Return what wall_e publishes: at first, that it stands at (0, 0)."""
    return Topics()


@pytest.fixture
def path():
    """Return what makes a path of points; each pose faces the next one."""

    def make(*points):
        ends = [*points[1:], points[-1]]
        yaws = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(points, ends, strict=True)]
        return Path(poses=[pose_at(float(x), float(y), yaw) for (x, y), yaw in zip(points, yaws, strict=True)])

    return make


@pytest.fixture
def tree():
    """Return what makes a tree of a root, ready to be ticked; whatever else is given goes to the nodes' setup."""
    return Tree


@pytest.fixture
def board():
    """Return the blackboard: a mapping of keys to values."""
    return Blackboard.storage

"""The parts of a simulator's endpoints: in which order they are declared, and which of them without being asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.names import (
    LIFECYCLE_SERVICE,
    WORLD_NODE,
    lifecycle_of,
    named_actions,
    nodes_of,
)
from hmrsim_zenoh.ros2.node_services import NODE_SERVICES
from hmrsim_zenoh.ros2.per_robot import cached_per_robot
from hmrsim_zenoh.ros2.publishing.endpoints import (
    AMCL_POSE,
    BATTERY_STATE,
    CLOCK,
    DETECTIONS,
    ODOM,
    TF,
    Part,
    topic_name,
)

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.names import Names

FIRST: Final = "navigate_to_pose"
"""The action that is declared for all robots before the rest of any robot."""

MAX_STANDING: Final = 4_000
"""The largest number of tokens that are declared without being asked for, except for `ALWAYS`: with 4,000, a ROS node
that comes knows them all in half a second; twice as many take four times as long."""

ALWAYS: Final = 2
"""The number of phases that are declared in any case: the world, and the goals to drive of all robots."""

_ACTION: Final = "/_action/"


class Parts:
    """All parts of the robots that are served.

    Args:
        lost: The robots to which the connection is lost, which have no parts.
    """

    def __init__(self, names: Names, lost: Collection[str] = ()) -> None:
        self._names = names
        self._phases = _phases(names, lost)
        self.all = [part for phase in self._phases for part in phase]

    def standing(self, tokens: Callable[[Part], int]) -> int:
        """Return how many of the parts are declared without being asked for.

        A phase is declared for all robots or for none, so that all robots have the same.

        Args:
            tokens: Returns the number of a part's tokens.
        """
        count = total = 0
        for number, phase in enumerate(self._phases):
            total += sum(map(tokens, phase))
            if number >= ALWAYS and total > MAX_STANDING:
                break
            count += len(phase)
        return count

    def of(self, name: str) -> Part | None:
        """Return the part with the endpoints of a name, such as ``/wall_e/odom``; None if there is none."""
        action, is_action, _ = name.rpartition(_ACTION)
        if is_action:
            return self._of_actions.get(self._names.actions.get(action, ("", "")))
        node, _, verb = name.rpartition("/")
        part = self._others.get(node if verb in NODE_SERVICES and verb != LIFECYCLE_SERVICE else name)
        return part or (self.all[0] if name.count("/") == 1 else None)

    @cached_property
    def _of_actions(self) -> dict[tuple[str, str], Part]:
        return {(part.robot, action): part for part in self.all for _, action in part.actions}

    @cached_property
    def _others(self) -> dict[str, Part]:
        found = {name: part for part in self.all for name, _ in part.states}
        found |= {node.full_name: part for part in self.all for node in part.served}
        found |= {topic_name(part.robot, topic): part for part in self.all for topic in part.topics}
        return found


class _RobotParts(NamedTuple):
    """The parts of one robot."""

    first: Part
    nodes: Part
    topics: Part
    others: Mapping[str, Part]
    services: tuple[Part, ...]


def _phases(names: Names, lost: Collection[str]) -> list[list[Part]]:
    """Return all parts in the order to declare them; none of robots to which the connection is lost.

    First the world and the goals to drive of all robots, then their nodes, then topics and states, then one other
    action after the other, and the services of nodes at last.
    """
    aliases: dict[str, dict[str, str]] = {}
    for alias, target in names.aliases.items():
        robot, action = names.actions.get(f"/{alias}", ("", ""))
        if target == f"{robot}/{action}":
            aliases.setdefault(robot, {})[f"/{alias}"] = action
    found = [
        _parts_of(robot, tuple(actions), tuple(aliases.get(robot, {}).items()), tuple(_topics(names, robot)))
        for robot, actions in names.serves.items()
        if robot not in lost and robot != WORLD
    ]
    of_world = _called(WORLD, tuple(names.serves.get(WORLD, ())), tuple(aliases.get(WORLD, {}).items()))
    world = tuple(named for of_action in of_world.values() for named in of_action)
    others = dict.fromkeys(action for one in found for action in one.others)
    return [
        [Part(WORLD, world, (CLOCK, TF), served=(WORLD_NODE,))],
        [one.first for one in found],
        [one.nodes for one in found],
        [one.topics for one in found],
        *([one.others[action] for one in found if action in one.others] for action in others),
        [part for one in found for part in one.services],
    ]


# Cached, since a robot may come to hundreds of others that do not change.
@cached_per_robot
def _parts_of(
    robot: str, actions: tuple[str, ...], aliases: tuple[tuple[str, str], ...], topics: tuple[str, ...]
) -> _RobotParts:
    called = _called(robot, actions, aliases)
    nodes = nodes_of(robot, actions)
    return _RobotParts(
        Part(robot, tuple(called.pop(FIRST, ()))),
        Part(robot, nodes=nodes),
        Part(robot, (), topics, tuple(lifecycle_of(robot, actions).items())),
        {action: Part(robot, tuple(named)) for action, named in called.items()},
        tuple(Part(robot, served=(node,)) for node in nodes),
    )


def _called(
    robot: str, actions: tuple[str, ...], aliases: tuple[tuple[str, str], ...]
) -> dict[str, list[tuple[str, str]]]:
    """Return the names of each action of a robot, each with the action."""
    own = {name: action for name, (_, action) in named_actions(robot, actions).items()}
    found: dict[str, list[tuple[str, str]]] = {}
    for name, action in {**own, **dict(aliases)}.items():
        found.setdefault(action, []).append((name, action))
    return found


def _topics(names: Names, robot: str) -> Iterator[str]:
    yield from (ODOM, TF, AMCL_POSE)
    if robot in names.powered:
        yield BATTERY_STATE
    if robot in names.seeing:
        yield DETECTIONS

"""The endpoints of a simulator in parts, in the order in which they are declared."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.names import (
    MAP_SERVER,
    NODE_SERVICES,
    WORLD_NODE,
    cached_per_robot,
    lifecycle_of,
    node_of,
    nodes_of,
    own_services,
)
from hmrsim_zenoh.ros2.publishing.endpoints import (
    BATTERY_STATE,
    DETECTIONS,
    FOR_VIEWERS,
    GOAL_POSE,
    OF_ALL,
    OF_WORLD,
    Part,
    topic_name,
)

if TYPE_CHECKING:
    from hmrsim_zenoh.ros2.names import Names

FIRST: Final = "navigate_to_pose"
"""The action that is declared for all robots before any other, and whose node is always declared."""

MAX_STANDING: Final = 4_000
"""The largest number of tokens that are declared without a request, except for `ALWAYS`: a new ROS node
receives 4,000 in half a second, and twice as many in four times as long."""

ALWAYS: Final = 2
"""The number of phases that are always declared: the world, and one node of each robot."""

_ACTION: Final = "/_action/"

_Called = tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
"""The actions of a robot, each with the pairs of name and action to declare."""


class Parts:
    """The parts with all endpoints of the served robots and the world, in the order to declare them.

    Args:
        lost: The robots to which the connection is lost, which have no parts.
    """

    def __init__(self, names: Names, lost: Collection[str] = ()) -> None:
        self._names = names
        self._phases = _phases(names, lost)
        self.all = [part for phase in self._phases for part in phase]

    def standing(self, tokens: Callable[[Part], int]) -> int:
        """Return how many of the parts are declared without a request.

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
        part = self._others.get(name) or (self._others.get(node) if verb in NODE_SERVICES else None)
        return part or (self.all[0] if name.count("/") == 1 else None)

    @cached_property
    def _of_actions(self) -> dict[tuple[str, str], Part]:
        return {(part.robot, action): part for part in self.all for _, action in part.actions}

    @cached_property
    def _others(self) -> dict[str, Part]:
        result = {name: part for part in self.all for name, _ in part.states}
        served = [(node, part) for part in self.all for node in part.served]
        result |= {node.full_name: part for node, part in served}
        result |= {name: part for node, part in served for name in own_services(node)}
        result |= {topic_name(part.robot, topic): part for part in self.all for topic in part.topics}
        return result


class _RobotParts(NamedTuple):
    """The parts of one robot."""

    node: Part
    first: Part
    nodes: Part
    topics: Part
    others: Mapping[str, Part]
    views: Part
    services: tuple[Part, ...]


def _phases(names: Names, lost: Collection[str]) -> list[list[Part]]:
    """Return all parts in the order to declare them, without robots to which the connection is lost.

    The order is: the world, one node of each robot, action `FIRST` of all robots, their nodes, their topics and states,
    each other action, topics for viewers, and finally the services of nodes.
    """
    robots = [
        _parts_of(robot, _called(names, robot), tuple(_topics(names, robot)))
        for robot in names.serves
        if robot not in lost and robot != WORLD
    ]
    world = tuple(named for _, called in _called(names, WORLD) for named in called)
    others = dict.fromkeys(action for one in robots for action in one.others)
    return [
        [Part(WORLD, world, OF_WORLD, served=(WORLD_NODE, MAP_SERVER))],
        [one.node for one in robots],
        [one.first for one in robots],
        [one.nodes for one in robots],
        [one.topics for one in robots],
        *([one.others[action] for one in robots if action in one.others] for action in others),
        [one.views for one in robots],
        [part for one in robots for part in one.services],
    ]


# Cached, since the parts of hundreds of robots stay the same when another one joins.
@cached_per_robot
def _parts_of(robot: str, called: _Called, topics: tuple[str, ...]) -> _RobotParts:
    others = dict(called)
    actions = tuple(others)
    first = others.pop(FIRST, ())
    nodes = nodes_of(robot, actions)
    return _RobotParts(
        Part(robot, nodes=(node_of(robot, FIRST if FIRST in actions else ""),)),
        Part(robot, first),
        Part(robot, nodes=nodes),
        Part(robot, (), topics, tuple(lifecycle_of(robot, actions).items())),
        {action: Part(robot, named) for action, named in others.items()},
        Part(robot, topics=(*FOR_VIEWERS, *((GOAL_POSE,) if FIRST in actions else ()))),
        tuple(Part(robot, served=(node,)) for node in nodes),
    )


def _called(names: Names, robot: str) -> _Called:
    return tuple(
        (action, tuple((name, action) for name in names.called(robot, action)))
        for action in names.serves.get(robot, ())
    )


def _topics(names: Names, robot: str) -> Iterator[str]:
    yield from OF_ALL
    if robot in names.powered:
        yield BATTERY_STATE
    if robot in names.seeing:
        yield DETECTIONS

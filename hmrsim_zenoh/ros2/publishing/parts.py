"""The parts of a simulator's endpoints: in which order they are declared, and which of them without being asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Final

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.ros2.names import LIFECYCLE_SERVICE, WORLD_NODE
from hmrsim_zenoh.ros2.node_services import NODE_SERVICES
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
    from hmrsim_zenoh.ros2.keys import Node
    from hmrsim_zenoh.ros2.names import Names

FIRST: Final = "navigate_to_pose"
"""The action that is declared for all robots before the rest of any robot."""

MAX_STANDING: Final = 4_500
"""The largest number of tokens that are declared without being asked for, except for `ALWAYS`: with 4,500, a ROS node
knows them all in 0.3 s; twice as many take four times as long."""

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


def _phases(names: Names, lost: Collection[str]) -> list[list[Part]]:
    """Return all parts in the order to declare them; none of robots to which the connection is lost.

    First the world and the goals to drive of all robots, then their nodes, then topics and states, then one other
    action after the other, and the services of nodes at last.
    """
    actions: dict[str, dict[str, list[tuple[str, str]]]] = {robot: {} for robot in names.serves}
    for name, (robot, action) in names.actions.items():
        actions[robot].setdefault(action, []).append((name, action))
    states: dict[str, list[tuple[str, Node]]] = {f"/{robot}": [] for robot in names.serves}
    for name, node in names.lifecycle.items():
        states[node.namespace].append((name, node))
    robots = [robot for robot in names.serves if robot not in lost and robot != WORLD]
    of_world = tuple(named for of_action in actions.get(WORLD, {}).values() for named in of_action)
    others = dict.fromkeys(action for robot in robots for action in actions[robot] if action != FIRST)
    return [
        [Part(WORLD, of_world, (CLOCK, TF), served=(WORLD_NODE,))],
        [Part(robot, tuple(actions[robot].get(FIRST, ()))) for robot in robots],
        [Part(robot, nodes=tuple(names.nodes[robot])) for robot in robots],
        [Part(robot, (), tuple(_topics(names, robot)), tuple(states[f"/{robot}"])) for robot in robots],
        *(
            [Part(robot, tuple(actions[robot][action])) for robot in robots if action in actions[robot]]
            for action in others
        ),
        [Part(robot, served=(node,)) for robot in robots for node in names.nodes[robot]],
    ]


def _topics(names: Names, robot: str) -> Iterator[str]:
    yield from (ODOM, TF, AMCL_POSE)
    if robot in names.powered:
        yield BATTERY_STATE
    if robot in names.seeing:
        yield DETECTIONS

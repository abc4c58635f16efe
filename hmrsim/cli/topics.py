"""The topics of a running simulation, by the names that ROS gives them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import UnknownName
from hmrsim.cli.names import ActionName, aliases, robots
from hmrsim.diagnostics import instead
from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.wire.keys import TREE, Verb

if TYPE_CHECKING:
    from hmrsim.cli.names import Info
    from hmrsim_zenoh.wire.keys import Keys

_OF_THE_WORLD: Final = {
    "clock": ("rosgraph_msgs/msg/Clock", True),
    "events": ("hmrsim/Event", False),
    "log": ("hmrsim/Event", False),
    "info": ("hmrsim/WorldInfo", True),
    "route_graph": ("hmrsim/RouteGraph", True),
    "demand": ("hmrsim/Demand", True),
    "scene": ("hmrsim/Scene", True),
    "view": ("hmrsim/View", True),
}
_OF_ROBOTS: Final = {
    "odom": ("nav_msgs/msg/Odometry", True),
    "battery_state": ("sensor_msgs/msg/BatteryState", True),
    "detections": ("vision_msgs/msg/Detection3DArray", True),
}
_NEED: Final = {"battery_state": {"battery"}, "detections": {"camera", "proximity"}}
"""One of which components a robot must have for a topic; none where nothing is said."""
_OF_ACTIONS: Final = {
    Verb.FEEDBACK: ("{action}_FeedbackMessage", False),
    Verb.STATUS: ("action_msgs/msg/GoalStatusArray", True),
}
"""Their types, and whether a ``get`` answers with the latest message."""


@dataclass(frozen=True)
class Topic:
    """A published topic.

    Attributes:
        name: As in ROS, such as ``/wall_e/odom`` or ``/wall_e/wait/_action/status``.
        latched: Whether the simulator answers a ``get`` with the latest message.
    """

    name: str
    ros_type: str
    latched: bool

    @property
    def hidden(self) -> bool:
        """Whether it is a part of an action, which ROS 2 does not list unless asked."""
        return "/_action/" in self.name

    def key(self, keys: Keys) -> str:
        """Return its key."""
        return f"{keys.prefix}{self.name}"


def topics(info: Info) -> Iterator[Topic]:
    """Yield all topics: each robot's, its actions', and the world's."""
    carried = {robot["name"]: robot.get("components", ()) for robot in info.get("robots", ())}
    for robot, actions in robots(info).items():
        for topic, (ros_type, latched) in _OF_ROBOTS.items():
            if topic not in _NEED or not _NEED[topic].isdisjoint(carried[robot]):
                yield Topic(f"/{robot}/{topic}", ros_type, latched)
        for action in actions:
            yield from _of_action(robot, action)
    for topic, (ros_type, latched) in _OF_THE_WORLD.items():
        yield Topic(f"/{WORLD}/{topic}", ros_type, latched)


def find_topic(info: Info, name: str) -> Topic:
    """Return the topic of a name; the first slash may be left out, and an action may go by its alias.

    Raises:
        UnknownName: There is no such robot or topic.
    """
    words = name.removeprefix("/").split("/")
    if words[1:] == [TREE] and words[0] in robots(info):
        # This topic is a controller's, which may come later.
        return Topic(f"/{words[0]}/{TREE}", "hmrsim/Tree", latched=True)
    if len(words) > 2:  # noqa: PLR2004 - an action's name has two words
        words[:2] = aliases(info).get("/".join(words[:2]), "/".join(words[:2])).split("/")
    wanted = "/" + "/".join(words)
    found = {topic.name: topic for topic in topics(info)}
    if wanted in found:
        return found[wanted]
    owner = words[0]
    if (of_world := f"/{WORLD}{wanted}") in found:
        raise UnknownName(f"no topic {name!r}; did you mean {of_world!r}?")
    if owner != WORLD and owner not in robots(info):
        rest = instead(owner, robots(info), verb="there are:")
        raise UnknownName(f"no topic {name!r}: there is no robot {owner!r}{rest}")
    names = [topic.removeprefix(f"/{owner}/") for topic in found if topic.startswith(f"/{owner}/")]
    rest = instead("/".join(words[1:]), names, verb=f"{owner} has:")
    raise UnknownName(f"no topic {name!r}{rest}")


def _of_action(robot: str, action: str) -> Iterator[Topic]:
    ros_type = ActionName("", robot, action).ros_type
    for verb, (pattern, latched) in _OF_ACTIONS.items():
        yield Topic(f"/{robot}/{action}/_action/{verb.value}", pattern.format(action=ros_type), latched)

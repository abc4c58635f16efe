"""The actions, services and topics of a running simulation, by their ROS names such as ``/mocha/odom``."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

from hmrsim.actions import registry
from hmrsim.cli.connection import Info, connected
from hmrsim.cli.options import ExitCode, UnknownName, WrongUse, add_connection_options, add_json
from hmrsim.cli.output import show_result
from hmrsim.diagnostics import instead
from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.wire.keys import TREE, Verb

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim_zenoh.wire.keys import Keys


@dataclass(frozen=True)
class ActionName:
    """The name of an action of a robot, which may be an alias.

    Attributes:
        name: Such as ``/mocha/pickup``, or an alias such as ``/mocha/grab``.
    """

    name: str
    robot: str
    action: str
    hidden: ClassVar[bool] = False

    @property
    def entry(self) -> dict[str, Any]:
        """The name in the JSON of lists."""
        return {"name": self.name, "type": self.ros_type, "robot": self.robot, "action": self.action}

    @property
    def ros_type(self) -> str:
        """The ROS type of the action; empty if the action is not installed here."""
        known = registry().get(self.action)
        return known.ros_type if known else ""

    def definition(self) -> AnyAction:
        """Return the action.

        Raises:
            UnknownName: The simulator has the action, but it is not installed here.
        """
        known = registry().get(self.action)
        if known is None:
            raise UnknownName(f"action {self.action!r} is not installed here; there are: {', '.join(registry())}")
        return known


def robots(info: Info) -> dict[str, list[str]]:
    """Return the names of each robot's actions."""
    return {robot["name"]: list(robot.get("actions", ())) for robot in info.get("robots", ())}


def aliases(info: Info) -> Mapping[str, str]:
    """Return the aliases of actions, mapped to ``robot/action``."""
    names: Mapping[str, str] = info.get("aliases", {})
    return names


def _owners(info: Info) -> dict[str, list[str]]:
    """Return the names of the actions of each robot, and of the world if it has actions."""
    of_world = list(info.get("actions", ()))
    return robots(info) | ({WORLD: of_world} if of_world else {})


def actions(info: Info) -> Iterator[ActionName]:
    """Yield the names of all actions: the robots', the world's, and aliases."""
    for robot, names in _owners(info).items():
        for name in names:
            yield ActionName(f"/{robot}/{name}", robot, name)
    for alias, target in aliases(info).items():
        robot, _, action = target.partition("/")
        yield ActionName(f"/{alias}", robot, action)


def find_action(info: Info, name: str) -> ActionName:
    """Return the action that a name or an alias stands for; its first slash is optional.

    Raises:
        WrongUse: *name* is not of the form ``/ROBOT/ACTION``.
        UnknownName: There is no such robot or action.
    """
    first, slash, second = name.removeprefix("/").partition("/")
    if not (first and slash and second) or "/" in second:
        raise WrongUse(f"{name!r} is not an action's name; expected /ROBOT/ACTION, such as /mocha/navigate_to_pose")
    robot, _, action = aliases(info).get(f"{first}/{second}", f"{first}/{second}").partition("/")
    owners = _owners(info)
    if robot not in owners:
        raise UnknownName(f"no robot {robot!r}{instead(robot, robots(info), verb='there are:')}")
    if action not in owners[robot]:
        known = registry().get(action)
        if known is not None and known.component is not None:
            raise UnknownName(f"{robot} has no action {action!r}, which needs the component {known.component!r}")
        raise UnknownName(f"{robot} has no action {action!r}{instead(action, owners[robot], verb='it has:')}")
    return ActionName(f"/{first}/{second}", robot, action)


_WORLD_SERVICES: Final = {"info": "hmrsim/WorldInfo", "route_graph": "hmrsim/RouteGraph"}
_SERVICES_OF_ACTIONS: Final = {
    Verb.SEND_GOAL: "{action}_SendGoal",
    Verb.CANCEL_GOAL: "action_msgs/srv/CancelGoal",
    Verb.GET_RESULT: "{action}_GetResult",
    Verb.EXECUTE: "hmrsim/Execute",
}


@dataclass(frozen=True)
class Service:
    """A service of the simulator or of an action.

    Attributes:
        name: As in ROS, such as ``/_world/info`` or ``/wall_e/wait/_action/send_goal``.
        ros_type: The type of its requests and replies; empty if unknown.
        hidden: Whether it belongs to an action; ROS 2 lists such services only on request.
    """

    name: str
    ros_type: str
    hidden: bool = False

    @property
    def entry(self) -> dict[str, Any]:
        """The service in the JSON of lists."""
        return {"name": self.name, "type": self.ros_type, "hidden": self.hidden}


def services(info: Info) -> Iterator[Service]:
    """Yield all services: the world's, then those of actions under all their names."""
    described = {one["name"]: one.get("type", "") for one in info.get("services", ())}
    for name, ros_type in ({f"{WORLD}/{name}": kind for name, kind in _WORLD_SERVICES.items()} | described).items():
        yield Service(f"/{name.removeprefix('/')}", ros_type)
    for action in actions(info):
        for verb, pattern in _SERVICES_OF_ACTIONS.items():
            ros_type = pattern.format(action=action.ros_type) if action.ros_type else ""
            yield Service(f"{action.name}/_action/{verb.value}", ros_type, hidden=True)


def service_types(info: Info) -> dict[str, str]:
    """Return the type of each service, by its name."""
    return {service.name: service.ros_type for service in services(info)}


_WORLD_TOPICS: Final = {
    "clock": ("rosgraph_msgs/msg/Clock", True),
    "events": ("hmrsim/Event", False),
    "log": ("hmrsim/Event", False),
    "info": ("hmrsim/WorldInfo", True),
    "route_graph": ("hmrsim/RouteGraph", True),
    "demand": ("hmrsim/Demand", True),
    "scene": ("hmrsim/Scene", True),
    "view": ("hmrsim/View", True),
}
_ROBOT_TOPICS: Final = {
    "odom": ("nav_msgs/msg/Odometry", True),
    "battery_state": ("sensor_msgs/msg/BatteryState", True),
    "detections": ("vision_msgs/msg/Detection3DArray", True),
}
_NEEDED_COMPONENTS: Final = {"battery_state": {"battery"}, "detections": {"camera", "proximity"}}
"""The components that publish a topic, of which a robot needs one; topics that are not listed need none."""
_TOPICS_OF_ACTIONS: Final = {
    Verb.FEEDBACK: ("{action}_FeedbackMessage", False),
    Verb.STATUS: ("action_msgs/msg/GoalStatusArray", True),
}
"""The type of each topic, and whether the simulator answers a ``get`` with the latest message."""


@dataclass(frozen=True)
class Topic:
    """A topic that the simulator or a controller publishes.

    Attributes:
        name: As in ROS, such as ``/wall_e/odom`` or ``/wall_e/wait/_action/status``.
        latched: Whether the simulator answers a ``get`` with the latest message.
    """

    name: str
    ros_type: str
    latched: bool

    @property
    def hidden(self) -> bool:
        """True if the topic belongs to an action; ROS 2 lists such topics only on request."""
        return "/_action/" in self.name

    @property
    def entry(self) -> dict[str, Any]:
        """The topic in the JSON of lists."""
        return {"name": self.name, "type": self.ros_type, "latched": self.latched, "hidden": self.hidden}

    def key(self, keys: Keys) -> str:
        """Return the Zenoh key."""
        return f"{keys.prefix}{self.name}"


def topics(info: Info) -> Iterator[Topic]:
    """Yield all topics: each robot's, its actions', and the world's."""
    carried = {robot["name"]: robot.get("components", ()) for robot in info.get("robots", ())}
    for robot, actions in robots(info).items():
        for topic, (ros_type, latched) in _ROBOT_TOPICS.items():
            if topic not in _NEEDED_COMPONENTS or not _NEEDED_COMPONENTS[topic].isdisjoint(carried[robot]):
                yield Topic(f"/{robot}/{topic}", ros_type, latched)
        for action in actions:
            ros_type = ActionName("", robot, action).ros_type
            for verb, (pattern, latched) in _TOPICS_OF_ACTIONS.items():
                yield Topic(f"/{robot}/{action}/_action/{verb.value}", pattern.format(action=ros_type), latched)
    for topic, (ros_type, latched) in _WORLD_TOPICS.items():
        yield Topic(f"/{WORLD}/{topic}", ros_type, latched)


def find_topic(info: Info, name: str) -> Topic:
    """Return the topic of a name; its first slash is optional, and an action may be named by its alias.

    Raises:
        UnknownName: There is no such robot or topic.
    """
    words = name.removeprefix("/").split("/")
    if words[1:] == [TREE] and words[0] in robots(info):
        # The topic belongs to a controller, which may start later.
        return Topic(f"/{words[0]}/{TREE}", "hmrsim/Tree", latched=True)
    if len(words) > 2:  # noqa: PLR2004 - an action's name has two words
        words[:2] = aliases(info).get("/".join(words[:2]), "/".join(words[:2])).split("/")
    full_name = "/" + "/".join(words)
    known = {topic.name: topic for topic in topics(info)}
    if full_name in known:
        return known[full_name]
    owner = words[0]
    if (of_world := f"/{WORLD}{full_name}") in known:
        raise UnknownName(f"no topic {name!r}; did you mean {of_world!r}?")
    if owner != WORLD and owner not in robots(info):
        rest = instead(owner, robots(info), verb="there are:")
        raise UnknownName(f"no topic {name!r}: there is no robot {owner!r}{rest}")
    names = [topic.removeprefix(f"/{owner}/") for topic in known if topic.startswith(f"/{owner}/")]
    rest = instead("/".join(words[1:]), names, verb=f"{owner} has:")
    raise UnknownName(f"no topic {name!r}{rest}")


def add_list_arguments(
    parser: argparse.ArgumentParser,
    names: Callable[[Info], Iterable[ActionName | Service | Topic]],
    *,
    of_actions: str = "",
) -> None:
    """Add the arguments of a command that lists names, one per line or with their ROS types.

    Args:
        parser: The parser of the command.
        names: Returns the names of a running simulator.
        of_actions: The names of actions, in the plural, that are listed only on request; empty for none.
    """
    parser.set_defaults(hidden=False)
    if of_actions:
        help_text = f"list the {of_actions} of actions, too"
        parser.add_argument("-a", f"--include-hidden-{of_actions}", dest="hidden", action="store_true", help=help_text)
    parser.add_argument("-t", "--show-types", action="store_true", help="show the ROS type after each name")
    add_json(parser, "print one JSON list")
    parser.set_defaults(function=lambda args: _print_names(args, names))
    add_connection_options(parser)


def _print_names(args: argparse.Namespace, names: Callable[[Info], Iterable[ActionName | Service | Topic]]) -> int:
    with connected(args) as (_, info):
        listed = [name for name in names(info) if args.hidden or not name.hidden]
    lines = (f"{name.name} [{name.ros_type}]" if args.show_types else name.name for name in listed)
    show_result([name.entry for name in listed], lines, as_json=args.json)
    return ExitCode.DONE

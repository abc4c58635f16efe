"""The rights of roles, as rules on key expressions of the JSON wire and of ROS 2's.

Rules only allow, as a denial in Zenoh does not cover key expressions that are wider than itself; the exception are
controllers of all robots, for which ``*`` would include the world. A simulator serves no request on a wildcard.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.wire.access_control import EVERYTHING, MESSAGES, READING, AccessControl, Rule
from hmrsim_zenoh.wire.enclave import SIMULATOR

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.access_control import Message
    from hmrsim_zenoh.wire.enclave import Member

_VALUES: Final = ("clock", "demand", "info", "log", "route_graph", "scene", "sessions", "view", "time/state")
"""The values of the world that clients can get."""
_TOPICS: Final = ("odom", "battery_state", "detections", "_tree")
"""The topics of a robot that clients can get."""
_READING: Final = ("get_$*", "is_$*")
"""The services of the world that change nothing, by their names."""
_NODES: Final = ("*", "*/*")
"""The simulator's node, and the robots'."""
_OF_NODES: Final = ("get_$*", "list_parameters", "describe_parameters")
"""The services of ROS nodes that change nothing."""
_JOINING: Final = ("join", "leave")
"""The requests of participants in lockstep. Advancing has a key for each name, as it can carry goals for any robot."""
_ROS_TOKENS: Final = ("NN", "MP", "MS", "SC")
"""The kinds of tokens that ROS nodes declare: all except servers, which would pose as the simulator's."""
_ROS_LOGS: Final = ("rosout", "parameter_events")
"""The topics on which each ROS node publishes."""
_ROS_GOALS: Final = ("goal_pose", "cmd_vel")
"""The topics of a robot by which ROS nodes drive it."""
_ROS_PLACING: Final = ("initialpose",)
"""The topics by which they move it as a service of the world does."""


@dataclass(frozen=True)
class Rights:
    """The rights on one network.

    Attributes:
        prefix: The prefix of the simulator's keys.
        domain: ROS's domain id.
    """

    prefix: str
    domain: int

    def access_control(self, members: Iterable[Member]) -> AccessControl:
        """Return the policy of some members; all others have no rights."""
        return AccessControl({member.name: tuple(self._rules(member)) for member in members})

    def _rules(self, member: Member) -> Iterator[Rule]:
        if member.role == SIMULATOR:
            yield Rule("simulators speak with each other", MESSAGES, "ingress", EVERYTHING)
            yield Rule("simulators hear each other", MESSAGES, "egress", EVERYTHING)
            return
        yield from self._reading()
        if member.role == "viewer":
            return
        yield from self._driving()
        if member.role == "operator":
            everything = (self._key("**"), self._ros("**"))
            yield Rule("operators command everything", ("query",), "ingress", everything)
            topics = [self._ros(f"*/{topic}/*/*") for topic in (*_ROS_GOALS, *_ROS_PLACING)]
            yield Rule("operators publish goals and poses", ("put",), "ingress", tuple(topics))
            yield from self._trees("operators", ("*",))
            yield from self._planning()
            return
        robots = member.robots or ("*",)
        who = f"{member.name} drives {', '.join(member.robots) or 'all robots'}"
        yield Rule(who, ("query",), "ingress", tuple(key for robot in robots for key in self._commands(robot)))
        topics = [self._ros(f"{robot}/{topic}/*/*") for robot in robots for topic in _ROS_GOALS]
        yield Rule(f"{who} by topics", ("put",), "ingress", tuple(topics))
        advance = self._key(f"{WORLD}/time/advance/{member.name}")
        yield Rule(f"{member.name} advances time", ("query",), "ingress", (advance,))
        yield from self._trees(member.name, robots)
        if not member.robots:
            world = (self._key(f"{WORLD}/*/_action/*"), self._ros("simulate_steps/_action/*/*/*"))
            yield Rule("only operators command the world", ("query",), "ingress", world, deny=True)
            yield from self._planning()
        if member.services:
            keys = [self._key(f"{WORLD}/{name}") for name in member.services]
            keys += [self._ros(f"{name}/*/*") for name in member.services]
            yield Rule(f"{member.name} calls {', '.join(member.services)}", ("query",), "ingress", tuple(keys))

    def _reading(self) -> Iterator[Rule]:
        """Yield the rules of all clients: they read the simulation, and ROS's graph."""
        values = [f"{WORLD}/{name}" for name in (*_VALUES, *_READING)] + [f"*/{topic}" for topic in _TOPICS]
        got = [self._key(value) for value in (*values, "*/*/_action/status", "**/@adv/**")]
        ros = [f"{name}/*/*" for name in _READING] + [f"{node}/{name}/*/*" for node in _NODES for name in _OF_NODES]
        tokens = (self._key("**"), self._key("**/@adv/**"), self._tokens("**"), self._ros("**/@adv/**"))
        yield Rule(READING, ("query",), "ingress", (*got, *map(self._ros, [*ros, "**/@adv/**"])))
        yield Rule("all subscribe", ("declare_subscriber",), "ingress", self._all)
        yield Rule("all see who is there", ("declare_liveliness_subscriber", "liveliness_query"), "ingress", tokens)
        # `hmrsim doctor` looks for simulators with other prefixes, and for ROS nodes in other domains.
        yield Rule("all look around", ("liveliness_query",), "ingress", (f"**/{WORLD}/alive", "@ros2_lv/**"))
        told: tuple[Message, ...] = (
            "put",
            "delete",
            "reply",
            "declare_queryable",
            "declare_subscriber",
            "liveliness_token",
        )
        yield Rule("all are told", told, "egress", (*self._all, self._tokens("**")))
        nodes = tuple(self._tokens(f"*/*/*/{kind}/**") for kind in _ROS_TOKENS)
        yield Rule("all are nodes of ROS", ("liveliness_token",), "ingress", (*nodes, self._ros("**/@adv/**")))

    def _driving(self) -> Iterator[Rule]:
        """Yield the rules of all that drive robots: they take part in lockstep, and log as nodes of ROS do."""
        logs = tuple(self._ros(f"{name}/**") for name in _ROS_LOGS)
        yield Rule("controllers log to ROS", ("put",), "ingress", logs)
        requests = tuple(self._key(f"{WORLD}/time/{name}") for name in _JOINING)
        yield Rule("controllers join time", ("query",), "ingress", requests)
        yield Rule("controllers are participants", ("liveliness_token",), "ingress", (self._key("_participant/*"),))

    def _commands(self, robot: str) -> Iterable[str]:
        """Return the keys of a robot's actions, and of the services of its ROS nodes."""
        return (self._key(f"{robot}/*/_action/*"), self._ros(f"{robot}/*/_action/*/*/*"), self._ros(f"{robot}/*/*/*/*"))

    def _trees(self, who: str, robots: tuple[str, ...]) -> Iterator[Rule]:
        """Yield the rules of publishing behavior trees; those of other robots can't be published, only queried."""
        trees = (self._key("*/_tree"), self._key("*/_tree/@adv/**"))
        own = [self._key(f"{robot}/{tree}") for robot in robots for tree in ("_tree", "_tree/@adv/**")]
        yield Rule(f"{who} publishes trees", ("put", "delete", "reply"), "ingress", tuple(own))
        yield Rule("controllers answer for trees", ("declare_queryable",), "ingress", trees)
        yield Rule("controllers are asked for trees", ("query",), "egress", trees)

    def _planning(self) -> Iterator[Rule]:
        key = (self._key("_planner/**"),)
        yield Rule("planners plan", ("declare_queryable", "reply"), "ingress", key)
        yield Rule("planners are asked", ("query",), "egress", key)

    @property
    def _all(self) -> tuple[str, ...]:
        return (self._key("**"), self._key("**/@adv/**"), self._ros("**"), self._ros("**/@adv/**"))

    def _key(self, rest: str) -> str:
        return f"{self.prefix}/{rest}"

    def _ros(self, rest: str) -> str:
        return f"{self.domain}/{rest}"

    def _tokens(self, rest: str) -> str:
        return f"@ros2_lv/{self.domain}/{rest}"

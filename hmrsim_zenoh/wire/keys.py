"""The spelling and parsing of keys; no other module handles a ``/``.

::

    <prefix>/<robot>/<action>/_action/{send_goal,cancel_goal,get_result,execute,feedback,status}
    <prefix>/<robot>/<topic>
    <prefix>/_world/<topic or service>
    <prefix>/<robot>/alive, <prefix>/_world/alive                           liveliness tokens
    <prefix>/_participant/<name>                                            liveliness tokens of lockstep's participants
    <prefix>/_planner/compute_path_to_pose                                  the queryable of an external planner
    <prefix>/<robot>/_tree                                                  the state of a controller's tree
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Final

from hmrsim.protocol.goal import WORLD

DEFAULT_PREFIX = "hmrsim"
TREE = "_tree"
"""The topic of a robot's tree, which a controller publishes."""

_ACTION = "_action"
HISTORY: Final = "@adv"
"""The chunk after a key where Zenoh's advanced subscribers query earlier samples."""

_PREFIX = re.compile(r"[A-Za-z0-9_.~-]+(/[A-Za-z0-9_.~-]+)*")


class Verb(Enum):
    """The verbs of an action's keys."""

    SEND_GOAL = "send_goal"
    CANCEL_GOAL = "cancel_goal"
    GET_RESULT = "get_result"
    EXECUTE = "execute"
    FEEDBACK = "feedback"
    STATUS = "status"


_VERBS = {verb.value: verb for verb in Verb}


@dataclass(frozen=True)
class ActionKey:
    """The parts of an action's key; an alias is resolved already."""

    robot: str
    action: str
    verb: Verb


@dataclass(frozen=True)
class TopicKey:
    """The parts of a topic's or a service's key; *robot* is `WORLD` for the world's."""

    robot: str
    topic: str


@dataclass(frozen=True)
class Keys:
    """The keys of one simulation.

    Attributes:
        prefix: The prefix of all its keys: one chunk or more.
        aliases: Further names of actions, ``a/b`` to ``robot/action``.

    Raises:
        ValueError: *prefix* is not a plain key.
    """

    prefix: str = DEFAULT_PREFIX
    aliases: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the prefix."""
        if not _PREFIX.fullmatch(self.prefix):
            raise ValueError(f"prefix {self.prefix!r} is not a plain key, such as 'hmrsim' or 'lab/hmrsim'")

    def action(self, robot: str, action: str, verb: Verb) -> str:
        """Return the key of one verb of a robot's action."""
        return f"{self.prefix}/{robot}/{action}/{_ACTION}/{verb.value}"

    def names(self, robot: str, action: str) -> tuple[tuple[str, str], ...]:
        """Return all (robot, action) names of a robot's action, the real one first."""
        return ((robot, action), *self._further.get(f"{robot}/{action}", ()))

    @cached_property
    def _further(self) -> dict[str, list[tuple[str, str]]]:
        """The aliases by their targets, cached as every publication needs them."""
        found: dict[str, list[tuple[str, str]]] = {}
        for alias, target in self.aliases.items():
            first, _, second = alias.partition("/")
            found.setdefault(target, []).append((first, second))
        return found

    def topic(self, robot: str, topic: str) -> str:
        """Return the key of a robot's topic."""
        return f"{self.prefix}/{robot}/{topic}"

    def world(self, topic: str) -> str:
        """Return the key of one of the world's topics or services."""
        return f"{self.prefix}/{WORLD}/{topic}"

    def alive(self, robot: str = WORLD) -> str:
        """Return the liveliness token of a robot, or of the simulator."""
        return f"{self.prefix}/{robot}/alive"

    def claim(self, zid: str, state: str) -> str:
        """Return the liveliness token of a simulator that starts to serve the prefix, or serves it.

        Wildcards of clients do not match a chunk that begins with ``@``.
        """
        return f"{self.prefix}/@simulator/{zid}/{state}"

    def participant(self, name: str) -> str:
        """Return the liveliness token of a participant in lockstep."""
        return f"{self.prefix}/_participant/{name}"

    def planner(self) -> str:
        """Return the key of the external planner's queryable."""
        return f"{self.prefix}/_planner/compute_path_to_pose"

    def tree(self, robot: str) -> str:
        """Return the key on which a controller publishes the state of a robot's tree."""
        return self.topic(robot, TREE)

    def trees(self) -> str:
        """Return the wildcard of all robots' trees."""
        return self.any_topic(TREE)

    def wakeup_key(self) -> str:
        """Return a key without answers: a query on it wakes the simulation thread."""
        return self.world("_doorbell")

    def history(self) -> str:
        """Return the wildcard on which Zenoh's advanced subscribers query earlier samples."""
        return self.history_of(self.everything())

    def history_of(self, key: str) -> str:
        """Return the wildcard on which they query earlier samples of a key."""
        return f"{key}/{HISTORY}/**"

    def without_history(self, key: str) -> str:
        """Return the key whose history an advanced subscriber queries; any other key unchanged."""
        return key.partition(f"/{HISTORY}")[0]

    def everything(self) -> str:
        """Return the wildcard that all keys of the simulation match."""
        return f"{self.prefix}/**"

    def any_action(self, verb: Verb) -> str:
        """Return the wildcard for one verb of all actions of all robots."""
        return self.action("*", "*", verb)

    def any_topic(self, topic: str) -> str:
        """Return the wildcard for one topic of all robots."""
        return self.topic("*", topic)

    def owner(self, key: str) -> str:
        """Return a key's robot, or the chunk in its place."""
        return key[len(self.prefix) + 1 :].partition("/")[0]

    def resolve(self, robot: str, action: str) -> tuple[str, str]:
        """Return the real names of a robot and its action for a name or an alias."""
        robot, _, action = self.aliases.get(f"{robot}/{action}", f"{robot}/{action}").partition("/")
        return robot, action

    def participants(self) -> str:
        """Return the wildcard of all participants' liveliness tokens."""
        return self.participant("*")

    def parse(self, key: str) -> ActionKey | TopicKey | None:
        """Parse a key; None when it does not belong to this simulation."""
        head, tail = key[: len(self.prefix) + 1], key[len(self.prefix) + 1 :]
        if head != f"{self.prefix}/":
            return None
        first, *rest = tail.split("/")
        match rest:
            case [topic]:
                return TopicKey(first, topic)
            case [second, "_action", verb] if verb in _VERBS:
                return ActionKey(*self.resolve(first, second), _VERBS[verb])
            case _ if first == WORLD:
                return TopicKey(first, "/".join(rest))
        return None


_ANY: Final = "**"


def servers_own(key_expr: str) -> str:
    """Return another spelling of a key expression with wildcards, which matches the same keys.

    Zenoh 1.10 keeps 2.7 kB for each closed session as long as the server itself holds the same key expression with
    wildcards that the session had subscribed to, so that short sessions would fill memory. So the server
    declares publishers and queryables not on ``hmrsim/**`` or ``hmrsim/*/odom``, but on ``hmrsim/*/**`` and
    ``hmrsim/*/$*odom``.

    Args:
        key_expr: A canonical key expression. It is returned as it is if it has no wildcard, or nothing but ``*``
            after the first one.
    """
    chunks = key_expr.split("/")
    if _ANY in chunks:
        chunks.insert(chunks.index(_ANY), "*")
        return "/".join(chunks)
    wild = False
    last = None
    for at, chunk in enumerate(chunks):
        if "*" in chunk:
            wild = True
        elif wild:
            last = at
    if last is not None:
        chunks[last] = f"$*{chunks[last]}"
    return "/".join(chunks)

"""Action servers, the goals of each, and the validation of requests.

This is bookkeeping only: `hmrsim.goals.dispatcher` decides about goals.
"""

from __future__ import annotations

import itertools
from collections import OrderedDict, defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Final, Protocol

from hmrsim.actions import FRAMES, Flaw, unknown_frame
from hmrsim.diagnostics import instead
from hmrsim.engine.internal_errors import BUGS
from hmrsim.errors import GoalRejected
from hmrsim.events.goals import GoalAccepted
from hmrsim.interfaces.quantities import flaw
from hmrsim.protocol.goal import WORLD, ZERO_ID, GoalEntry, GoalStatus, Verdict, made_goal_id, parse_goal_id

if TYPE_CHECKING:
    import simpy

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.commands import CancelGoal, SendGoal

MAX_FORGOTTEN: Final = 10_000
"""The goals of all robots whose ids are refused although their results are no longer kept: the latest ones."""


class Owner(Protocol):
    """An owner of action servers: a robot, or the world."""

    @property
    def name(self) -> str:
        """The name in the world file."""

    @property
    def components(self) -> Mapping[str, Any]:
        """The components, on which some actions depend."""

    @property
    def disabled_reasons(self) -> Mapping[str, str]:
        """Why it is disabled, by cause; empty while it is not."""

    def act(
        self, action: str, ended: GoalStatus | None = None, *, holds: bool = True, in_real_time: bool = False
    ) -> None:
        """Record that a goal of an action begins, or the outcome of its end.

        A goal *holds* the robot's base or its action, or nothing. A client *in_real_time* sends its next goal some time
        after this one has ended.
        """


@dataclass(eq=False, slots=True)
class ServedGoal:
    """An accepted goal; it holds little data, since many goals are kept after their end.

    Attributes:
        goal_id: 32 hex digits.
        stamp: When it was accepted.
        from_client: Whether the client made the id, and so may send it again.
        in_real_time: Whether the client sends its next goal some time after this one has ended.
        ended: When it ended, in simulated nanoseconds; None while it is active.
        message: The goal message; None after the end.
        process: The process that executes the goal; None once it has ended.
        waiting: The requests for its result, by their id, as not all are hashable.
        sample: Returns feedback; None for none, and after the end.
        sampled_from: The time since which it is sampled.
        failure: Makes the result if it does not succeed; None for the action's own.
        cause: Why it did not succeed; empty if it has, or is active.
        listed: Its entry in the last status list; the same object as long as it is unchanged.
    """

    server: ActionServer
    goal_id: str
    stamp: int
    from_client: bool
    in_real_time: bool
    status: GoalStatus = GoalStatus.ACCEPTED
    ended: int | None = None
    message: Message | None = None
    process: simpy.Process | None = None
    waiting: dict[int, Any] = field(default_factory=dict)
    sample: Callable[[], Message | Mapping[str, Any]] | None = None
    sampled_from: float = 0.0
    failure: Callable[[int, str], Message] | None = None
    cause: str = ""
    listed: GoalEntry | None = None
    _result: Message | bytes | None = field(default=None, init=False)

    @property
    def result(self) -> Message | None:
        """The result of the goal; None while it is active."""
        kept = self._result
        if isinstance(kept, bytes):
            packed: Message = self.server.action.result.model_validate_json(kept)
            return packed
        return kept

    def end(self, stamp: int, result: Message, cause: str) -> None:
        """Record the end of the goal, its result and its cause, and drop the data of active goals."""
        self.ended, self._result, self.failure, self.message = stamp, result, None, None
        self.cause = cause

    def pack_result(self, latest: Message) -> None:
        """Hold the result as text, in a tenth of the memory, if it can be read again and is not the *latest*, too."""
        kept = self._result
        if kept is None or kept is latest or isinstance(kept, bytes) or type(kept) is not self.server.action.result:
            return
        try:
            text = kept.model_dump_json(warnings=False).encode()
            _check_readable(type(kept), text)
        except BUGS:
            # The type is a plug-in's, and need not be as strict with what it is made of.
            return
        self._result = text

    def failed(self, code: int, message: str) -> Message:
        """Return the result of a goal that did not succeed."""
        made: Message = (self.failure or self.server.action.failure)(code, message)
        return made

    def accepted(self) -> GoalAccepted:
        """Return the event of the acceptance, with the fields of the goal message that were set."""
        asked = self.message.model_dump(mode="json", exclude_unset=True) if self.message else None
        return GoalAccepted(self.server.robot.name, self.server.action.name, self.goal_id, asked)

    def entry(self) -> GoalEntry:
        """Return its entry in a status list."""
        if self.listed is None or self.listed.status is not self.status:
            self.listed = GoalEntry(self.goal_id, self.stamp, self.status)
        return self.listed


@lru_cache(256)
def _check_readable(kind: type[Message], text: bytes) -> None:
    """Check that a text can be read as a message of a type; most results of an action have the same text."""
    kind.model_validate_json(text)


@dataclass(eq=False, slots=True)
class ActionServer:
    """One action of one robot, and its goals in order of acceptance.

    Attributes:
        number: The unique number of the goal.
        goals: The goals that are kept, by id.
        needs: The resource that one goal at a time can hold: the robot's base or the action itself; empty for none.
    """

    robot: Owner
    action: AnyAction
    number: int
    goals: dict[str, ServedGoal] = field(default_factory=dict)
    needs: str = field(init=False)

    def __post_init__(self) -> None:
        """Derive the name of the resource that goals of this server need."""
        name, action = self.robot.name, self.action
        self.needs = name if action.holds_base else f"{name}/{action.name}" if action.exclusive else ""


class ActionServers:
    """The actions of all robots, and of the world.

    Args:
        seed: From which the ids of goals that have none are made.
    """

    def __init__(self, actions: Mapping[str, AnyAction], seed: str) -> None:
        self._actions = actions
        self._seed = seed
        self._robots: Mapping[str, Owner] = {}
        self._offered: dict[tuple[bool, *tuple[str, ...]], dict[str, AnyAction]] = {}
        self._servers: dict[tuple[str, str], ActionServer] = {}
        self._made: defaultdict[tuple[str, str], int] = defaultdict(int)
        self._numbers = itertools.count()
        self._forgotten: OrderedDict[str, GoalStatus] = OrderedDict()

    def reseed(self, seed: str) -> None:
        """Generate the ids of goals from another seed from now on."""
        self._seed = seed

    def serve(self, robots: Mapping[str, Owner]) -> list[str]:
        """Serve exactly these owners, with all actions that their components allow.

        Returns:
            The names of those that are served no longer; their goals are forgotten.
        """
        gone = [name for name, robot in self._robots.items() if robots.get(name) is not robot]
        self._robots = robots
        self._servers = {key: server for key, server in self._servers.items() if key[0] not in gone}
        return gone

    def serves(self, robot: str) -> bool:
        """Return whether there is a robot of this name."""
        return robot in self._robots

    def actions_of(self, robot: str) -> list[str]:
        """Return the names of the actions that a robot serves."""
        return list(self._offers(self._robots[robot]))

    def _offers(self, robot: Owner) -> dict[str, AnyAction]:
        """Return the actions that a robot serves; one table for all robots with the same components."""
        carried, of_world = tuple(robot.components), robot.name == WORLD
        if (of_world, *carried) not in self._offered:
            self._offered[of_world, *carried] = {
                name: action
                for name, action in self._actions.items()
                if action.of_world == of_world and (action.component is None or action.component in carried)
            }
        return self._offered[of_world, *carried]

    def find(self, robot: str, action: str) -> ActionServer:
        """Return the server of an action; created on first use, as most are never used.

        Raises:
            GoalRejected: There is no such robot or action.
        """
        server = self._servers.get((robot, action))
        if server is not None:
            return server
        if robot not in self._robots:
            robots = sorted(name for name in self._robots if name != WORLD)
            raise GoalRejected("unknown_robot", f"no robot {robot!r}{instead(robot, robots, verb='there are:')}")
        offers = self._offers(self._robots[robot])
        if action not in offers:
            known = self._actions.get(action)
            needs = f", which needs the component {known.component!r}" if known and known.component else ""
            there = ", ".join(offers)
            raise GoalRejected("unknown_action", f"{robot} has no action {action!r}{needs}; it has: {there}")
        server = self._servers[robot, action] = ActionServer(self._robots[robot], offers[action], next(self._numbers))
        return server

    def goal_id(self, server: ActionServer, text: str | None) -> str:
        """Return an id in its canonical form; if it is empty, a new one derived from the seed.

        Raises:
            GoalRejected: It is not an id.
        """
        if text is None:
            whose = (server.robot.name, server.action.name)
            self._made[whose] += 1
            return made_goal_id("/".join((self._seed, *whose)), self._made[whose])
        try:
            goal_id = parse_goal_id(text)
        except ValueError as error:
            raise GoalRejected("invalid_goal_id", str(error)) from None
        if goal_id == ZERO_ID:
            raise GoalRejected("invalid_goal_id", "the goal id is zero, which stands for all goals; make another")
        return goal_id

    def acceptable(self, server: ActionServer, command: SendGoal) -> Message:
        """Return the goal message of a request that can be accepted.

        Raises:
            GoalRejected: It can't.
        """
        action = server.action
        if not isinstance(command.goal, action.goal):
            raise GoalRejected("invalid_goal", f"{command.goal!r} is no {action.goal.ros_type}")
        codes, early = action.codes, action.rejects_early
        if wrong := flaw(command.goal):
            raise GoalRejected("invalid_goal", wrong, codes.unknown)
        if command.verdict is Verdict.REJECT or not action.skips_frames:
            for frame in action.frames(command.goal):
                if frame not in FRAMES:
                    code = codes.unknown if codes.tf_error is None else codes.tf_error
                    raise GoalRejected("invalid_goal", unknown_frame(frame), code, early="frames" in early)
        if invalid := action.flaw(command.goal):
            text, code = invalid if isinstance(invalid, Flaw) else (invalid, codes.unknown)
            raise GoalRejected("invalid_goal", text, code, early="flaw" in early)
        robot, disabled = server.robot, ""
        if robot.disabled_reasons:
            disabled = next((why for cause, why in robot.disabled_reasons.items() if action.disabled_by(cause)), "")
        if reason := disabled or action.not_ready(robot):
            raise GoalRejected("not_ready", reason, codes.unknown)
        goal: Message = command.goal
        return goal

    def rejected_code(self, action: str) -> int:
        """Return the code of a rejected goal, also for an unknown action."""
        known = self._actions.get(action)
        return known.codes.rejected if known else 1

    def goal(self, robot: str, action: str, goal_id: str) -> ServedGoal | None:
        """Return a goal; None if it is unknown or forgotten."""
        server = self._servers.get((robot, action))
        return server.goals.get(goal_id) if server else None

    def forget(self, goal: ServedGoal) -> None:
        """Drop a goal, but remember how it ended, for `forgotten`."""
        del goal.server.goals[goal.goal_id]
        # A made id is not sent again.
        if goal.from_client:
            self._forgotten[_key(goal.server, goal.goal_id)] = goal.status
            if len(self._forgotten) > MAX_FORGOTTEN:
                self._forgotten.popitem(last=False)

    def forgotten(self, server: ActionServer, goal_id: str) -> GoalStatus | None:
        """Return how a dropped goal ended, so that a late repetition of its request is not executed again."""
        return self._forgotten.get(_key(server, goal_id)) if self._forgotten else None

    def of(self, robot: str) -> list[ActionServer]:
        """Return the actions of a robot for which there have been goals, in order of name."""
        return [server for (name, _), server in sorted(self._servers.items(), key=itemgetter(0)) if name == robot]

    def all(self) -> Iterator[ServedGoal]:
        """Yield all goals of all robots that have not been dropped."""
        for server in self._servers.values():
            yield from server.goals.values()

    def active(self, robot: str | None = None) -> Iterator[ServedGoal]:
        """Yield the active goals of one robot or of all, in the order of names and not of requests."""
        for (name, _), server in sorted(self._servers.items(), key=itemgetter(0)):
            if robot in (None, name):
                yield from (goal for goal in server.goals.values() if not goal.status.terminal)


def selects(command: CancelGoal, goal: ServedGoal) -> bool:
    """Return whether a cancel request selects a goal, by the rules of action_msgs/srv/CancelGoal."""
    if not goal.status.cancelable:
        return False
    if goal.goal_id == command.goal_id:
        return True
    if command.stamp:
        return goal.stamp <= command.stamp
    return command.goal_id == ZERO_ID


def as_answered(goal_id: str | None) -> str:
    """Return an id as in answers, without hyphens; a text that is not an id is returned unchanged."""
    try:
        return parse_goal_id(goal_id or "")
    except ValueError:
        return goal_id or ""


def _key(server: ActionServer, goal_id: str) -> str:
    """Return a compact key for a goal that has been forgotten."""
    return f"{server.number}/{goal_id}"

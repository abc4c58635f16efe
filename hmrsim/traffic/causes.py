"""The causes for which robots make no progress: chains from a robot to the one that holds all others up, with a remedy.

Robot A waits for B, which waits for a closed lane: that is a chain of two links.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple

from hmrsim.diagnostics import listed

if TYPE_CHECKING:
    from hmrsim.traffic.lane_closures import Barriers, LaneClosures
    from hmrsim.traffic.rules import Rules, Vehicle, Wait
    from hmrsim.world.model import World

Kind = Literal["robots", "queue", "obstacle", "turn", "circle", "disabled", "docked", "works", "drives", "idle"]
"""The kind of a cause. A robot is held up by other robots, the queue of a dock, an obstacle such as a door or a closed
lane, or robots whose turn it is, or it waits in a circle. A robot that nothing holds up is disabled, docked, works on a
goal, drives or is idle."""

_MAX_SHOWN: Final = 4
"""The number of links that a message shows; of a longer chain, it shows the first ones and the last."""

_HELP: Final[Mapping[str, str]] = {
    "docked": "have its controller undock it once it is charged, add docks, or move the dock off the route; no policy "
    "moves a docked robot",
    "works": "wait until its goal has ended, or cancel it",
    "drives": "more time, because it is moving",
    "turn": "nothing: robots that set out earlier, or move to make room, go first",
}
_NO_GOAL: Final = (
    "its controller has to send it a goal. If it waits for something that can't happen, it ends with an error that "
    "names the waiting lines when you run it in lockstep: `hmrsim run WORLD --clock lockstep`"
)
_OFFLINE: Final = "restore its connection, so that goals reach it: `hmrsim fault list` names the fault"


class Link(NamedTuple):
    """A link of a chain of causes: the obstacle of one robot or, if it has none, its activity.

    Attributes:
        robot: The name of the robot.
        kind: The kind of the cause.
        text: A sentence about the robot: where it is, what it waits for, and since when in simulated seconds.
        held_by: The robots in its way, by name.
        next: The robot whose link is the cause of this one; empty in the last link.
        help: A remedy if this is the last link.
    """

    robot: str
    kind: Kind
    text: str
    held_by: tuple[str, ...] = ()
    next: str = ""
    help: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return the link as JSON values."""
        return {**self._asdict(), "held_by": [*self.held_by]}


class Chain(NamedTuple):
    """The chain of causes for which a robot makes no progress; each link causes the one before it.

    Attributes:
        links: The links; for a robot that nothing holds up, a single one with its activity.
        help: A remedy for the last cause.
    """

    links: tuple[Link, ...]
    help: str

    def __str__(self) -> str:
        """Return the causes and the remedy as a message."""
        texts = [link.text for link in self.links]
        if (hidden := len(texts) - _MAX_SHOWN) > 0:
            texts[_MAX_SHOWN - 1 : -1] = [f"… {hidden} more …"]
        return "; ".join([*texts, f"what would help: {self.help}"])


def chain_of(robot: str, link_of: Callable[[str], Link]) -> Chain:
    """Return the chain of causes for a robot; its last link may close a circle."""
    link = link_of(robot)
    links = {robot: link}
    while link.next and link.next not in links:
        link = link_of(link.next)
        links[link.robot] = link
    if link.next:
        names = [*links]
        circle = " → ".join([*names[names.index(link.next) :], link.next])
        links[link.robot] = link._replace(kind="circle", text=f"{link.text}, which closes a circle: {circle}")
    alone = len(links) == 1 and link.kind == "idle" and "it has had no goal" in link.text
    return Chain(tuple(links.values()), _NO_GOAL if alone else link.help)


class _Queue(NamedTuple):
    """The place of a vehicle in the queue of a dock: since when, and the vehicles that occupy the dock."""

    dock: str
    since: float
    holders: Callable[[], Sequence[Vehicle]]


class Causes:
    """Finds the causes for which vehicles of a world make no progress.

    Args:
        vehicles: All vehicles.
        waits: The vehicles that wait for the right of way.
        rules: The rules of the traffic policy; None if no vehicle can block another.

    Attributes:
        places: The names of the world's points.
    """

    def __init__(
        self,
        world: World,
        vehicles: Collection[Vehicle],
        waits: Mapping[Vehicle, Wait],
        rules: Rules | None,
        closures: LaneClosures,
        barriers: Barriers,
    ) -> None:
        self._world = world
        self._vehicles = vehicles
        self._waits = waits
        self._rules = rules
        self._closures = closures
        self._barriers = barriers
        self._queues: dict[Vehicle, _Queue] = {}
        self._given_up: dict[str, Link] = {}
        self._gave_up_at = -1.0
        self.places = world.place_names

    def queue(self, robot: Vehicle, dock: str, since: float, holders: Callable[[], Sequence[Vehicle]]) -> None:
        """Record that a vehicle queues for a dock until one of its *holders* leaves."""
        self._queues[robot] = _Queue(dock, since, holders)

    def unqueue(self, robot: Vehicle) -> None:
        """Record that a vehicle has left its queue, if it was in one."""
        self._queues.pop(robot, None)

    def is_held_up(self, robot: Vehicle) -> bool:
        """Return whether a vehicle waits for the right of way or in a queue."""
        return robot.waits or robot in self._queues

    def blockers(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles for which a vehicle waits; none if it does not wait for vehicles."""
        if robot in self._queues:
            return self._queues[robot].holders()
        wait = self._waits.get(robot)
        return self._rules.blockers(robot, wait.leg) if wait and not wait.why and self._rules else ()

    def behind_barrier(self, robot: Vehicle) -> Sequence[Vehicle]:
        """Return the vehicles beyond the barrier at which a vehicle waits: it can't pass while they stay there."""
        wait = self._waits.get(robot)
        if self._rules is None or wait is None or not wait.why or self.for_good(wait):
            return ()
        return self._rules.blockers(robot, wait.leg)

    def for_good(self, wait: Wait) -> bool:
        """Return whether a wait will not end by itself, so that the vehicle has to take another route."""
        lane = wait.leg.lane
        return lane is not None and (lane in self._closures.lanes or not self._barriers.may_pass(wait.robot, lane))

    def link(self, robot: Vehicle, offline: Collection[str] = ()) -> Link:
        """Return the link of a vehicle; *offline* has the names of vehicles that clients can't reach."""
        at = self.places.of(robot.pose().point)
        if robot.disabled_reasons or not self.is_held_up(robot):
            return self._activity(robot, at, offline)
        queue, wait = self._queues.get(robot), self._waits.get(robot)
        found = self.blockers(robot) or self.behind_barrier(robot)
        if queue is not None:
            text = f"{robot.name} has queued at {at} since {queue.since:g} s for {queue.dock!r}, taken by"
            return self._held_up(robot, "queue", text, found)
        waited = f"{robot.name} has waited at {at}" + ("" if wait is None else f" since {wait.since:g} s")
        if wait is not None and wait.why:
            return self._obstacle(wait, f"{waited}: {wait.why}", found)
        if found:
            return self._held_up(robot, "robots", f"{waited} for", found)
        ahead = tuple(other.name for other in self._rules.ahead_of(robot)) if self._rules else ()
        return Link(robot.name, "turn", f"{waited} for its turn", ahead, "", _HELP["turn"])

    def chain(self, robot: Vehicle) -> Chain:
        """Return the chain of causes for a vehicle."""
        vehicles = {each.name: each for each in self._vehicles}
        return chain_of(robot.name, lambda name: self._given_up.get(name) or self.link(vehicles[name]))

    def stuck(self) -> dict[str, str]:
        """Return the chain of each vehicle that is held up, by name, as a message, unless its last cause will pass."""
        vehicles = {each.name: each for each in self._vehicles}
        link_of = cache(lambda name: self.link(vehicles[name]))
        chains = {name: chain_of(name, link_of) for name, each in vehicles.items() if self.is_held_up(each)}
        passing = ("drives", "turn")
        return {name: str(chain) for name, chain in chains.items() if chain.links[-1].kind not in passing}

    def give_up(self, robot: Vehicle, now: float) -> Chain:
        """Return the chain of causes for a vehicle that gives up waiting.

        Chains of vehicles that give up at the same instant have the same end, even though the first ones move on.
        """
        if now != self._gave_up_at:
            self._given_up, self._gave_up_at = {}, now
        chain = self.chain(robot)
        self._given_up[robot.name] = chain.links[0]
        return chain

    @property
    def help_in_circle(self) -> str:
        """A remedy for vehicles that wait for each other."""
        better = "" if self._yields else "; or use the traffic policy `planned`, which resolves most circles"
        return f"send one of them elsewhere, or add room where two can pass{better}"

    @property
    def _yields(self) -> bool:
        """True if idle vehicles make room under the world's policy; False for a policy from a plug-in."""
        return self._world.policy in ("priority", "planned")

    def _held_up(self, robot: Vehicle, kind: Kind, text: str, found: Sequence[Vehicle]) -> Link:
        """Return the link of a vehicle that others hold up; the next link is the first of them that does not move."""
        others = sorted(found, key=lambda other: other.name)
        names = tuple(other.name for other in others)
        following = next((other for other in others if not other.moves), others[0])
        stays = ""
        if kind == "robots" and self._rules is not None and following.stands and not self.is_held_up(following):
            stays = f", {'which' if len(names) == 1 else following.name} {self._rules.why_stays(following, robot)}"
        return Link(robot.name, kind, f"{text} {listed(names)}{stays}", names, following.name, self.help_in_circle)

    def _obstacle(self, wait: Wait, text: str, beyond: Sequence[Vehicle]) -> Link:
        """Return the link of a vehicle that waits at a closed lane, a door or a lift."""
        lane = wait.leg.lane
        robots = [each.name for each in self._vehicles if self._closures.is_closed_by(lane, each.name)]
        if beyond:
            text = f"{text}; beyond is {listed(sorted(each.name for each in beyond))}"
            robots += sorted(each.name for each in beyond)
        closed = self._closures.lanes.get(lane, {}) if lane else {}
        if closed:
            remedy = " and ".join(dict.fromkeys(_opening(*each) for each in closed.items()))
        elif self.for_good(wait):
            remedy = "send a robot that the door opens for, or add this one to `opens_for` of the door"
        else:
            remedy = "nothing: it opens, or comes, by itself"
        return Link(wait.robot.name, "obstacle", text, tuple(robots), robots[0] if robots else "", remedy)

    def _activity(self, robot: Vehicle, at: str, offline: Collection[str]) -> Link:
        """Return the link of a vehicle that nothing holds up."""
        kind, words, detail = robot.activity
        if kind == "disabled":
            charge = "charge it in time, or move it to a charger"
            broken = "end the fault: `hmrsim fault clear`; or send another robot"
            remedy = charge if "battery_empty" in robot.disabled_reasons else broken
        elif kind == "idle":
            detail, remedy = self._idle(robot, detail, offline)
        else:
            remedy = _HELP[kind]
        text = f"{robot.name} {words} at {at}" + (f": {detail}" if detail else "")
        return Link(robot.name, kind, text, help=remedy)

    def _idle(self, robot: Vehicle, detail: str, offline: Collection[str]) -> tuple[str, str]:
        if robot.name in offline:
            return "its connection is lost", _OFFLINE
        better = "or use the traffic policy `planned`, under which idle robots make room"
        park = f"send {robot.name} elsewhere when it has nothing to do"
        if self._yields:
            better = "or add a waypoint where it can move aside"
        # Most idle vehicles are in no other one's way.
        waiting = self._waiting_for(robot)
        shut_in_by = self._rules.shut_in_by(robot) if waiting and self._rules is not None else ()
        others = [each.name for each in shut_in_by if each not in waiting]
        if waiting and not others and (past := self._way_past(waiting[0], robot, shut_in=bool(shut_in_by))):
            return detail, past if self._yields else f"{past}; {better}"
        if others and not any(each.moves for each in shut_in_by):
            park = f"send {' and '.join(others)} elsewhere first, as {robot.name} can't leave before"
        return detail, f"{park}, {better}"

    def _waiting_for(self, robot: Vehicle) -> list[Vehicle]:
        """Return the vehicles that wait for a vehicle."""
        others = self._rules.waiting_for(robot) if self._rules is not None else ()
        return [each for each in others if robot in self.blockers(each)]

    def _way_past(self, robot: Vehicle, other: Vehicle, *, shut_in: bool) -> str:
        """Return the remedy for a vehicle that waits for an idle one which can't leave first; empty if that one can.

        *shut_in* says whether it can't leave at all.
        """
        behind = [robot]
        for each in behind:
            behind += [late for late in self._waiting_for(each) if late not in behind]
        before = [each for each in self.blockers(robot) if each.may_yield and each not in behind]
        if self._rules is None:
            return ""
        moves = self._rules.moves_past([*behind, *before])
        waiting = self._waiting_for(other)
        if not moves and shut_in and any([*self._rules.shut_in_by(each)] == [other] for each in waiting):
            names = listed(sorted(each.name for each in [*waiting, other]))
            return (
                f"add a waypoint where one can move aside: {names} can't pass each other here, and have nowhere else "
                "to go; `hmrsim map validate --traffic WORLD` names such tracks"
            )
        if not moves and shut_in:
            order = ", then ".join(each.name for each in reversed(behind))
            return (
                f"send {order} elsewhere, then {other.name}, which can't leave before: they can't pass each other here "
                "unless you add a waypoint where one can move aside"
            )
        if not moves or moves[0][0] in before:
            return ""
        # Of several moves in a row, the last one counts.
        turns = [[*turn][-1] for _, turn in groupby(moves, key=itemgetter(0))]
        *aside, _ = [f"{each.name} to {self.places.of(to)}" for each, to in turns]
        steps = ", then ".join([*aside, f"{robot.name} to its goal again"])
        return f"send {steps}: {other.name} can't leave before {robot.name}"


def _opening(cause: str, why: str) -> str:
    """Return what opens a lane that is closed for a cause of `LaneClosures`."""
    kind, _, name = cause.partition(" ")
    if kind == "fault":
        return f"end the fault: `hmrsim fault clear {name}`"
    if kind == "lift":
        return "end the fault: `hmrsim fault clear lift_out_of_order`"
    if kind != "door":
        return "remove what is in the way, or pick it up"
    if "jammed" in why:
        return "end the fault: `hmrsim fault clear door_jammed`"
    return f"open the door: `hmrsim service call /_world/set_door_state '{{name: {name}, state: open}}'`"

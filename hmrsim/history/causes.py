"""Why robots wait: the chain of causes from a robot to the one that starts it, and what would help."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

from hmrsim.geometry import PlaceNames
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from typing import Self

    from hmrsim.geometry import Point

Kind = Literal["robot", "obstacle", "queue", "disabled", "idle", "works", "drives", "cycle"]
"""What holds a robot up: other robots, an obstacle such as a door or a closed lane, or the queue of a dock. The last
link of a chain is an obstacle, or a robot that is disabled, idle, works, drives, or closes a circle."""

_HELP: Final[Mapping[str, str]] = {
    "obstacle": "it ends by itself, or with the fault that causes it: `hmrsim fault list`",
    "disabled": "clear the fault with `hmrsim fault clear`, charge the robot, or send another one",
    "idle": "send it away, since it has no goal. Under the traffic policies `priority` and `planned`, idle robots make "
    "room where they can",
    "works": "wait until its goal has ended, or cancel it",
    "drives": "nothing: it moves, and will clear the way",
    "cycle": "the robots wait for each other: cancel the goal of one and send it elsewhere, or use the traffic policy "
    "`planned`, which resolves what `reserve` and `priority` can't",
}
_NO_GOAL: Final = "it waits for nothing but a goal from its controller"


@dataclass(frozen=True)
class Standing:
    """What is known of a robot at an instant.

    Attributes:
        robot: Its name.
        at: Where it is, as text.
        goals: The actions that it executes.
        disabled: Why it can do nothing, such as the name of a fault; empty if it can.
        offline: Whether its connection is lost: it gets no goal, but continues the one that it has.
        moves: Whether it drives now.
        dock: The dock at which it is; empty if it is at none.
        since: When it began to wait, in simulated seconds; None while it does not.
        waits_for: The robots in its way, in the order of their names.
        why: The reason why it waits if it is not robots, such as a door that opens.
        queue: The dock for which it queues; empty if it does not.
    """

    robot: str
    at: str
    goals: tuple[str, ...] = ()
    disabled: tuple[str, ...] = ()
    offline: bool = False
    moves: bool = False
    dock: str = ""
    since: float | None = None
    waits_for: tuple[str, ...] = ()
    why: str = ""
    queue: str = ""

    @classmethod
    def of_scene(cls, robot: Mapping[str, Any], queue: tuple[str, Sequence[str]], places: PlaceNames) -> Self:
        """Return what the scene of a simulation says of a robot.

        Args:
            robot: Its entry in ``_world/scene``.
            queue: The dock for which it queues, if any, and the robots that are docked there.
            places: The names of the world's points.
        """
        waiting = (robot.get("waiting") or {}) if robot["waits"] else {}
        dock, docked = queue
        return cls(
            robot["name"],
            places.of(tuple(robot["pose"][:2])),
            running_actions(robot),
            tuple(sorted(robot["ailments"])),
            not robot["connected"],
            robot["motion"] is not None,
            robot["dock"] or "",
            waiting.get("since"),
            tuple(waiting.get("for") or docked),
            waiting.get("why", ""),
            dock,
        )


@dataclass(frozen=True)
class Link:
    """One cause in a chain.

    Attributes:
        robot: The robot that it is about.
        kind: What it is.
        text: A sentence about the robot.
    """

    robot: str
    kind: Kind
    text: str


@dataclass(frozen=True)
class Chain:
    """The causes for which a robot waits, each the cause of the one before it.

    Attributes:
        links: The causes. For a robot that does not wait, one that says what it does.
        help: What would end the last cause.
    """

    links: tuple[Link, ...]
    help: str


def running_actions(robot: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the actions that a robot of a scene executes; the scene also has its last goal that has ended."""
    return tuple(goal["action"] for goal in robot["goals"] if not GoalStatus(goal["status"]).terminal)


def dock_queues(scene: Mapping[str, Any]) -> dict[str, tuple[str, list[str]]]:
    """Return, for each robot that queues for a dock, its name and the robots that are docked there."""
    queues: dict[str, tuple[str, list[str]]] = {}
    for fixture in scene["fixtures"]:
        tags = [tag.partition(":") for tag in fixture["tags"]]
        docked = [name for tag, _, name in tags if tag == "docked"]
        queues |= {name: (fixture["name"], docked) for tag, _, name in tags if tag == "queued"}
    return queues


def standings(scene: Mapping[str, Any], places: Mapping[str, Point]) -> dict[str, Standing]:
    """Return what a scene says of each robot, by name; *places* are the named points of its world."""
    queues, names = dock_queues(scene), PlaceNames(places)
    return {
        robot["name"]: Standing.of_scene(robot, queues.get(robot["name"], ("", ())), names) for robot in scene["robots"]
    }


def why_waits(robot: str, known: Mapping[str, Standing]) -> Chain:
    """Return the causes for which a robot waits.

    Of several robots in the way of one, the first by name is followed that does not just drive on.
    """
    links = [*_links(robot, known)]
    kind = links[-1].kind
    return Chain(tuple(links), _NO_GOAL if kind == "idle" and len(links) == 1 else _HELP[kind])


def _links(robot: str, known: Mapping[str, Standing]) -> Iterator[Link]:
    path: dict[str, None] = {}
    while True:
        here = known[robot]
        path[robot] = None
        others = [other for other in here.waits_for if other in known]
        if (here.since is None and not here.queue) or here.why or not others:
            yield _last(here)
            return
        robot = next((other for other in others if not known[other].moves), others[0])
        if robot in path:
            ring = [*path]
            circle = " → ".join([*ring[ring.index(robot) :], robot])
            yield Link(here.robot, "cycle", f"{here.robot} waits for {robot}, and so in a circle: {circle}")
            return
        what = f"queues for {here.queue}, taken by" if here.queue else "waits for"
        text = f"{here.robot} {what} {_listed(others)}{_since(here)}, at {here.at}"
        yield Link(here.robot, "queue" if here.queue else "robot", text)


def _last(here: Standing) -> Link:
    """Return the link of a robot that no other robot holds up."""
    at = f"at {here.dock or here.at}"
    if here.why:
        return Link(here.robot, "obstacle", f"{here.robot} waits {at}{_since(here)}: {here.why}")
    if here.disabled:
        return Link(here.robot, "disabled", f"{here.robot} is out of service {at}: {', '.join(here.disabled)}")
    if here.since is not None:
        return Link(here.robot, "works", f"{here.robot} waits {at}{_since(here)} for its turn")
    if here.moves:
        return Link(here.robot, "drives", f"{here.robot} drives, now {at}")
    if here.goals:
        return Link(here.robot, "works", f"{here.robot} executes {_listed(here.goals)} {at}")
    offline = ", and its connection is lost" if here.offline else ""
    return Link(here.robot, "idle", f"{here.robot} is idle {at}, without a goal{offline}")


def _since(here: Standing) -> str:
    return "" if here.since is None else f" since {here.since:g} s"


def _listed(names: Iterable[str]) -> str:
    return " and ".join(names)

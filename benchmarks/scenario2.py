"""Scenario 2 over the wire: what a goal costs, against the bare round trip of a Zenoh query."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from benchmarks._fleet import SIDE, grid_world
from benchmarks._report import Row
from benchmarks._timing import Rounds, Variant, interleaved, microseconds
from benchmarks._wire import BARE, BARE_PAYLOAD, GoalSender, answer, ask, served
from hmrsim.actions import registry
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import GetResult, SendGoal
from hmrsim.protocol.outputs import Answered
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world
from hmrsim_zenoh import Client

if TYPE_CHECKING:
    import zenoh

    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.topics import Topic
    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"rounds": 20, "crowd": 100}

_GOAL = {"pose": {"pose": {"position": {"x": 450.0, "y": 330.0}}}}
_HOME = {"pose": {"pose": {"position": {"x": 78.0, "y": 86.0}}}}
_DRIVE = "wall_e/navigate_to_pose"
_BARE = "bare query"
_FREE = RunSettings(real_time_factor=0.0, keep_results=10)
_PACED = RunSettings(real_time_factor=1.0, keep_results=10)


def run(*, rounds: int = 500, crowd: int = 1000, side: int = SIDE) -> list[Row]:
    """Return what goals cost, with nothing else to do and beside a crowd that keeps the simulation's thread busy."""
    return [*_with_nothing_else(rounds), *_beside(grid_world(crowd, side=side), rounds)]


def _with_nothing_else(rounds: int) -> list[Row]:
    world = load_world("scenario2").world
    with ExitStack() as stack:
        free, paced = (
            stack.enter_context(stack.enter_context(served(world, settings)).session()) for settings in (_FREE, _PACED)
        )
        client = stack.enter_context(Client(session=free))
        there, back, idle = GoalSender(free, _DRIVE, _GOAL), GoalSender(free, _DRIVE, _HOME), _waiter(free, "wall_e")
        on_time = _waiter(paced, "wall_e")
        drive = client.action_client("wall_e", registry()["navigate_to_pose"])
        here, fresh, scripted = _Here(world), _Fresh(world), _Scripted(world)
        took = interleaved(
            [
                _bare(free),
                Variant("two bare queries, right behind each other", lambda: _two_bare(free)),
                Variant("send_goal to accepted, idle", idle.accepted, idle.result),
                Variant("send_goal to accepted, paced", on_time.accepted, on_time.result),
                Variant("goal to result, one by one", there.one_by_one, back.right_behind),
                Variant("goal to result, right behind", there.right_behind, back.right_behind),
                Variant("goal to result, by execute", there.execute, back.right_behind),
                Variant(
                    "goal to result, by hmrsim_zenoh.Client",
                    lambda: drive.send_goal(NavigateToPose.Goal.model_validate(_GOAL)).result(),
                    back.right_behind,
                ),
                Variant(
                    "goal to result, by hmrsim_zenoh.Client, by execute",
                    lambda: drive.execute(NavigateToPose.Goal.model_validate(_GOAL)).result(),
                    back.right_behind,
                ),
                Variant("goal to result, in process", lambda: here.drive(_GOAL), lambda: here.drive(_HOME)),
                Variant("the first goal to its result, in process", fresh.drive, fresh.load),
                Variant("script of one goal, in process", scripted.run, scripted.load),
            ],
            rounds,
        )
    limits = {
        "send_goal to accepted, idle": 1.3,
        "goal to result, one by one": 2.5,
        "goal to result, right behind": 1.4,
        "goal to result, by execute": 1.35,
    }
    seconds = {"goal to result, in process": 300.0, "the first goal to its result, in process": 1500.0}
    return _rows(took, limits, seconds)


def _beside(world: World, rounds: int) -> list[Row]:
    """Return what it costs when all robots but one wander, so that the simulation's thread is never idle.

    The bare query goes to another process, which has nothing to do but runs on the same busy machine.
    """
    with ExitStack() as stack:
        crowd = len(world.robots)
        idle = stack.enter_context(stack.enter_context(served(grid_world(1, side=2), _FREE)).session())
        busy = stack.enter_context(stack.enter_context(served(world, _FREE, wandering=crowd - 1)).session())
        sender = _waiter(busy, "robot_0")
        name = f"send_goal to accepted, saturated by {crowd:,} robots"
        took = interleaved([_bare(idle, f"{_BARE} beside it"), Variant(name, sender.accepted, sender.result)], rounds)
    return _rows(took, {name: 1.8})


def _waiter(session: zenoh.Session, robot: str) -> GoalSender:
    """Return who sends goals that are over at once: a wait of no time."""
    return GoalSender(session, f"{robot}/wait")


def _bare(session: zenoh.Session, name: str = _BARE) -> Variant:
    return Variant(name, lambda: ask(session, BARE, BARE_PAYLOAD))


def _two_bare(session: zenoh.Session) -> None:
    """Return with the answers to two queries: what a goal and its result take at least, when they need two."""
    first, second = (session.get(BARE, payload=BARE_PAYLOAD) for _ in range(2))
    answer(second, BARE)
    answer(first, BARE)


def _rows(took: Rounds, ratios: Mapping[str, float], values: Mapping[str, float] = MappingProxyType({})) -> list[Row]:
    """Return a row a variant; the first is what the others are compared with.

    Args:
        took: The times of the variants.
        ratios: Targets of ratios, by variant.
        values: Targets of values in microseconds, by variant.
    """
    bare = next(iter(took.taken))
    return [
        Row(
            name,
            took.spread(name, microseconds),
            "µs",
            took.ratio(name, to=bare),
            at_most=values.get(name),
            ratio_at_most=ratios.get(name),
        )
        for name in took.taken
    ]


class _Here:
    """Scenario 2 in this process, driven by commands."""

    def __init__(self, world: World) -> None:
        self._simulator = Simulator(world, RunSettings(keep_results=10), [self])
        self._sent = 0
        self._results: list[object] = []

    def drive(self, goal: dict[str, Any]) -> None:
        """Send wall_e somewhere, and return when the result is there."""
        self._sent += 1
        goal_id = f"{self._sent:032x}"
        message = NavigateToPose.Goal.model_validate(goal)
        self._simulator.submit(SendGoal("wall_e", "navigate_to_pose", message, goal_id))
        self._simulator.submit(GetResult("wall_e", "navigate_to_pose", goal_id, self))
        self._simulator.run()
        self._results.pop()

    def emit(self, output: Output) -> None:
        """Keep the result of a goal."""
        if isinstance(output, Answered):
            self._results.append(output.answer)

    def wants(self, _topic: Topic) -> bool:
        """Return False: results come unasked."""
        return False


class _Fresh:
    """Scenario 2 in this process, where the first goal needs route planning."""

    def __init__(self, world: World) -> None:
        self._world = world
        self.load()

    def load(self) -> None:
        """Load the world again from its beginning."""
        self._here = _Here(self._world)

    def drive(self) -> None:
        """Send wall_e somewhere, and return when the result is there."""
        self._here.drive(_GOAL)


class _Scripted:
    """Scenario 2 in this process, whose robot has a script; it runs once, from the beginning of the world."""

    def __init__(self, world: World) -> None:
        robot = world.robots["wall_e"].model_copy(update={"script": ("Go goal",)})
        self._world = world.model_copy(update={"robots": {"wall_e": robot}})
        self.load()

    def load(self) -> None:
        """Begin anew, so that the way has to be found again, too."""
        self._simulator = Simulator(self._world)

    def run(self) -> None:
        """Run the script to its end."""
        self._simulator.run()

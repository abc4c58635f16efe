"""A run of a world within the process of a test, and its queries and checks."""

from __future__ import annotations

import asyncio
import inspect
import math
from collections import Counter
from collections.abc import Callable, Coroutine, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from bt_controller.coverage import TreeCoverage
from bt_controller.loading.trees import Plan, load, plan_of
from bt_controller.running.runner import run_tree
from hmrsim.actions import error_of
from hmrsim.actions import registry as actions
from hmrsim.diagnostics import known_name, listed
from hmrsim.errors import HmrsimError
from hmrsim.events import registry as events
from hmrsim.fault_search.schedule import DISTURBANCE, overlays_of, with_faults
from hmrsim.protocol.goal import WORLD, GoalStatus
from hmrsim.protocol.time import LOCKSTEP
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.demand import OrderState
from hmrsim.testing.record import Goal, Happening, Record
from hmrsim.trace.writer import DeferredTrace
from hmrsim.trials.controllers import play_async
from hmrsim.trials.local import LocalTrial
from hmrsim.trials.model import AnyWorld, read_world
from hmrsim_zenoh.client.commander import Commander
from hmrsim_zenoh.client.waiting_tasks import waits_of

if TYPE_CHECKING:
    from bt_controller.running.runner import Outcome
    from hmrsim.fault_search.schedule import Injection
    from hmrsim.geometry import Point
    from hmrsim.simulation.demand import Order
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.traffic.causes import Chain
    from hmrsim.world.model import World
    from hmrsim_zenoh.client.aio import AsyncClient
    from hmrsim_zenoh.client.client import Client

T = TypeVar("T")


class ControllerGoesOn(HmrsimError):
    """A tree or another controller of a test has not ended in time; the text names the goals that it repeats."""


AnyTree = str | Path | Callable[..., object]
"""A tree: ``MODULE:FUNCTION``, the path of an XML file, or the function itself."""

LIMIT = 3600.0
"""Simulated seconds in which a tree has to end, if the settings have no duration."""

_SETTINGS = RunSettings(clock="lockstep")
_LIMITED = _SETTINGS.model_copy(update={"duration": LIMIT})

_NOTED = 10
"""Robots, orders or goals in an error."""

_SHOWN = 40
"""Lines of a story in an error."""

_FLEET, _CLIENT = "bt_controller", "client"
"""The participant's name with a tree, as of ``bt-controller run``, and without one, as of a `Client`; the ids of goals
depend on it, and so does the trace."""


def simulation(  # noqa: PLR0913 - the options of the commands
    world: AnyWorld,
    *,
    changes: Mapping[str, Any] | None = None,
    tree: AnyTree | None = None,
    robots: Sequence[str] | None = None,
    values: Mapping[str, str] | None = None,
    nodes: Sequence[str] = (),
    settings: RunSettings | None = None,
    schedule: Sequence[Injection] = (),
    coverage: bool = False,
) -> Run:
    """Return a run of a world for a ``with`` statement; the simulation is paused until a client waits.

    Args:
        world: The name of a shipped world, the path of a file, plain values, or a loaded world.
        changes: Changes to the world, by path, as with ``--overlay``: ``{"robots.*.base.speed": 0.5}``.
        tree: The tree that `Run.to_the_end` runs.
        robots: The robots that run the tree; all robots if left out.
        values: Texts on each tree's blackboard at the start.
        nodes: Modules with further nodes for a tree in XML, as with ``--nodes``.
        settings: The settings of the run, as for ``hmrsim run``; a run with a tree and without a duration ends after
            3600 simulated seconds.
        schedule: Faults and changes of the world, as `hmrsim.testing.schedules` draws them.
        coverage: Whether to count the statuses of the tree's nodes, in `Run.coverage`.

    Raises:
        WorldError: The world is invalid; it has all errors.
        TreeError: There is no such tree.
        ValueError: There are changes to a loaded world, or the schedule has a disturbance, which only a check can
            carry out.
    """
    if any(injection.family == DISTURBANCE for injection in schedule):
        raise ValueError("a schedule with disturbances of the controller needs `check`; give faults and changes only")
    world = read_world(world, changes, overlays_of(schedule))
    plan = None if tree is None else _plan(tree, values or {}, nodes)
    chosen = _SETTINGS if settings is None else settings.model_copy(update={"clock": LOCKSTEP})
    limited = plan is not None and chosen.duration == math.inf
    if limited:
        chosen = _LIMITED if settings is None else chosen.model_copy(update={"duration": LIMIT})
    return Run(
        with_faults(world, schedule), plan, robots, chosen, TreeCoverage() if coverage else None, limited=limited
    )


def _plan(tree: AnyTree, values: Mapping[str, str], nodes: Sequence[str]) -> Plan:
    if callable(tree):
        return plan_of(tree, getattr(tree, "__qualname__", repr(tree)), values=values)
    return load(str(tree), nodes=nodes, values=values)


class _Canceled:
    """The causes that held up robots when `Run.play` canceled its controller, before it canceled their goals.

    Attributes:
        at: The time of the cancellation, in simulated seconds.
        stuck: Why robots that were held up did not go on, by name, as of `Causes.stuck`.
        chains: The causes for each robot of then; later robots may have the same names.
        waits: The waits of its tasks, in words, with their places in the code.
    """

    def __init__(self, simulator: Simulator, waits: str) -> None:
        self.waits = waits
        causes = simulator.roster.admission.causes
        self.at = simulator.now
        self.stuck = causes.stuck()
        self.chains = {robot: causes.chain(robot) for robot in simulator.robots.values()}


class Run:
    """A run of a world. Made by `simulation`.

    Attributes:
        client: A client of the simulator, as for controllers; time moves while it waits.
        simulator: The simulator; read only.
        outcome: The outcome of the trees; None before `to_the_end`.
        coverage: The coverage of the trees since `to_the_end`; None unless requested.
    """

    def __init__(
        self,
        world: World,
        plan: Plan | None,
        robots: Sequence[str] | None,
        settings: RunSettings,
        coverage: TreeCoverage | None = None,
        *,
        limited: bool = False,
    ) -> None:
        self._plan = plan
        self._limited = limited
        self._robots = robots
        self._record = Record(self._place)
        self._trace = DeferredTrace(world, settings)
        self._named: tuple[World | None, Sequence[str], Sequence[Point]] = (None, (), ())
        self._trial = LocalTrial(world, settings, sinks=[self._trace, self._record])
        self.simulator: Simulator = self._trial.simulator
        self.client = self.open_client(_CLIENT if plan is None else _FLEET)
        self.outcome: Outcome | None = None
        self._canceled: _Canceled | None = None
        self.coverage = coverage

    def __enter__(self) -> Self:
        """Return the run."""
        return self

    def __exit__(self, *_error: object) -> None:
        """End the run and abort its active goals."""
        self.close()

    def close(self) -> None:
        """End the run and abort its active goals."""
        self._trial.close()

    def open_client(self, name: str) -> Client:
        """Return a further client, which joins under its own name when it first waits; the run closes it.

        Time moves only while all participants wait, so each client needs its own thread.
        """
        return self._trial.open_client(name)

    def commander(self, robot: str) -> Commander:
        """Return a commander of a robot; each of its calls lets time pass until the goal has ended."""
        return Commander(self.client, robot)

    def to_the_end(self) -> Outcome:
        """Run the tree until it has ended for each robot; return the outcome.

        Raises:
            ValueError: No tree was given.
            TreeError: It can't be built.
            NotServed: The world lacks a robot or an action.
            TreeCrashed: A behavior raised an error.
            Idle: A tree waits for something that can't happen.
            ControllerGoesOn: It has not ended after an hour of simulated time, and the settings have no duration.
        """
        if self._plan is None:
            raise ValueError("there is no tree to run; give one: simulation(WORLD, tree=...)")
        robots = self._robots if self._robots is not None else [*self.simulator.robots]
        self.outcome = run_tree(self.client, self._plan, robots, coverage=self.coverage)
        if self._limited and self.now >= LIMIT:
            raise self._goes_on("tree", "settings=RunSettings(duration=...)")
        return self.outcome

    def play(
        self, controller: Callable[..., Coroutine[Any, Any, T]], *, duration: float | None = None, **arguments: Any
    ) -> T | None:
        """Run an asyncio controller, such as a dispatcher, until it returns; return its result.

        ::

            run.play(dispatch, duration=600, rule="nearest")

        Args:
            controller: A coroutine function, which is called with an `AsyncClient`.
            duration: Simulated seconds after which the controller is canceled, and None returned; `why` and the texts
                of failed checks then tell what the robots did when it was canceled.
            arguments: Further arguments of the controller, by name.

        Raises:
            TypeError: It is no coroutine function.
            ControllerGoesOn: It has not returned after an hour of simulated time, and there is no *duration*. Notes
                say what the robots do, as the controller may wait for what can't happen.
        """
        if not inspect.iscoroutinefunction(controller):
            name = getattr(controller, "__qualname__", repr(controller))
            raise TypeError(f"{name} is no `async def` function; call it with the run's client: {name}(run.client)")

        async def limited(client: AsyncClient) -> T | None:
            task = asyncio.ensure_future(controller(client, **arguments))
            try:
                await asyncio.wait([task], timeout=LIMIT if duration is None else duration)
            except asyncio.CancelledError:
                task.cancel()
                raise
            if task.done():
                return await task
            # Before the goals of its tasks are canceled.
            others = [each for each in asyncio.all_tasks() if each not in (task, asyncio.current_task())]
            tasks = [task, *sorted(others, key=lambda each: (len(each.get_name()), each.get_name()))]
            self._canceled = _Canceled(self.simulator, waits_of(tasks))
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task
            if duration is None:
                raise self._goes_on("controller", "play(..., duration=...)")
            return None

        self._canceled = None
        result: T | None = asyncio.run(play_async(self.client, limited))
        return result

    def _goes_on(self, what: str, remedy: str) -> ControllerGoesOn:
        """Return the error of a controller that has not ended, with the goals that it sent most often.

        Its notes say what the robots do; *remedy* is for a controller that is to go on.
        """
        sent = Counter((goal.robot, goal.action) for goal in self._record.goals.values())
        goals = listed([f"{action} of {robot} {number} times" for (robot, action), number in sent.most_common(3)])
        told = f"the goals that it sent most often: {goals}" if sent else "it has sent no goal"
        error = ControllerGoesOn(
            f"the {what} goes on after {LIMIT:g} simulated seconds; {told}; if that is intended, give it a duration: "
            f"{remedy}"
        )
        for robot in [*self.simulator.robots][:_NOTED]:
            error.add_note(self._chain(robot).links[0].text)
        return error

    @property
    def now(self) -> float:
        """The simulation time in seconds."""
        return self.simulator.now

    @property
    def trace(self) -> str:
        """The trace so far, with the same bytes that ``--trace`` writes for this run over Zenoh."""
        return self._trace.text

    def goals(
        self, robot: str | None = None, action: str | None = None, status: GoalStatus | str | None = None
    ) -> list[Goal]:
        """Return the accepted goals in order, filtered by robot, action and status.

        Raises:
            ValueError: There was no such robot, or there is no such action or status.
        """
        wanted = GoalStatus[known_name("status", status, GoalStatus.__members__)] if isinstance(status, str) else status
        if robot is not None:
            self._check_robot(robot)
        if action is not None:
            known_name("action", action, [*actions(), *(goal.action for goal in self._record.goals.values())])
        return [
            goal
            for goal in self._record.goals.values()
            if robot in {None, goal.robot} and action in {None, goal.action} and wanted in {None, goal.status}
        ]

    def happened(self, kind: str | None = None, **fields: Any) -> list[Happening]:
        """Return the events of the world in order, filtered by kind and fields.

        ::

            run.happened("dock_docked", robot="wall_e")

        Raises:
            ValueError: There is no such event, or it has no such field.
        """
        if kind is not None:
            there = events()[known_name("event", kind, events())].fields()
            for name in fields if there is not None else ():
                known_name(f"field of {kind}", name, there or ())
        return [
            each
            for each in self._record.happenings(lambda event: kind in {None, event.kind})
            if all(each.fields.get(name) == value for name, value in fields.items())
        ]

    def orders(self, state: str | None = None) -> list[Order]:
        """Return the orders of the demand in order of arrival, filtered by state or ``open``.

        Of orders that have ended, only the last 1,000 are included.

        Raises:
            ValueError: There is no such state.
        """
        if state not in {None, "open"}:
            known_name("state of an order", str(state), ["open", *(each.value for each in OrderState)])
        demand = self.simulator.demand
        found = sorted([*demand.closed, *demand.open.values()], key=lambda order: order.placed)
        return [order for order in found if state in {None, order.state} or (state == "open" and order.state.open)]

    def position(self, name: str) -> Point:
        """Return the current position of a robot or an item, in the world's unit.

        Raises:
            ValueError: There is no robot or item of this name.
        """
        robots, items = self.simulator.robots, self.simulator.roster.items
        if name in robots:
            return robots[name].pose().point
        if name in items:
            return items[name].position
        raise ValueError(f"no robot or item {name!r}; there are: {listed([*robots, *items])}")

    def where(self, name: str) -> str:
        """Return the place, waypoint or dock nearest to a robot or an item, in this order if they are equally near.

        Raises:
            ValueError: There is no robot or item of this name, or the world has no places, waypoints or docks.
        """
        return self._nearest(self.simulator.world, self.position(name))

    def _place(self, robot: str) -> Callable[[], str] | None:
        """Return a function that finds the place at which a robot is now, as most are never asked for."""
        if robot == WORLD:
            return None
        return partial(self._nearest, self.simulator.world, self.simulator.roster.robots[robot].pose().point)

    def _nearest(self, world: World, at: Point) -> str:
        names, points = self._places(world)
        if not names:
            raise ValueError("the world has no places, docks or waypoints")
        away = [*map(math.dist, points, repeat(at))]
        return names[away.index(min(away))]

    def _places(self, world: World) -> tuple[Sequence[str], Sequence[Point]]:
        """Return the names of places, waypoints and docks, and their positions."""
        before = self._named[0]
        if before is not world:
            docks = {dock: world.dock_point(dock) for dock in world.docks}
            named = {**{place: each.at for place, each in world.places.items()}, **world.points, **docks}
            self._named = world, [*named], [*named.values()]
        return self._named[1:]

    def carrier(self, item: str) -> str | None:
        """Return the robot that carries an item; None if no robot does.

        Raises:
            ValueError: There is no such item.
        """
        items = self.simulator.roster.items
        carrier = items[known_name("item", item, items)].carrier
        return carrier.name if carrier else None

    def visited(self, robot: str) -> list[str]:
        """Return the places where a robot's goals ended, in order and without consecutive repetitions.

        Raises:
            ValueError: There was no such robot.
        """
        places: list[str] = []
        for goal in sorted(self.goals(robot), key=lambda each: math.inf if each.ended is None else each.ended):
            if goal.where and places[-1:] != [goal.where]:
                places.append(goal.where)
        return places

    def check_succeeded(self) -> None:
        """Check that the trees of all robots have succeeded.

        Raises:
            AssertionError: A tree has not succeeded; the text has the story of the run.
        """
        __tracebackhide__ = True
        if self.outcome is None:
            raise AssertionError("the run has not come to its end; call `to_the_end`")
        failed = [robot for robot, status in self.outcome.statuses.items() if status.name != "SUCCESS"]
        if failed:
            why = "".join(f"\n  {robot}: {text}" for robot in failed if (text := self.outcome.why(robot)))
            raise AssertionError(f"{', '.join(failed)} failed{why}{self._end_of_story()}")

    def check_delivered(self, number: int | None = None) -> None:
        """Check that so many orders of the demand were delivered; if left out, that all were that have been placed.

        Raises:
            AssertionError: There are more or fewer, or none was placed; the text has the open orders, the goals that
                failed, and the story of the run.
        """
        __tracebackhide__ = True
        totals = self.simulator.demand.totals
        if totals.delivered == (totals.placed if number is None else number) and (totals.placed or number == 0):
            return
        wanted = "" if number is None else f", not {number}"
        text = f"{totals.delivered} of {totals.placed} orders were delivered{wanted}"
        lines = [*_first(map(self._describe, self.orders("open"))), *self._failures()]
        raise AssertionError(text + "".join(f"\n  {line}" for line in lines) + self._end_of_story())

    def _describe(self, order: Order) -> str:
        """Return what has become of an open order."""
        text = f"{order.name}, placed at {order.placed:g} s"
        if order.state is OrderState.CARRIED:
            return f"{text}: {order.robot} carries {order.item!r}, which has to go to {order.to}"
        if order.picked_up is None:
            return f"{text}: no robot has picked up {order.item!r} at {order.at}"
        return f"{text}: {order.item!r} lies near {self.where(order.item)}, and has to go to {order.to}"

    def _failures(self) -> list[str]:
        """Return why goals were aborted, in words, the last ones last."""
        aborted = self.goals(status=GoalStatus.ABORTED)
        texts = [
            f"{goal.action} of {goal.robot} was aborted at {goal.ended:g} s: {error_of(goal.result)}"
            for goal in aborted[-_NOTED:]
            if goal.result is not None
        ]
        left = len(aborted) - len(texts)
        return [f"{left} goals were aborted before; run.goals(status='ABORTED') has all", *texts] if left else texts

    def check_visited(self, robot: str, *places: str) -> None:
        """Check that a robot's goals ended at places in this order, perhaps with others between them.

        Raises:
            AssertionError: They did not; the text has the story of the run.
            ValueError: There was no such robot, or there is no such place, dock or waypoint.
        """
        __tracebackhide__ = True
        for place in places:
            known_name("place", place, self._places(self.simulator.world)[0])
        visited, before = iter(self.visited(robot)), ""
        for place in places:
            if place not in visited:
                there = ", ".join(self.visited(robot)) or "nothing"
                after = f" after {before!r}" if before else ""
                raise AssertionError(
                    f"{robot} did not visit {place!r}{after}; it visited {there}{self._end_of_story()}"
                )
            before = place

    def why(self, robot: str) -> str:
        """Return why a robot does not go on: the chain of causes, and what would help.

        For a robot that nothing holds up, the text says what it does. `hmrsim explain --robot` prints the same. Right
        after `play` has canceled its controller, the text says what held the robot up just before.

        Raises:
            ValueError: There is no such robot.
        """
        return str(self._chain(known_name("robot", robot, self.simulator.robots)))

    def _chain(self, robot: str) -> Chain:
        """Return the causes for which a robot does not go on, or did not when the controller was canceled just now."""
        there = self.simulator.robots[robot]
        if self._canceled is not None and self._canceled.at == self.now and there in self._canceled.chains:
            return self._canceled.chains[there]
        return self.simulator.roster.admission.causes.chain(there)

    def story(self) -> list[str]:
        """Return the events, one line each; ``print(run.story())`` prints them below each other."""
        return _Lines(f"{each.at:9.3f} s  {each.text}" for each in self.happened())

    def _check_robot(self, robot: str) -> None:
        # A deleted robot may have had goals.
        known = [*self.simulator.robots, *dict.fromkeys(goal.robot for goal in self._record.goals.values())]
        if robot != WORLD:
            known_name("robot", robot, [*dict.fromkeys(known)])

    def _end_of_story(self) -> str:
        """Return the last lines of the story, that the controller was canceled, and why robots wait."""
        lines, stuck = _shortened(self.story()), self.simulator.roster.admission.causes.stuck()
        if self._canceled is not None:
            at = self._canceled.at
            lines.append(f"{at:9.3f} s  play() canceled the controller, which had not returned within its duration")
            lines.append(f"{at:9.3f} s  its tasks then: {self._canceled.waits}")
            stuck = self._canceled.stuck if at == self.now else stuck
        return "".join(f"\n  {line}" for line in (*lines, *(f"{self.now:9.3f} s  {text}" for text in stuck.values())))


class _Lines(list[str]):
    """The lines of a story; as a string, one below the other."""

    def __str__(self) -> str:
        """Return the lines, joined."""
        return "\n".join(self)


def _first(texts: Iterable[str]) -> list[str]:
    """Return the first texts, with the number of those after them."""
    texts = [*texts]
    left = len(texts) - _NOTED
    return texts if left <= 0 else [*texts[:_NOTED], f"… and {left} more; run.orders('open') has all"]


def _shortened(lines: Iterable[str]) -> list[str]:
    """Return the last lines of a story, with the number of lines before."""
    lines = [*lines]
    left = len(lines) - _SHOWN
    return lines if left <= 0 else [f"... {left} before; run.story() has all", *lines[-_SHOWN:]]

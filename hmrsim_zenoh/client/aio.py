"""Robots for asyncio: many at once, in one thread, in real time and in lockstep.

::

    async with AsyncClient() as client:
        mocha, latte = client.robot("mocha"), client.robot("latte")
        await asyncio.gather(mocha.navigate_to("table_1"), latte.navigate_to("table_3"))

In lockstep, time advances when all tasks wait: for robots, for simulated time, or for each other. The event loop then
uses the clock of the simulation, so that `asyncio.sleep` and `asyncio.timeout` take simulated seconds, and tasks run in
the same order each time. Simulated time does not wait for tasks that await a thread or a file.
"""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from contextlib import contextmanager, suppress
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Self, TypeVar

from hmrsim.diagnostics import known_name
from hmrsim.errors import HmrsimError
from hmrsim.events import registry
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.message import Message
from hmrsim_zenoh.client import verbs
from hmrsim_zenoh.client.aio_time import AsyncTime
from hmrsim_zenoh.client.battery import BATTERY_PERIOD, battery_of, charged_or_not_charging, is_charged
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.connection import Condition
from hmrsim_zenoh.client.waiting_tasks import NamedRobot
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Coroutine, Iterator, Mapping, Sequence

    from hmrsim.geometry import Pose
    from hmrsim.interfaces.hmrsim_msgs import Order
    from hmrsim.interfaces.sensor_msgs import BatteryState
    from hmrsim_zenoh.client.aio_time import Waiting
    from hmrsim_zenoh.client.goal_handle import GoalHandle
    from hmrsim_zenoh.client.places import NamedPlaces
    from hmrsim_zenoh.client.verbs import Request

P = ParamSpec("P")
R = TypeVar("R", bound=Message)

_log = logging.getLogger(__name__)

_CANCEL_PATIENCE = 2.0
_EVENTS = "_world/events"
_PLACED = "order_placed"
_RESTARTS = ("reset", "world_loaded")
"""Events after which the names of orders begin anew."""
_ON_ITS_WAY = 1.0
"""Wall seconds for which time stands still in lockstep until an event arrives over the network."""


class AsyncClient:
    """A `Client` for asyncio, to be used in an ``async with`` statement.

    Args:
        client: The client to use, which stays open; None to open one, with these options of `Client`, or the options of
            its session alone.

    Attributes:
        client: The client, once it is connected.

    Raises:
        SimulatorNotFound: No peer answers at the endpoints.
        ConnectionDenied, BadOptions: As `Client`.
    """

    def __init__(self, client: Client | SessionOptions | None = None, **options: Any) -> None:
        self.client: Client
        if isinstance(client, SessionOptions):
            client, options = None, {**options, "options": client}
        self._given = client
        self._options = options

    async def __aenter__(self) -> Self:
        """Connect, and take part in lockstep if the simulator is in lockstep."""
        given = self._given
        self.client = await asyncio.to_thread(partial(Client, **self._options)) if given is None else given
        self._places = self.client.places
        await asyncio.to_thread(_load, self._places)
        self._time = AsyncTime(self.client, await asyncio.to_thread(lambda: self.client.lockstep))
        return self

    async def __aexit__(self, _kind: object, error: BaseException | None, _traceback: object) -> None:
        """Leave lockstep and disconnect from the simulator.

        Raises:
            SimulatorGone: The simulator has gone, and no task was waiting for it.
        """
        stops, lost = self._time.stops, self._time.lost
        self._time.close()
        await self._disconnect(stops=stops)
        if lost is not None and isinstance(error, asyncio.CancelledError):
            if (task := asyncio.current_task()) is not None:
                task.uncancel()
            raise lost from None

    async def _disconnect(self, *, stops: bool) -> None:
        if self._given is not None:
            return
        if stops:
            # No task may run meanwhile: what it sends would race with the end of the connection.
            self.client.close()
        else:
            await asyncio.to_thread(self.client.close)

    def robot(self, name: str) -> AsyncRobot:
        """Return a robot of this name."""
        return AsyncRobot(self.client, self._time, name, self._places)

    async def info(self) -> dict[str, Any]:
        """Return the simulator's description, as of `Client`; no time passes in lockstep.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: As `Client.get`.
        """
        return await self._time.ask(self.client.info)

    async def now(self) -> float:
        """Return simulated seconds.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable: There is no simulated time.
        """
        return await self._time.now()

    async def sleep(self, seconds: float) -> None:
        """Sleep for a number of simulated seconds.

        Raises:
            ValueError: The time is negative.
            SimulationEnded, SimulatorGone, Dropped: Time no longer advances.
        """
        await self._time.sleep(seconds)

    async def orders(self) -> AsyncIterator[dict[str, Any]]:
        """Yield the open orders of the world, oldest first, then each new order when it is placed.

        An order has the fields of the event ``order_placed``, and ``robot`` if a robot already carries its item. In
        lockstep, time advances and stands still as with `events`. In real time, a warning is logged if the world has no
        demand: orders then come only from clients, or with another world.

        Raises:
            SimulationEnded, SimulatorGone, Dropped, Idle: Time no longer advances.
            SimulatorNotFound, Unreachable, RequestTimeout: As `Client.get_orders`.
        """
        with self._listening((_PLACED, *_RESTARTS)) as next_event:
            orders = await self._time.ask(partial(self.client.get_orders, "open"))
            for order in orders:
                yield _placed(order)
            if not (orders or self._time.stops):
                await self._time.ask(self._warn_without_demand)
            # Events of these orders may be on their way.
            known = {order.name for order in orders}
            while True:
                event = await next_event()
                if event["kind"] != _PLACED:
                    known.clear()
                elif event["order"] not in known:
                    yield event

    def _warn_without_demand(self) -> None:
        # A controller may lack the right to see the world.
        with suppress(HmrsimError):
            world = json.loads(self.client.get(self.client.keys.world("view")))["world"]
            if not world["demand"]:
                _log.warning(
                    "world %r has no demand: orders() waits for clients that call place_order, or for load_world",
                    world["name"],
                )

    async def events(self, *kinds: str) -> AsyncIterator[dict[str, Any]]:
        """Yield the events of the world from now on, as ``_world/events`` has them; see the table of events.

        In lockstep, time advances until an event comes, and stands still while the task processes it. Over a network,
        other work of the same instant may come between several events.

        Args:
            kinds: The kinds of events at which time stops, such as ``order_placed``; without any, all events.

        Raises:
            ValueError: One of the kinds of events does not exist.
            SimulationEnded, SimulatorGone, Dropped, Idle: Time no longer advances.
        """
        for kind in kinds:
            known_name("event", kind, registry())
        with self._listening(kinds) as next_event:
            while True:
                yield await next_event()

    @contextmanager
    def _listening(self, kinds: Sequence[str]) -> Iterator[Callable[[], Coroutine[Any, Any, dict[str, Any]]]]:
        """Subscribe to events of some kinds, or of all if there are none; yield the function that awaits the next."""
        come: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue()
        waits: list[Waiting] = []
        conditions = [Condition(_EVENTS, [("/kind", "==", kind)]) for kind in kinds] or [Condition(_EVENTS)]

        def take(event: dict[str, Any]) -> None:
            come.put_nowait(event)
            # Time stops at a later event, which is still to be reported.
            if self._time.has_come(event["stamp"]):
                for wait in waits:
                    wait.happen()

        def on_sample(_key: str, payload: bytes) -> None:
            event = json.loads(payload)
            if not kinds or event["kind"] in kinds:
                self._time.stop_if_late(waits, event["stamp"])
                self._time.post(partial(take, event), rank)

        async def next_event() -> dict[str, Any]:
            while True:
                if come.empty():
                    waits[:] = [self._time.wait()]
                    with self._time.watching(conditions, waits[0]):
                        await waits[0]
                    waits.clear()
                event = come.get_nowait() if not come.empty() else await self._on_its_way(come)
                if event is not None:
                    return event

        rank = self._time.next_rank()
        subscription = self.client.subscribe(f"{self.client.keys.prefix}/{_EVENTS}", on_sample)
        with subscription, self._time.listening(subscription):
            yield next_event

    async def _on_its_way(self, come: asyncio.Queue[dict[str, Any] | None]) -> dict[str, Any] | None:
        """Return an event that arrives over the network, while time stands still; None if it was lost."""
        loss = threading.Timer(_ON_ITS_WAY, self._time.post, [partial(come.put_nowait, None)])
        loss.daemon, loss.name = True, "hmrsim-loss"
        with self._time.held():
            loss.start()
            try:
                return await come.get()
            finally:
                loss.cancel()


def _awaitable(
    verb: Callable[Concatenate[NamedPlaces, P], Request[R]],
) -> Callable[Concatenate[AsyncRobot, P], Coroutine[Any, Any, R]]:
    """Return the coroutine method that does what a verb requests."""

    async def method(self: AsyncRobot, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return await self._do(verbs.requested(verb, self._places, *args, **kwargs))

    verbs.present_as(verb, method)
    return method


class AsyncRobot(NamedRobot):
    """Sends goals to one robot; made by `AsyncClient.robot`.

    Methods, targets, results and errors are those of `Commander`. A canceled task cancels its goal, and ends when the
    goal has ended. Most methods take *on_feedback*, which is called with each feedback.
    """

    def __init__(self, client: Client, time: AsyncTime, name: str, places: NamedPlaces) -> None:
        self.name = name
        self._client = client
        self._time = time
        self._places = places

    @cached_property
    def _description(self) -> Mapping[str, Any]:
        robots: dict[str, dict[str, Any]] = {robot["name"]: robot for robot in self._client.info()["robots"]}
        return robots[known_name("robot", self.name, robots)]

    @property
    def type(self) -> str:
        """The robot's type in the world file; the first access asks the simulator, and no time passes in lockstep.

        Raises:
            ValueError: There is no such robot.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: As `Client.get`.
        """
        kind: str = self._description["type"]
        return kind

    @property
    def components(self) -> Sequence[str]:
        """The names of the robot's components, such as ``battery``; asked for and failing as `type`."""
        components: list[str] = self._description["components"]
        return components

    async def pose(self) -> Pose:
        """Return where the robot is, as it reports it in ``odom``; no time passes in lockstep.

        Returns:
            x and y in the world's unit of length, yaw in radians, in the frame ``map``. It can be a target.

        Raises:
            RequestError, Unreachable: There is no such robot.
            SimulatorNotFound, SimulatorGone, RequestTimeout: As `Client.get`.
        """
        return await self._time.ask(partial(self._client.pose_of, self.name))

    navigate_to = _awaitable(verbs.navigate_to)
    navigate_through = _awaitable(verbs.navigate_through)
    follow_waypoints = _awaitable(verbs.follow_waypoints)
    compute_path_to = _awaitable(verbs.compute_path_to)
    compute_path_through = _awaitable(verbs.compute_path_through)
    compute_route = _awaitable(verbs.compute_route)
    track_route = _awaitable(verbs.track_route)
    follow_path = _awaitable(verbs.follow_path)
    smooth_path = _awaitable(verbs.smooth_path)
    spin = _awaitable(verbs.spin)
    back_up = _awaitable(verbs.back_up)
    drive_on_heading = _awaitable(verbs.drive_on_heading)
    dock = _awaitable(verbs.dock)
    undock = _awaitable(verbs.undock)
    pickup = _awaitable(verbs.pickup)
    place = _awaitable(verbs.place)
    wait = _awaitable(verbs.wait)
    do = _awaitable(verbs.do)

    async def battery(self) -> BatteryState:
        """Return the state of the battery, as of `Commander`; no time passes in lockstep.

        Raises:
            RequestError, Unreachable: There is no such robot, or it has no battery.
        """
        return await self._time.ask(partial(battery_of, self._client, self.name))

    async def wait_until_charged(self, percentage: float = 0.9) -> BatteryState:
        """Wait until the battery has a share of its capacity, and return its state.

        Raises:
            ValueError, NotCharging, RequestError, Unreachable: As of `Commander`.
        """
        conditions = charged_or_not_charging(self.name, percentage)
        while not is_charged(self.name, state := await self.battery(), percentage):
            if self._time.stops:
                wait = self._time.wait()
                with self._time.watching(conditions, wait):
                    await wait
            else:
                await self._time.sleep(BATTERY_PERIOD)
        return state

    async def _do(self, request: Request[R]) -> R:
        """Send a goal, and return its result once it has ended.

        Raises:
            GoalFailed, GoalRejectedError, SimulatorGone: As of `Commander`.
        """
        loop = asyncio.get_running_loop()
        ends = [self._time.wait()]
        on_feedback = request.on_feedback

        def on_change(handle: GoalHandle[Any, Any]) -> None:
            if handle.done:
                ends[-1].happen()

        def post(feedback: Message) -> None:
            if on_feedback is not None:
                self._time.post(partial(loop.call_soon, on_feedback, feedback))

        action = self._client.action_client(self.name, request.definition)
        handle = action.execute(request.goal, on_change=on_change, on_feedback=None if on_feedback is None else post)
        try:
            await ends[0]
        except asyncio.CancelledError:
            # No robot keeps driving when no task waits for it.
            ends.append(self._time.wait())
            handle.cancel()
            with suppress(TimeoutError, HmrsimError):
                async with asyncio.timeout(0 if handle.done else _CANCEL_PATIENCE):
                    await ends[1]
            raise
        return request.result_of(self.name, handle)


def _load(places: NamedPlaces) -> None:
    """Query the places in advance, while a wait does no harm; a real robot may have none."""
    with suppress(Unreachable):
        places.load()


def _placed(order: Order) -> dict[str, Any]:
    """Return the event by which an order was placed, with the robot that carries its item, if any."""
    known = {"stamp": order.placed.model_dump(), "kind": _PLACED, "order": order.name, "item": order.item}
    due, placed = order.due.to_nanoseconds(), order.placed.to_nanoseconds()
    within = (due - placed) / NANOSECONDS if due else None
    rest = {"priority": order.priority, "within": within, "weight": order.weight, "demand": order.demand}
    rest["robot"] = order.robot
    return {**known, "from": order.at, "to": order.to, **{name: value for name, value in rest.items() if value}}

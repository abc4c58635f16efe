"""Robots for asyncio: many at once, in one thread, in real time and in lockstep.

::

    async with AsyncClient() as client:
        mocha, latte = client.robot("mocha"), client.robot("latte")
        await asyncio.gather(mocha.navigate_to("table_1"), latte.navigate_to("table_3"))

In lockstep time goes on when all tasks wait: for robots, for simulated time, or for each other. The clock of the event
loop is that of the simulation then, so that `asyncio.sleep` and `asyncio.timeout` take simulated seconds, and tasks run
in the same order each time. What a task awaits from a thread or a file is not waited for.
"""

from __future__ import annotations

import asyncio
import json
import threading
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Any, Self, TypeVar

from hmrsim.diagnostics import known_name
from hmrsim.errors import HmrsimError
from hmrsim.events import registry
from hmrsim.interfaces.message import Message
from hmrsim_zenoh.client.aio_time import AsyncTime
from hmrsim_zenoh.client.charge import BATTERY_PERIOD, Charge
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.condition import Condition
from hmrsim_zenoh.client.ended_goals import checked
from hmrsim_zenoh.client.errands import Errand, Errands, Target
from hmrsim_zenoh.errors import Unreachable
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping, Sequence

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.moveit_msgs import Pickup, Place
    from hmrsim.interfaces.nav2_msgs import (
        BackUp,
        ComputeAndTrackRoute,
        ComputePathThroughPoses,
        ComputePathToPose,
        ComputeRoute,
        DockRobot,
        DriveOnHeading,
        FollowPath,
        FollowWaypoints,
        NavigateThroughPoses,
        NavigateToPose,
        SmoothPath,
        Spin,
        UndockRobot,
        Wait,
    )
    from hmrsim.interfaces.nav_msgs import Path
    from hmrsim.interfaces.sensor_msgs import BatteryState
    from hmrsim_zenoh.client.aio_time import Waiting
    from hmrsim_zenoh.client.goal_handle import GoalHandle
    from hmrsim_zenoh.client.places import NamedPlaces

R = TypeVar("R", bound=Message)

_CANCEL_PATIENCE = 2.0
_EVENTS = "_world/events"
_ON_ITS_WAY = 1.0
"""Wall seconds for which time stands in lockstep until an event has come by the network, for which it has stopped."""


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
        """Connect, and take part in lockstep if that is how time goes on."""
        given = self._given
        self.client = await asyncio.to_thread(partial(Client, **self._options)) if given is None else given
        self._places = self.client.places
        await asyncio.to_thread(_load, self._places)
        self._time = AsyncTime(self.client, await asyncio.to_thread(lambda: self.client.lockstep))
        return self

    async def __aexit__(self, *_error: object) -> None:
        """Disconnect."""
        stops = self._time.stops
        self._time.close()
        if self._given is not None:
            return
        if stops:
            # No task may run meanwhile: what it sends would race with the end of the connection.
            self.client.close()
        else:
            await asyncio.to_thread(self.client.close)

    def robot(self, name: str) -> AsyncRobot:
        """Return a robot of this name."""
        return AsyncRobot(self.client, self._time, name, Errands(self._places))

    async def now(self) -> float:
        """Return simulated seconds.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable: There is no simulated time.
        """
        return await self._time.now()

    async def sleep(self, seconds: float) -> None:
        """Sleep for simulated seconds.

        Raises:
            ValueError: They are less than 0.
            SimulationEnded, SimulatorGone, Dropped: Time does not go on.
        """
        await self._time.sleep(seconds)

    async def events(self, *kinds: str) -> AsyncIterator[dict[str, Any]]:
        """Yield the events of the world from now on, as ``_world/events`` has them; see the table of events.

        In lockstep time goes on until one comes, and stands while the task deals with it. Over a network several events
        of one instant may be divided by what else happens then.

        Args:
            kinds: Of these kinds, such as ``order_placed``, at which time stops; of all if there are none.

        Raises:
            ValueError: There is no event of such a kind.
            SimulationEnded, SimulatorGone, Dropped, Idle: Time does not go on.
        """
        for kind in kinds:
            known_name("event", kind, registry())
        come: asyncio.Queue[dict[str, Any] | None] = asyncio.Queue()
        waits: list[Waiting] = []
        conditions = [Condition(_EVENTS, [("/kind", "==", kind)]) for kind in kinds] or [Condition(_EVENTS)]

        def take(event: dict[str, Any]) -> None:
            come.put_nowait(event)
            # A later one has time stop there, which is still to be told.
            if self._time.has_come(event["stamp"]):
                for wait in waits:
                    wait.happen()

        def on_sample(_key: str, payload: bytes) -> None:
            event = json.loads(payload)
            if not kinds or event["kind"] in kinds:
                self._time.stop_if_late(waits, event["stamp"])
                self._time.post(partial(take, event), rank)

        rank = self._time.next_rank()
        subscription = self.client.subscribe(f"{self.client.keys.prefix}/{_EVENTS}", on_sample)
        with subscription, self._time.listening(subscription):
            while True:
                if come.empty():
                    waits[:] = [self._time.wait()]
                    with self._time.watching(conditions, waits[0]):
                        await waits[0]
                    waits.clear()
                event = come.get_nowait() if not come.empty() else await self._on_its_way(come)
                if event is not None:
                    yield event

    async def _on_its_way(self, come: asyncio.Queue[dict[str, Any] | None]) -> dict[str, Any] | None:
        """Return an event that comes by the network, where time stands meanwhile; None if it was lost."""
        loss = threading.Timer(_ON_ITS_WAY, self._time.post, [partial(come.put_nowait, None)])
        loss.daemon, loss.name = True, "hmrsim-loss"
        with self._time.held():
            loss.start()
            try:
                return await come.get()
            finally:
                loss.cancel()


class AsyncRobot:
    """Sends goals to one robot; made by `AsyncClient.robot`.

    Methods, targets, results and errors are those of `Commander`. A task that is canceled cancels its goal, and ends
    when that has ended. Each method takes *on_feedback*, which is called with each feedback.
    """

    def __init__(self, client: Client, time: AsyncTime, name: str, errands: Errands) -> None:
        self.name = name
        self._client = client
        self._time = time
        self._errands = errands
        self._charge = Charge(client, name)

    async def navigate_to(self, target: Target, **options: Any) -> NavigateToPose.Result:
        """Drive to a place."""
        return await self._do(self._errands.navigate_to(target), **options)

    async def navigate_through(self, targets: Sequence[Target], **options: Any) -> NavigateThroughPoses.Result:
        """Drive to the last of some places by way of the others."""
        return await self._do(self._errands.navigate_through(targets), **options)

    async def follow_waypoints(
        self, targets: Sequence[Target], *, loops: int = 0, **options: Any
    ) -> FollowWaypoints.Result:
        """Visit places one after the other, and again so many times; the result names those that were missed."""
        return await self._do(self._errands.follow_waypoints(targets, loops=loops), **options)

    async def compute_path_to(self, target: Target, start: Target | None = None) -> ComputePathToPose.Result:
        """Plan a path to a place, from the robot or from *start*."""
        return await self._do(self._errands.compute_path_to(target, start))

    async def compute_path_through(
        self, targets: Sequence[Target], start: Target | None = None
    ) -> ComputePathThroughPoses.Result:
        """Plan a path through places, from the robot or from *start*."""
        return await self._do(self._errands.compute_path_through(targets, start))

    async def compute_route(self, target: Target, start: Target | None = None) -> ComputeRoute.Result:
        """Plan a route along lanes, from the robot or from *start*."""
        return await self._do(self._errands.compute_route(target, start))

    async def track_route(self, target: Target, **options: Any) -> ComputeAndTrackRoute.Result:
        """Plan a route along lanes, and tell how the robot gets on along it, whatever else drives it."""
        return await self._do(self._errands.track_route(target), **options)

    async def follow_path(self, path: Path, **options: Any) -> FollowPath.Result:
        """Drive along a path."""
        return await self._do(self._errands.follow_path(path), **options)

    async def smooth_path(self, path: Path) -> SmoothPath.Result:
        """Smooth a path."""
        return await self._do(self._errands.smooth_path(path))

    async def spin(self, yaw: float, **options: Any) -> Spin.Result:
        """Turn on the spot by *yaw* radians, to the left if it is greater than 0."""
        return await self._do(self._errands.spin(yaw), **options)

    async def back_up(self, distance: float, speed: float, **options: Any) -> BackUp.Result:
        """Drive straight back."""
        return await self._do(self._errands.back_up(distance, speed), **options)

    async def drive_on_heading(self, distance: float, speed: float, **options: Any) -> DriveOnHeading.Result:
        """Drive straight on."""
        return await self._do(self._errands.drive_on_heading(distance, speed), **options)

    async def dock(self, dock: str, *, navigate: bool = True, **options: Any) -> DockRobot.Result:
        """Dock at a dock, after a drive to its staging pose if *navigate*."""
        return await self._do(self._errands.dock(dock, navigate=navigate), **options)

    async def undock(self, **options: Any) -> UndockRobot.Result:
        """Leave the dock."""
        return await self._do(self._errands.undock(), **options)

    async def pickup(self, name: str, **options: Any) -> Pickup.Result:
        """Pick up an item that is in reach."""
        return await self._do(self._errands.pickup(name), **options)

    async def place(self, name: str, **options: Any) -> Place.Result:
        """Put down a held item."""
        return await self._do(self._errands.place(name), **options)

    async def wait(self, seconds: float, **options: Any) -> Wait.Result:
        """Stand still for *seconds* of simulated time."""
        return await self._do(self._errands.wait(seconds), **options)

    async def do(self, action: AnyAction | str, goal: Message | Mapping[str, Any], **options: Any) -> Any:
        """Send a goal of any action, such as one of a package: ``await mocha.do("wipe", {"strokes": 4})``.

        Args:
            action: The action, or its name.
            goal: The goal, or its plain values; fields that are left out have their defaults, and a pose may be the
                name of a place.
            options: As of the other methods.

        Raises:
            ValueError: No action of this name is installed here, or there is no such place.
            RequestError: The simulator does not serve it, or the goal has other fields.
        """
        return await self._do(self._errands.any(action, goal), **options)

    async def battery(self) -> BatteryState:
        """Return the state of the battery, as of `Commander`; no time passes in lockstep.

        Raises:
            RequestError, Unreachable: There is no such robot, or it has no battery.
        """
        with self._time.held():
            return await asyncio.to_thread(self._charge.now)

    async def wait_until_charged(self, percentage: float = 0.9) -> BatteryState:
        """Wait until the battery has a share of its capacity, and return its state.

        Raises:
            ValueError, NotCharging, RequestError, Unreachable: As of `Commander`.
        """
        conditions = self._charge.until(percentage)
        while not self._charge.reached(state := await self.battery(), percentage):
            if self._time.stops:
                wait = self._time.wait()
                with self._time.watching(conditions, wait):
                    await wait
            else:
                await self._time.sleep(BATTERY_PERIOD)
        return state

    async def _do(self, errand: Errand[R], *, on_feedback: Callable[[Any], object] | None = None) -> R:
        """Send a goal, and return its result once it has ended.

        Raises:
            GoalFailed, GoalRejectedError, SimulatorGone: As of `Commander`.
        """
        loop = asyncio.get_running_loop()
        ends = [self._time.wait()]

        def on_change(handle: GoalHandle[Any, Any]) -> None:
            if handle.done:
                ends[-1].happen()

        def tell(feedback: Message) -> None:
            if on_feedback is not None:
                self._time.post(partial(loop.call_soon, on_feedback, feedback))

        action = self._client.action_client(self.name, errand.definition)
        handle = action.execute(errand.goal, on_change=on_change, on_feedback=None if on_feedback is None else tell)
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
        return checked(self.name, errand, handle)


def _load(places: NamedPlaces) -> None:
    """Look the places up while that may take its time; a real robot may know none."""
    with suppress(Unreachable):
        places.load()

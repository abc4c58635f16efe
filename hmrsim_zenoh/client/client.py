"""The client of a simulator: it sends goals without waiting, queries values and subscribes to topics.

::

    with Client() as client:
        wall_e = client.action_client("wall_e", registry()["navigate_to_pose"])
        goal = wall_e.send_goal(NavigateToPose.Goal(...), on_feedback=print)
        result = goal.result(timeout=60.0)
"""

from __future__ import annotations

import atexit
import json
import logging
import os
import re
import threading
import time
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Literal, Self

import zenoh

from hmrsim.geometry import Pose, yaw_of
from hmrsim.interfaces.hmrsim_msgs import GetOrders
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.simulation_interfaces import GetNamedPoses
from hmrsim_zenoh.client.action_client import ActionClient
from hmrsim_zenoh.client.connection import PATIENCE, Ask, Read, ReadInfo
from hmrsim_zenoh.client.link import Link
from hmrsim_zenoh.client.lockstep import Lockstep, check_name
from hmrsim_zenoh.client.places import NamedPlaces
from hmrsim_zenoh.client.subscription import SimClock, read_clock
from hmrsim_zenoh.errors import (
    BadOptions,
    RequestError,
    RequestTimeout,
    SimulationEnded,
    SimulatorGone,
    SimulatorNotFound,
    Unreachable,
)
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read_often
from hmrsim_zenoh.wire.keys import Keys
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import enclave_of, open_client, unless_closed

if TYPE_CHECKING:
    from hmrsim.actions import Action, F, G, R
    from hmrsim.errors import HmrsimError
    from hmrsim.interfaces.hmrsim_msgs import Order
    from hmrsim_zenoh.client.connection import Reply
    from hmrsim_zenoh.client.subscription import Subscription

ClockChoice = Literal["auto", "realtime", "lockstep"]

_log = logging.getLogger(__name__)

_SUFFIX: Final = "HMRSIM_NAME_SUFFIX"
_ROBOT_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_PAUSE: Final = 0.05
_LOOK_AROUND: Final = 0.5
_RESETS: Final = ("reset_simulation", "load_world", "set_simulation_state")
"""Services of the world by which simulated time may go back."""
# A value's queryable may be declared a moment after the simulator's liveliness token.
_TRIES: Final = 2
_PLACES: Final = Ask("get_named_poses", GetNamedPoses.Request(), GetNamedPoses.Response)
_OPEN: Final[weakref.WeakSet[Client]] = weakref.WeakSet()


class Client:
    """A connection to one simulator; the caller closes it or uses it in a ``with`` statement.

    Attributes:
        keys: How the simulator's keys are spelled.
    """

    def __init__(
        self,
        options: SessionOptions | None = None,
        *,
        clock: ClockChoice = "auto",
        name: str = "client",
        session: zenoh.Session | None = None,
        acknowledge_timeout: float = 10.0,
        grace: float = 1.0,
    ) -> None:
        """Open a session, or borrow one that stays open when the client is closed.

        Args:
            options: Where to connect, and the prefix of all keys; None for the options of the environment, or for the
                defaults with a *session*; see `SessionOptions.from_environment`.
            clock: Whether to take part in lockstep, where time waits for the client; ``auto`` follows the simulator.
            name: The participant's name, unique within a simulator. The value of the environment variable
                ``HMRSIM_NAME_SUFFIX`` is appended, so that the same program can be run twice.
            session: A session to borrow.
            acknowledge_timeout: Wall seconds within which a goal has to be accepted or rejected.
            grace: Wall seconds for which the simulator may be unreachable, as when a router is restarted.

        Raises:
            SimulatorNotFound: No peer answers at the endpoints.
            ConnectionDenied: A peer answers, but denies the connection.
            BadOptions: An endpoint, the prefix, the configuration or the enclave is invalid.
            ValueError: *name* is not a valid name.
        """
        if options is None:
            options = SessionOptions() if session else SessionOptions.from_environment()
        name += os.environ.get(_SUFFIX, "")
        check_name(name)
        try:
            self.keys = Keys(options.prefix)
        except ValueError as error:
            raise BadOptions(f"--prefix: {error}") from None
        self.session = session or open_client(options)
        self._owns_session = session is None
        enclave = enclave_of(options)
        self._link = Link(
            self.session, self.keys, acknowledge_timeout=acknowledge_timeout, grace=grace, enclave=enclave
        )
        self._timeout = options.timeout
        self._choice = clock
        self._clock = clock
        self._name = name
        self._joining = threading.RLock()
        self._run_id = ""
        self._lockstep: Lockstep | None = None
        self._ended: SimulationEnded | None = None
        self._action_clients: dict[tuple[str, str], ActionClient[Any, Any, Any]] = {}
        _OPEN.add(self)

    def __enter__(self) -> Self:
        """Return the client."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close it."""
        self.close()

    @property
    def alive(self) -> bool:
        """Return whether the simulator is alive; the first call waits for an answer."""
        return not self._link.closed and self._link.alive(self._timeout)

    @property
    def absence(self) -> HmrsimError | None:
        """Why the simulator will not answer; None while it is alive or may still come back."""
        return self._link.absence()

    def wait_for_simulator(self, timeout: float) -> None:
        """Wait until the simulator is alive.

        Raises:
            SimulatorNotFound: It is not alive after *timeout* seconds.
            ClientClosed: The client was closed.
        """
        self._link.check_open()
        if not self._link.wait(timeout):
            raise SimulatorNotFound(f"no simulator answers within {timeout:g} s: {self._link.unseen}")

    def info(self, timeout: float = PATIENCE) -> dict[str, Any]:
        """Return the simulator's description: its world, its clock, its robots and their actions.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout: As `get`.
        """
        info: dict[str, Any] = self._answer(ReadInfo(), timeout)
        before, self._run_id = self._run_id, str(info.get("run_id") or "")
        if before and self._run_id != before:
            _log.warning("the simulator was restarted; the goals of the previous run are lost")
        return info

    def get_orders(self, state: str = "", timeout: float = PATIENCE) -> list[Order]:
        """Return the orders of the demand, oldest first: all, or those in one state, such as ``open`` or ``waiting``.

        Of orders that have ended, only the last 1,000 are included.

        Raises:
            RequestError: There is no such state.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout: As `get`.
        """
        asked = Ask("get_orders", GetOrders.Request(state=state), GetOrders.Response)
        response: GetOrders.Response = self._answer(asked, timeout)
        if why := response.result.error_message:
            raise RequestError(f"{self.keys.world(asked.service)}: {why}")
        return response.orders

    def end_run(self, label: str, timeout: float = PATIENCE, /, **values: float | str | bool) -> None:
        """Report how the run ended to the experiment, which then ends it, and to all subscribers of events.

        Args:
            label: A word that describes the end, chosen by the controller, such as ``no_skill``.
            timeout: Wall seconds to wait for the answer.
            values: Further numbers and texts, by name.

        Raises:
            RequestError: The label or a value is invalid.
            SimulatorNotFound, SimulatorGone, Unreachable, RequestTimeout: As `get`.
        """
        request = json.dumps({"label": label, "values": json.dumps(values)}).encode()
        key = self.keys.world("end_run")
        answer = json.loads(self.get(key, timeout, payload=request))
        if why := answer.get("result", {}).get("error_message"):
            raise RequestError(f"{key}: {why}")

    @property
    def places(self) -> NamedPlaces:
        """The waypoints, places and docks of the world by name, as of the first lookup."""
        # A lookup changes nothing, so that it can be repeated if the answer is lost.
        return NamedPlaces(lambda: self._answer(_PLACES, PATIENCE))

    def pose_of(self, robot: str) -> Pose:
        """Return where a robot is, as it reports it in ``odom``.

        Returns:
            x and y in the world's unit of length, yaw in radians, in the frame ``map``.

        Raises:
            RequestError, Unreachable: There is no such robot.
            SimulatorNotFound, SimulatorGone, RequestTimeout: As `get`.
        """
        reported: Odometry = read_often(plain(Odometry), self.get(self.keys.topic(robot, "odom")))
        at = reported.pose.pose
        return Pose(at.position.x, at.position.y, yaw_of(at.orientation.z, at.orientation.w))

    def action_client(self, robot: str, action: Action[G, R, F]) -> ActionClient[G, R, F]:
        """Return the client of one action of a robot; it queries and subscribes to nothing yet.

        Raises:
            ValueError: *robot* is not a valid robot name.
        """
        if not _ROBOT_NAME.fullmatch(robot):
            raise ValueError(
                f"{robot!r} is not a valid robot name; expected letters, digits and underscores, no digit first"
            )
        # All callers share one client, which subscribes to feedback once.
        known = self._action_clients.get((robot, action.name))
        if known is None or known.action is not action:
            known = ActionClient(self, self._link, robot, action)
            self._action_clients[robot, action.name] = known
        return known

    @property
    def lockstep(self) -> Lockstep | None:
        """This client's participation in lockstep; None where simulated time moves by itself.

        The first access asks for the clock mode and joins. So does an access after the simulator has gone, or after the
        clock was set to real time.

        Raises:
            NameTaken: Another participant has this client's name.
            RequestError: The simulator refuses this participant.
            SimulationEnded: The run in which it took part is over, and there is no other one.
            SimulatorNotFound, SimulatorGone, ClientClosed: There is no simulator to join.
            Unreachable, RequestTimeout: The simulator does not report its clock mode within a minute.
        """
        lockstep = self._lockstep
        if lockstep is not None and lockstep.takes_part:
            return lockstep
        with self._joining:
            if self._lockstep is not None and (self._lockstep.over or self._lockstep.lost):
                self._lockstep.close()
                self._ended = self._lockstep.ended
                self._lockstep, self._clock = None, self._choice
            if self._ended is not None and not self._meets_another_run():
                raise self._ended
            self._ended = None
            if self._clock == "auto":
                self._clock = self._simulators_clock()
            if self._clock == "lockstep" and self._lockstep is None:
                self._link.check_open()
                self._lockstep = Lockstep(self._link, self._name)
            lockstep = self._lockstep
        return None if lockstep is None or lockstep.over else lockstep

    def _meets_another_run(self) -> bool:
        """Return whether a simulator answers, and it is another run than before."""
        before = self._run_id
        try:
            self.info(self._timeout)
        except (SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout, UnreadableError):
            return False
        return self._run_id != before

    @property
    def now(self) -> float:
        """Simulated seconds; in lockstep those of this client's last grant, or of its last reset.

        Raises:
            SimulatorNotFound, SimulatorGone, Unreachable, RequestError, RequestTimeout, UnreadableError: As `get`.
        """
        lockstep = self.lockstep
        return read_clock(self.get(self.keys.world("clock"))) if lockstep is None else lockstep.now

    def sleep(self, seconds: float) -> None:
        """Sleep for simulated seconds: in lockstep by advancing time, else by waiting for the clock.

        Returns early when time goes back, as after a reset.

        Raises:
            Dropped: The simulator goes on without this client.
            SimulatorNotFound, SimulatorGone, ClientClosed, Unreachable: There is no simulated time.
        """
        begin = self.now
        end = begin + seconds
        lockstep = self.lockstep
        if lockstep is not None and lockstep.sleep(seconds):
            return
        over = threading.Event()
        clock = SimClock(self, lambda now: None if begin <= now < end else over.set())
        try:
            while not over.wait(_LOOK_AROUND):
                if absence := self._link.absence():
                    raise absence
        finally:
            clock.close()

    def alarm(self, seconds: float, ring: Callable[[], None]) -> SimClock:
        """Call a function, in Zenoh's thread, once so many simulated seconds have passed; close the clock after that.

        In lockstep time does not pass by itself; use `sleep` there.

        Raises:
            ClientClosed: The client was closed.
        """
        return self._link.alarm(seconds, ring)

    def get(self, key: str, timeout: float = PATIENCE, *, payload: bytes | None = None) -> bytes:
        """Return the latest value of a key, or a service's response to *payload*.

        A request with a payload may have changed something and is never sent twice.

        Raises:
            SimulatorNotFound, SimulatorGone: There is no simulator.
            Unreachable: The simulator is alive, but nothing answers on the key.
            Denied: The access control of the simulator denies the request.
            RequestError: The simulator answers with an error.
            RequestTimeout: The answer takes longer than *timeout* seconds.
            ClientClosed: The client was closed.
            ValueError: *key* is not a valid key.
        """
        self._check(key)
        answer: bytes = self._answer(Read(key, payload), timeout)
        if payload is not None and self._lockstep is not None and key in map(self.keys.world, _RESETS):
            self._lockstep.look_at_time()
        return answer

    def _answer(self, asked: ReadInfo | Ask | Read, timeout: float) -> Any:
        """Return the answer to a request; one that changes nothing is repeated if the answer is lost."""
        self._link.check_open()
        world = self.keys.world
        key = asked.key if isinstance(asked, Read) else world(asked.service if isinstance(asked, Ask) else "info")
        tries = 1 if isinstance(asked, Read) and asked.payload is not None else _TRIES
        until = time.monotonic() + timeout
        self._link.follow()
        for _ in range(tries):
            left = max(until - time.monotonic(), _PAUSE)
            pending = self._link.connection.call(asked, timeout=left)
            pending.wait(left + _PAUSE)
            answer = pending.answer
            if isinstance(answer, RequestError):
                raise answer
            if answer is not None:
                return answer
            self._await_simulator(key, until, timeout)
        if until - time.monotonic() < timeout / 2:
            # A query that no queryable receives would have ended at once.
            raise RequestTimeout(f"{key!r}: no answer in {timeout:g} s")
        raise Unreachable(f"nothing answers on {key!r}, though the simulator is there")

    def get_all(self, key: str, timeout: float = PATIENCE) -> dict[str, bytes]:
        """Return the latest values of all keys that match a key expression, as soon as all have answered.

        Those that take longer than *timeout* wall seconds are left out.

        Raises:
            ClientClosed: The client was closed.
            ValueError: *key* is not a valid key.
        """
        self._check(key)
        with unless_closed():
            replies = self.session.get(key, timeout=timeout)
        return {str(reply.ok.key_expr): reply.ok.payload.to_bytes() for reply in replies if reply.ok is not None}

    def ask(self, key: str, payload: bytes, then: Callable[[Reply], None], *, timeout: float) -> None:
        """Call a service and return at once; *then* receives the answer, in a thread of the client or of Zenoh.

        The answer is the reply, the `RequestError` that was replied, or None if nothing comes back within *timeout*
        seconds: then it is unknown whether the request was served.

        Raises:
            ClientClosed: The client was closed.
            ValueError: *key* is not a valid key.
        """
        self._check(key)
        self._link.connection.ask(Read(key, payload), then, timeout=timeout)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, history: bool = False) -> Subscription:
        """Call back with the key and payload of each sample, in the subscription's own thread, until it is closed.

        *key* may be a key expression; with *history* the latest value comes first, where the simulator keeps it.

        Raises:
            ClientClosed: The client was closed.
            ValueError: *key* is not a valid key.
        """
        self._check(key)
        return self._link.subscribe(key, callback, history=history)

    def close(self) -> None:
        """Fail the active goals, close the subscriptions, and close the session unless it was borrowed.

        It must not be called in a callback: it waits for running callbacks.
        """
        # A thread that is joining at this moment may take a while.
        lockstep = self._lockstep
        try:
            if lockstep is not None and not self._link.closed:
                lockstep.close()
        finally:
            self._disconnect()

    def _disconnect(self) -> None:
        """Close without a request to the simulator, which may not answer."""
        _OPEN.discard(self)
        self._link.close()
        if self._owns_session:
            self.session.close()

    def _simulators_clock(self) -> ClockChoice:
        """Return the simulator's clock mode; without a simulator, real time, as with real robots.

        Raises:
            Unreachable, RequestTimeout: The simulator does not report its clock mode within a minute.
        """
        if self._link.connection.in_process:
            return "lockstep"
        limit = time.monotonic() + PATIENCE
        while True:
            try:
                return "lockstep" if self.info(self._timeout).get("clock") == "lockstep" else "realtime"
            except (Unreachable, RequestTimeout):
                # On a busy machine its declarations may still be on their way, and a wrong guess would wait for ever.
                if not self._link.present:
                    return "realtime"
                if time.monotonic() >= limit:
                    raise
                time.sleep(_PAUSE)
            except (SimulatorNotFound, SimulatorGone, RequestError, UnreadableError):
                return "realtime"

    def _check(self, key: str) -> None:
        """Check that the client is open and a key is valid."""
        self._link.check_open()
        try:
            zenoh.KeyExpr(key)
        except zenoh.ZError:
            raise ValueError(f"{key!r} is not a key; chunks are joined by single slashes") from None

    def _await_simulator(self, key: str, until: float, timeout: float) -> None:
        """Wait for the simulator after a request without an answer."""
        while time.monotonic() < until:
            if absence := self._link.absence():
                raise absence
            if self._link.wait(_PAUSE):
                return
        raise RequestTimeout(f"{key!r}: no answer in {timeout:g} s")


@atexit.register
def _disconnect_all() -> None:
    """Disconnect clients that were not closed: the interpreter ends threads that want it, which aborts Zenoh's."""
    for client in list(_OPEN):
        client._disconnect()  # noqa: SLF001 - of this module

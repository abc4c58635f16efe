"""A running world: robots, items, the dispatcher and the events between them. It does no I/O.

It takes `Command`s and gives `Output`s to every `Sink`. The world, its seed and the commands with their times
determine a run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol

from hmrsim.engine.chance import Chance
from hmrsim.engine.environment import Environment
from hmrsim.engine.internal_errors import BUGS, FATAL, InternalErrors, described
from hmrsim.engine.sim_time import end_of_instant, stamp
from hmrsim.engine.subscriptions import EventPublisher, Interest, Telemetry
from hmrsim.events.simulation import PARTICIPATION
from hmrsim.goals.dispatcher import Dispatcher
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.quantities import flaw
from hmrsim.navigation.external_planner import Plans
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.protocol.commands import (
    UNRECORDED,
    CallService,
    CancelGoal,
    ChangeState,
    ForgetResult,
    GetResult,
    InterestChanged,
    Participation,
    PlanAnswered,
    PlannerPresent,
    Read,
    SendGoal,
    Stop,
    StopWaiting,
)
from hmrsim.protocol.goal import Refused, Verdict
from hmrsim.protocol.outputs import Answered, FeedbackSent, Receiver, Sampled, StatusChanged, TimeRestarted
from hmrsim.protocol.sinks import SelectiveSink, hears_commands
from hmrsim.protocol.topics import Topic
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.demand import Demand
from hmrsim.simulation.detections import Detections
from hmrsim.simulation.entities import Roster, installed_actions
from hmrsim.simulation.fault_injector import FaultInjector
from hmrsim.simulation.queries import Readings
from hmrsim.simulation.run_control import Gate
from hmrsim.simulation.scripts import Scripts

if TYPE_CHECKING:
    from simpy import Process

    from hmrsim.actions import AnyAction
    from hmrsim.engine.subscriptions import Reaction
    from hmrsim.items import Item
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output, Restart
    from hmrsim.protocol.sinks import Sink
    from hmrsim.robots.robot import Robot
    from hmrsim.world.model import World


_BATCH = 1_000
"""Events that are processed in one call."""

_MAX_BATCHES = 1_000
"""Batches of one instant after which a command is applied even if more events are due."""

_ROBOT_OUTPUTS = (StatusChanged, FeedbackSent, Sampled)
"""Outputs that a robot publishes itself, so that they are lost while the robot is cut off."""

_IMMEDIATE = (SendGoal, CancelGoal, ChangeState, CallService, PlanAnswered)
"""Commands that may schedule events at the current instant."""


class Service(Protocol):
    """The part of a service that the simulation needs; see `hmrsim.services.Service`."""

    @property
    def request(self) -> type[Message]:
        """The message type of the request."""

    @property
    def serve(self) -> Callable[[Any, Any], Any]:
        """Answers a request, or returns a function to call with the receiver of a later answer."""

    @property
    def changes_world(self) -> bool:
        """Return whether the service changes the world, so that a replay has to repeat it."""

    @property
    def recorded(self) -> Callable[[Any, Any], Any]:
        """Return a request that needs neither file nor network, or the immediate answer."""


class Simulator:
    """A simulation of one world.

    Args:
        world: The world to run, whose names must have been checked, as `load_world` does.
        sinks: Receive the outputs, in this order; the initial state is not an output.
        watchers: Creates the sinks that need the simulator; called at the end of its construction.
        actions: The actions of robots, by name; None for all that are installed.
        services: The services of the world, by name; `hmrsim.services.registry` returns all that are installed.
        hindrance: Returns why time can't advance although `gate` is open; empty if it can.

    Attributes:
        graph: The waypoints and lanes of the world.
        chance: The random numbers of the run.
        gate: Controls whether time may advance.
        plans: The open requests to an external planner.
        demand: The orders of the world.
        detections: The detections of the robots' sensors.
        readings: The latest message of each topic.
        scripts: The scripts that robots run by themselves.
        generation: How often time was reset.
        allow_files: The folder whose files clients may load worlds from; None for none.
    """

    def __init__(
        self,
        world: World,
        settings: RunSettings = RunSettings(),  # noqa: B008 - frozen
        sinks: Sequence[Sink] = (),
        *,
        watchers: Callable[[Simulator], Sequence[Sink]] = lambda _simulator: (),
        actions: Mapping[str, AnyAction] | None = None,
        services: Mapping[str, Service] = MappingProxyType({}),
        hindrance: Callable[[], str] = lambda: "",
    ) -> None:
        self.world = world
        self._own_seed = settings.seed
        self._salt = settings.goal_id_salt
        self.allow_files = settings.allow_files
        self._services = services
        self.env = Environment(self._event_failed)
        self.gate = Gate(self.env, settings.step_size, hindrance)
        self._reactions: list[Reaction] = []
        self._sinks: list[Sink] = []
        # The handlers of each type of output, with their owners.
        self._handlers: dict[type, list[tuple[Reaction | Sink, Callable[[Any], object]]]] = {}
        self._fatal: tuple[Reaction | Sink, BaseException] | None = None
        self.interest = Interest(self._reactions, self._sinks)
        self.telemetry = Telemetry(self.interest)
        self._clock_published = (-1, 0.0)
        self._busy = False
        self.generation = 0
        publisher = self.publisher = EventPublisher(self.env, self.interest, self.emit, self._handlers)
        self._errors = InternalErrors(publisher, strict=settings.strict, mark=self._mark)
        self.dispatcher = Dispatcher(
            self.env,
            installed_actions() if actions is None else actions,
            self.telemetry,
            publisher=publisher,
            errors=self._errors,
            seed=self._id_seed,
            keep_results=settings.keep_results,
            feedback_rate=settings.feedback_rate,
        )
        # Most commands are of these types.
        self._appliers: Mapping[type[Command], Callable[[Any], None]] = {
            GetResult: self.dispatcher.get_result,
            StopWaiting: self.dispatcher.withdraw,
            ForgetResult: self.dispatcher.forget,
            CallService: self._call,
        }
        self.graph = WaypointGraph(world)
        self.chance = Chance()
        self.plans = Plans(self.env, self.emit, publisher)
        self._stopped = False
        self.roster = Roster(
            self.env,
            self.dispatcher,
            self.gate,
            chance=self.chance,
            plans=self.plans,
            publisher=publisher,
            errors=self._errors,
            emit=self.emit,
            leaving=self._leaving,
        )
        self.fault_injector = FaultInjector(
            self.env, self.roster, self.chance, publisher, self._errors, listen=self._subscribe
        )
        self.roster.fill(world, self.graph)
        self.demand = Demand(self.env, self.roster, self.chance, publisher)
        self.detections = Detections(self.roster, self._errors)
        self.readings = Readings(self.env, self.roster, self.dispatcher, self.detections)
        self.begin_chance()
        self.telemetry.start("odom", Topic.ODOM, 0.0, settings.odom_rate, self._emit_odom)
        self.telemetry.start("battery_state", Topic.BATTERY_STATE, 0.0, settings.battery_rate, self._emit_batteries)
        self.telemetry.start("clock", Topic.CLOCK, 0.0, settings.clock_rate, lambda: self.emit(self.readings.clock()))
        self.telemetry.start("detections", Topic.DETECTIONS, 0.0, settings.detection_rate, self._emit_detections)
        self.begin_scripts()
        self._sinks += [*sinks, *watchers(self)]
        self._handlers.clear()
        self._command_sinks = [sink for sink in self._sinks if hears_commands(sink)]
        self._apply(InterestChanged())

    def attach(self, sink: Sink) -> None:
        """Give the outputs to one more sink from now on."""
        self._sinks.append(sink)
        self._handlers.clear()
        if hears_commands(sink):
            self._command_sinks.append(sink)
        self.submit(InterestChanged())

    @property
    def now(self) -> float:
        """The simulated time, in seconds."""
        return self.env.now

    @property
    def seed(self) -> int:
        """The seed of the run: the world's, unless it was replaced."""
        return self.world.seed if self._own_seed is None else self._own_seed

    @property
    def _id_seed(self) -> str:
        """The seed of the ids of goals."""
        return f"{self.seed}/{self._salt}" if self._salt else str(self.seed)

    @property
    def robots(self) -> dict[str, Robot]:
        """All robots, by name; a snapshot, which does not change when robots are spawned or deleted."""
        return self.roster.robots

    @property
    def items(self) -> dict[str, Item]:
        """All items of the world, by name."""
        return self.roster.items

    def begin_chance(self) -> None:
        """Seed the random numbers, and schedule the faults and the orders of the world."""
        self.chance.begin(self.seed)
        self._reactions.clear()
        self._handlers.clear()
        self.fault_injector.begin(self.world, self.seed)
        self.demand.begin(self.world)
        if self.world.demand:
            self.watch_orders()

    def watch_orders(self) -> None:
        """Subscribe the demand to the events of items."""
        self._subscribe(self.demand)

    def _subscribe(self, part: Reaction) -> None:
        """Subscribe a part of the simulation to the outputs that it needs now, until time restarts."""
        if part not in self._reactions:
            self._reactions.append(part)
            self._handlers.clear()
        self.interest.refresh()

    def begin_scripts(self) -> None:
        """Start the scripts that robots run by themselves."""
        self.scripts = Scripts(self.env, self.world, submit=self._apply, publisher=self.publisher)

    def submit(self, command: Command, by: str = "") -> None:
        """Apply a command from outside, after every event of this instant; its outputs go to the sinks.

        The effect of a command thus depends on the time and order of commands only. A command that a sink submits is
        applied immediately, in the middle of an instant.

        *by* is the participant that sent it in lockstep; empty for a client in real time.
        """
        if not (self._busy or isinstance(command, UNRECORDED)):
            self.finish_instant()
        if isinstance(command, CallService):
            call = self._recorded(command)
            if call is None:
                return
            command = call
        if isinstance(command, SendGoal) and command.verdict is not Verdict.REJECT:
            command = self.dispatcher.settled(command)
        if isinstance(command, PlanAnswered) and command.request not in self.plans.awaited:
            return
        if self._command_sinks:
            self._record(command, by)
        try:
            self._apply(command, in_real_time=not by)
        except BUGS as bug:
            # The bug concerns this command only.
            self._command_failed(command, bug, replayed=self._replayed(command))
        if self.gate.limit <= self.env.now:
            self._start_while_paused(command)
        if self._fatal is not None:
            self._check_sinks()

    def _recorded(self, command: CallService) -> CallService | None:
        """Return a call with a request that needs neither file nor network; None if it is answered already."""
        service = self._service(command.service)
        if wrong := flaw(command.request):
            self.answer(command.reply_to, Refused("", None, wrong))
            return None
        try:
            request = service.recorded(self, command.request)
        except BUGS as bug:
            self._command_failed(command, bug, replayed=False)
            return None
        if not isinstance(request, service.request):
            self.answer(command.reply_to, request)
            return None
        return command if request is command.request else command._replace(request=request)

    def _start_while_paused(self, command: Command) -> None:
        """Process the events that a command has scheduled at this instant, as the simulation is paused."""
        if isinstance(command, _IMMEDIATE):
            while self.process_events(self.env.now, _BATCH):
                pass

    def _record(self, command: Command, by: str) -> None:
        for sink in self._command_sinks:
            try:
                sink.commanded(command, by, self.env.now)
            except BUGS as bug:
                self._sink_failed(sink, bug)

    def _replayed(self, command: Command) -> bool:
        if isinstance(command, CallService):
            return self._service(command.service).changes_world
        return not isinstance(command, UNRECORDED)

    def _command_failed(self, command: Command, bug: BaseException, *, replayed: bool) -> None:
        part = f"service {command.service}" if isinstance(command, CallService) else type(command).__name__
        self._errors.handle(part, bug, getattr(command, "robot", ""), replayed=replayed)
        self.answer(getattr(command, "reply_to", None), Refused("", None, f"bug in {part}: {described(bug)}"))

    def _event_failed(self, bug: BaseException, process: Process | None) -> None:
        if process is None or not self.dispatcher.process_failed(process, bug):
            self._errors.handle("an event", bug)

    def _mark(self, robot: str, error: str) -> None:
        self.fault_injector.mark(robot, error)

    def _apply(self, command: Command, *, in_real_time: bool = False) -> None:
        if isinstance(command, SendGoal):
            self.dispatcher.send_goal(command, in_real_time=in_real_time)
            return
        apply = self._appliers.get(type(command))
        if apply is not None:
            apply(command)
            return
        match command:
            case CancelGoal() | ChangeState():
                self._end_goals(command)
            case Read():
                self.emit(Answered(command.reply_to, self.readings.read(command)))
            case InterestChanged():
                self._change_interest()
            case Participation(participant, change, why):
                self.publisher.publish(lambda: PARTICIPATION[change](participant, why))
            case PlannerPresent(present):
                self.plans.announce(present=present)
            case PlanAnswered():
                self.plans.answer(command)
            case Stop(reason):
                self._stop(reason)

    def _end_goals(self, command: CancelGoal | ChangeState) -> None:
        if isinstance(command, CancelGoal):
            self.dispatcher.cancel_goal(command)
        else:
            self.dispatcher.change_state(command)
        self.env.take_urgent()

    def _change_interest(self) -> None:
        for sink in self._sinks:
            if isinstance(sink, SelectiveSink) and sink.varies:
                self._handlers.clear()
        self.interest.refresh()
        self.dispatcher.feedback.interest_changed()
        self.telemetry.refresh(self.now)
        if not self.interest.detections:
            self.detections.forget()

    def _call(self, command: CallService) -> None:
        answer = self._service(command.service).serve(self, command.request)
        if isinstance(answer, Message):
            self.answer(command.reply_to, answer)
        else:
            answer(partial(self.answer, command.reply_to))

    def _service(self, name: str) -> Service:
        if name not in self._services:
            known = ", ".join(self._services) or "none: give the simulator those of hmrsim.services.registry()"
            raise ValueError(f"no service {name!r}; there are {known}")
        return self._services[name]

    def answer(self, reply_to: Any, answer: Any) -> None:
        """Send the answer to a command, if it expects one."""
        if isinstance(reply_to, Receiver):
            reply_to.succeed(answer)
        elif reply_to is not None:
            self.emit(Answered(reply_to, answer))

    def stop(self, reason: str = "the simulation was stopped") -> None:
        """Abort every active goal and end the simulation, which must not be run afterwards."""
        if not self._stopped:
            self._stopped = True
            self.submit(Stop(reason))

    def _stop(self, reason: str) -> None:
        # After the stop, changes of subscriptions are no longer received.
        self.interest.refresh()
        self.gate.halt(reason)
        self.dispatcher.stop(reason, stuck=self.roster.admission.causes.stuck)
        # The interrupts stop the robots.
        self.env.take_urgent()

    def emit(self, output: Output) -> None:
        """Give an output to the sinks, unless its robot is cut off."""
        if self.dispatcher.cut_off and isinstance(output, _ROBOT_OUTPUTS) and output.robot in self.dispatcher.cut_off:
            return
        try:
            handlers = self._handlers[type(output)]
        except KeyError:
            handlers = self._handlers[type(output)] = self._handlers_of(type(output))
        for owner, handler in handlers:
            try:
                handler(output)
            except BUGS as bug:
                # The other sinks still receive the output.
                self._sink_failed(owner, bug)

    def _handlers_of(self, kind: type) -> list[tuple[Reaction | Sink, Callable[[Any], object]]]:
        """Return the handlers of a type of output: first those of reactions, then those of sinks."""
        handlers: list[tuple[Reaction | Sink, Callable[[Any], object]]] = []
        for part in self._reactions:
            handler = part.handler_for(kind)
            if handler is not None:
                handlers.append((part, handler))
        for sink in self._sinks:
            handler = sink.handler_for(kind) if isinstance(sink, SelectiveSink) else sink.emit
            if handler is not None:
                handlers.append((sink, handler))
        return handlers

    def _sink_failed(self, sink: Reaction | Sink, bug: BaseException) -> None:
        if not isinstance(bug, FATAL):
            self._errors.handle(type(sink).__name__, bug, replayed=False)
            return
        # End the run after this instant, so that all goals end and the other sinks receive their ends.
        self._fatal = (sink, bug)
        self.halt()

    def _check_sinks(self) -> None:
        """Drop the sink that failed fatally, if any, and raise its error."""
        if self._fatal is None:
            return
        (sink, bug), self._fatal = self._fatal, None
        self._sinks[:] = [each for each in self._sinks if each is not sink]
        self._handlers.clear()
        self._command_sinks = [each for each in self._command_sinks if each is not sink]
        raise bug

    def _emit_detections(self) -> None:
        for seen in self.detections.changed(self.dispatcher.cut_off):
            self.emit(seen)

    def _emit_batteries(self) -> None:
        for state in self.readings.battery_states():
            self.emit(state)

    def _emit_odom(self) -> None:
        for robot in self.robots.values():
            self.emit(self.readings.odom(robot))

    def _leaving(self, robot: str) -> None:
        """End the faults of a robot that is about to be removed."""
        self.fault_injector.end_all_on(robot)

    def replace_world(self, world: World) -> None:
        """Replace the world; all goals and processes of the current one must have ended."""
        self.world = world
        self.graph = WaypointGraph(world)
        self.dispatcher.servers.reseed(self._id_seed)
        self.roster.fill(world, self.graph)

    def restart_time(self, cause: Restart, loaded: World | None = None) -> None:
        """Reset time to 0, in the world that was *loaded*, if any; no process may be waiting for a later time."""
        ended = stamp(self.now)
        self.env.restart()
        self.generation += 1
        self.emit(TimeRestarted(ended, cause, loaded))

    @property
    def limit(self) -> float:
        """The time up to which the simulation may run; infinite while it plays."""
        return self.gate.limit

    @property
    def paused(self) -> bool:
        """Return whether the simulation is paused."""
        return self.gate.limit <= self.env.now

    @property
    def next_event(self) -> float:
        """When the next event is due; infinite if only alarms and abandoned events are scheduled."""
        return math.inf if self.env.idle else self.env.peek()

    @property
    def next_due(self) -> float:
        """The time of the next event or sample; infinite if there is none."""
        return min(self.env.peek(), self.telemetry.next_due)

    def settle(self) -> None:
        """Publish the clock to its subscribers: time stands still until the next event."""
        now = (self.generation, self.now)
        if self._clock_published != now and self.interest.clock:
            self._clock_published = now
            self.emit(self.readings.clock())

    def process_events(self, until: float, most: int, *, idle: bool = True) -> bool:
        """Process up to *most* events and samples that are due by *until*; at one instant events come first.

        *until* is in simulated seconds. If *idle* is False, stop when `next_event` is infinite.

        Returns:
            Whether more may be due: *most* were processed, or the simulation was halted.
        """
        limit = self.gate.limit
        return self._process(until if limit == math.inf else min(until, end_of_instant(limit)), most, idle=idle)

    def _process(self, until: float, most: int, *, idle: bool) -> bool:
        """Process events and samples as `process_events` does, without the gate's limit."""
        env, telemetry = self.env, self.telemetry
        busy, processed = self._busy, 0
        env.horizon, self._busy = until, True
        try:
            while processed < most:
                sample, event = telemetry.next_due if self.interest.sampled else math.inf, env.peek()
                due = min(sample, event)
                if due > env.horizon or due == math.inf or not (idle or not env.idle):
                    break
                # An event may schedule a sample before the next event; a sample may halt the run.
                if sample < event:
                    self._sample()
                    processed += 1
                else:
                    processed += env.process_events(1 if self.interest.sampled else most - processed, idle=idle)
                if self._fatal is not None:
                    self._check_sinks()
        finally:
            self._busy = busy
        return processed >= most or env.horizon < until

    def finish_instant(self) -> None:
        """Process everything that is due in this nanosecond, even while the simulation is paused.

        The number of batches is limited: if a bug schedules events at one instant forever, a command can still end it.
        """
        until = end_of_instant(self.env.now)
        if self.env.peek() > until and not (self.interest.sampled and self.telemetry.next_due <= until):
            return
        for _ in range(_MAX_BATCHES):
            if not self._process(until, _BATCH, idle=True):
                return

    def _sample(self) -> None:
        try:
            self.telemetry.sample(self.advance_clock)
        except BUGS as bug:
            # For instance, a component's message is invalid.
            self._errors.handle("a sample", bug, replayed=False)

    def halt(self) -> None:
        """End the current `process_events` after the remaining events of this instant."""
        self.env.horizon = end_of_instant(self.env.now)

    def advance(self, until: float) -> None:
        """Process everything that is due by *until*, then advance time to *until*."""
        while self.process_events(until, _BATCH):
            pass
        self.advance_clock(min(until, self.gate.limit))

    def run(self, until: float = math.inf) -> None:
        """Run until nothing is scheduled or *until* is reached, as fast as possible."""
        while self.process_events(until, _BATCH, idle=False):
            pass
        if until < math.inf:
            self.advance(until)

    def run_scripts(self, until: float = math.inf) -> None:
        """Run until every script has ended, or *until* is reached."""
        while self.scripts.running and self.process_events(until, _BATCH, idle=False):
            pass
        self.finish_instant()
        if self.scripts.running and until < math.inf:
            self.advance(until)

    def advance_clock(self, to: float) -> None:
        """Advance time to *to*, rounded to whole nanoseconds, if it is earlier; no event may be due before.

        Traces have times in whole nanoseconds, so a replay reaches exactly the same times.
        """
        if to > self.env.now and (whole := stamp(to)) > stamp(self.env.now):
            self.env.advance_clock(min(whole / NANOSECONDS, self.env.peek()))

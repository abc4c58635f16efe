"""A vehicle as a state machine: each transition by its verb, and random walks."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from simpy import Interrupt

from hmrsim.errors import GoalAborted
from hmrsim.geometry import SAME_PLACE, distance, foot
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import FollowPath, NavigateToPose, Spin, Wait
from hmrsim.navigation.motion import drive_of, spin, straight
from hmrsim.protocol.commands import CancelGoal, SendGoal
from hmrsim.protocol.topics import Topic
from hmrsim.robots import mobile_base
from hmrsim.robots.vehicle_state import TRANSITIONS, IllegalTransition, VehicleEvent, VehicleState, next_state
from hmrsim.traffic.policies import Policy
from hmrsim.traffic.policies import registry as policies
from hmrsim.traffic.policies.reserve import Reserve, ReserveSettings
from tests.profiles import examples
from tests.simulation import simulate

if TYPE_CHECKING:
    from collections.abc import Callable, Generator

    from hmrsim.robots.robot import Robot
    from tests.simulation import Run


S, E = VehicleState, VehicleEvent
EVENTS = frozenset({Topic.EVENTS})

# --- each transition ------------------------------------------------------------------------------------------------

WORLD = {
    "waypoints": {"a": [0, 0], "b": [10, 0], "c": [20, 0], "up": [10, 10], "bay": [0, 5], "nook": [-5, 0]},
    "lanes": [["a", "b"], ["b", "c"], ["a", "up"], ["up", "c"], ["a", "bay"], ["a", "nook"]],
    "robot_types": {"cart": {"base": {"turning_rate": 1.0}}},
    "robots": {"ann": {"type": "cart", "at": "a"}, "bob": {"type": "cart", "at": "b"}},
    "traffic": {"policy": "passive", "patience": None},
}
"""The quickest way from a to c leads by b, where bob stands; another one leads by up."""


class Passive(Reserve):
    """Reservations that resolve nothing, so that a vehicle waits until a test ends that."""

    def blocked(self, robot: object) -> None:
        """Do nothing: no vehicle is blocked here."""

    def stays_aside(self, _robot: object) -> bool:
        """Return True: a vehicle that has yielded stays there."""
        return True


@dataclass
class Stage:
    """One vehicle and its transitions."""

    run: Run
    robot: Robot
    seen: list[tuple[VehicleState, VehicleEvent]]
    begun: list[Generator[Any, Any, None]] = field(default_factory=list)

    def begin(self, process: object) -> None:
        """Start an activity that can be aborted."""

        def pursue() -> Generator[Any, Any, None]:
            with suppress(GoalAborted, Interrupt):
                yield from process

        self.begun.append(pursue())
        self.run.simulator.env.process(self.begun[-1])
        self.run.simulator.env.take_urgent()

    def drive(self, x: float = 20.0, y: float = 0.0) -> None:
        self.begin(self.robot.drive(self.robot.plan_to((x, y)), None))

    def spin(self) -> None:
        self.begin(self.robot.perform(drive_of(spin(self.robot.pose(), math.pi, 1.0))))

    def yield_to(self, name: str) -> None:
        lanes = self.run.simulator.graph.lanes
        self.robot.yield_along([lanes.legs[lanes.numbers["a", name]]], "other")

    def finish(self) -> None:
        """Advance time until the vehicle is at rest."""
        self.run.simulator.run()

    def snapshot(self) -> object:
        """Return everything that an illegal event must not change."""
        robot = self.robot
        legs = [leg.lane for leg in robot.legs_ahead]
        return (robot.state, robot.pose(), legs, robot.recoveries, robot.rerouted, robot.disabled)


@pytest.fixture
def stage(monkeypatch):
    """Yield an idle vehicle, in a world whose traffic policy resolves nothing."""
    policy = Policy("passive", ReserveSettings, Passive)
    monkeypatch.setitem(policies(), "passive", policy)
    run = simulate(WORLD, topics=EVENTS)
    robot = run.simulator.robots["ann"]
    seen, next_state = [], mobile_base.next_state

    def watched(state: VehicleState, event: VehicleEvent) -> VehicleState:
        after = next_state(state, event)
        seen.append((state, event))
        return after

    monkeypatch.setattr(mobile_base, "next_state", watched)
    stage = Stage(run, robot, seen)
    yield stage
    # A drive that is collected as garbage halts its vehicle, which the next test would see.
    for begun in stage.begun:
        begun.close()


def blocked(stage: Stage) -> None:
    """Make it wait for bob."""
    stage.drive()


def yielding(stage: Stage) -> None:
    """Make it yield on its route."""
    stage.drive()
    stage.yield_to("bay")


def maneuver_blocked(stage: Stage) -> None:
    """Make it step back as it starts to drive straight ahead."""
    stage.begin(stage.robot.perform(drive_of(straight(stage.robot.pose(), (5.0, 0.0), speed=1.0))))
    stage.robot.step_back()


def yield_blocked(stage: Stage) -> None:
    """Make it step back as it starts to yield."""
    yielding(stage)
    stage.robot.step_back()


def yielded(stage: Stage) -> None:
    """Make it wait aside."""
    yielding(stage)
    stage.finish()


INTO: dict[VehicleState, Callable[[Stage], None]] = {
    S.IDLE: lambda _stage: None,
    S.WORKING: lambda stage: stage.robot.begin_work(),
    S.DISABLED: lambda stage: stage.robot.disable("breakdown", "ann has broken down"),
    S.DRIVING: lambda stage: stage.drive(0.0, 5.0),
    S.MANEUVERING: Stage.spin,
    S.YIELDING: yielding,
    S.BLOCKED: blocked,
    S.MANEUVER_BLOCKED: maneuver_blocked,
    S.YIELD_BLOCKED: yield_blocked,
    S.YIELDED: yielded,
}
"""How a vehicle that stands idle comes into each state."""

BY: dict[VehicleEvent, Callable[[Stage], None]] = {
    E.SET_OUT: Stage.drive,
    E.MANEUVER: Stage.spin,
    E.YIELD: lambda stage: stage.yield_to("nook"),
    E.BLOCK: lambda stage: stage.robot.step_back(),
    E.RESUME: lambda stage: stage.robot.go_on(),
    E.REROUTE: lambda stage: stage.robot.reroute(
        [("a", "b"), ("a", "bay"), ("bay", "a")][: 2 + stage.robot.state.yields]
    ),
    E.REDIRECT: lambda stage: stage.drive(10.0, 10.0),
    E.RESCALE: lambda stage: stage.robot.scale_speed(0.5),
    E.ARRIVE: Stage.finish,
    E.HALT: lambda stage: stage.robot.halt(),
    E.WORK: lambda stage: stage.robot.begin_work(),
    E.FINISH_WORK: lambda stage: stage.robot.finish_work(),
    E.DISABLE: lambda stage: stage.robot.disable("battery_empty", "battery empty"),
    E.ENABLE: lambda stage: stage.robot.enable("breakdown"),
}
"""The verb that each event comes of."""


@pytest.mark.parametrize("state", S)
def test_verbs_lead_into_each_state(stage, state):
    INTO[state](stage)

    assert state is stage.robot.state


@pytest.mark.parametrize(("state", "event"), [each for each in TRANSITIONS if each != (S.YIELDED, E.ARRIVE)])
def test_each_transition_is_made_by_its_verb(stage, state, event):
    INTO[state](stage)
    stage.seen.clear()
    BY[event](stage)

    assert (state, event) == stage.seen[0]


def test_a_vehicle_that_has_yielded_and_goes_nowhere_is_idle(stage):
    stage.yield_to("bay")
    stage.finish()

    assert [(S.IDLE, E.YIELD), (S.YIELDING, E.ARRIVE), (S.YIELDED, E.ARRIVE)] == stage.seen
    assert S.IDLE is stage.robot.state


def test_a_yielded_vehicle_without_a_route_informs_traffic(stage, monkeypatch):
    """Other vehicles may wait for its next move."""
    told = []
    monkeypatch.setattr(Passive, "halted", lambda _rules, robot: told.append(robot.name))
    yielding(stage)
    stage.run.ask("inject_fault", {"type": "lane_closed", "lane": ["a", "bay"]})
    stage.finish()

    assert (["ann"], S.IDLE) == (told, stage.robot.state)


def test_a_blocked_maneuver_is_resumed_unchanged(stage):
    """A vehicle that backs up does not turn around and drive ahead."""
    stage.begin(stage.robot.perform(drive_of(straight(stage.robot.pose(), (-5.0, 0.0), speed=0.5))))
    stage.robot.step_back()
    stage.robot.go_on()
    stage.finish()

    assert (10.0, (-5.0, 0.0, 0.0)) == (stage.run.simulator.now, tuple(stage.robot.pose()))


def illegal(*events: VehicleEvent) -> list[tuple[VehicleState, VehicleEvent]]:
    """Return the pairs of a state and one of these events that are not in the table."""
    return [pair for pair in product(S, events) if pair not in TRANSITIONS]


@pytest.mark.parametrize(("state", "event"), illegal(E.YIELD, E.BLOCK, E.RESUME))
def test_an_illegal_order_of_traffic_is_refused_without_a_change(stage, state, event):
    """It is a bug of the policy."""
    INTO[state](stage)
    before = stage.snapshot()

    with pytest.raises(IllegalTransition):
        BY[event](stage)
    assert before == stage.snapshot()


@pytest.mark.parametrize(("state", "event"), illegal(E.REROUTE, E.HALT, E.FINISH_WORK, E.ENABLE))
def test_a_verb_without_a_transition_changes_nothing(stage, state, event):
    INTO[state](stage)
    stage.seen.clear()
    before = stage.snapshot()
    BY[event](stage)

    assert ([], before) == (stage.seen, stage.snapshot())


@pytest.mark.parametrize("verb", ["drive", "perform"])
def test_a_disabled_vehicle_aborts_its_goal_with_the_cause(stage, verb):
    robot = stage.robot
    INTO[S.DISABLED](stage)
    what = (robot.plan_to((20.0, 0.0)), None) if verb == "drive" else (drive_of(spin(robot.pose(), 1.0, 1.0)),)
    before = stage.snapshot()

    with pytest.raises(GoalAborted, match="ann has broken down"):
        next(getattr(robot, verb)(*what))
    assert before == stage.snapshot()


def test_a_vehicle_is_disabled_until_its_last_cause_ends(stage):
    """Of several causes it reports the first."""
    robot = stage.robot
    robot.disable("breakdown", "broken")
    robot.disable("battery_empty", "empty")
    robot.enable("breakdown")
    states = [(robot.state, robot.disabled)]
    robot.enable("battery_empty")

    assert [(S.DISABLED, "empty"), (S.IDLE, "")] == [*states, (robot.state, robot.disabled)]


def test_a_goal_and_a_breakdown_at_one_instant_leave_the_robot_where_it_is():
    run = simulate({**WORLD, "traffic": {"policy": "reserve"}}, topics=EVENTS)
    run.simulator.submit(go("ann", (20.0, 0.0), 1))
    start = run.simulator.robots["ann"].pose().point
    run.ask("inject_fault", {"type": "breakdown", "robot": "ann"})
    run.simulator.run()

    assert "ABORTED" == run.log.changes(f"{1:032x}")[-1][1]
    assert [(0.0, {"robot": "ann", "at": [*start]})] == run.log.happened("stopped")


# --- random walks ---------------------------------------------------------------------------------------------------

GRID = {
    "waypoints": {f"n{x}{y}": [x * 10.0, y * 10.0] for x in range(3) for y in range(2)} | {"bay": [-10.0, 0.0]},
    "lanes": [
        *([f"n{x}{y}", f"n{x + 1}{y}"] for x in range(2) for y in range(2)),
        *([f"n{x}0", f"n{x}1"] for x in range(3)),
        ["bay", "n00"],
    ],
}
NAMES = ["r0", "r1", "r2", "r3"]
POINTS = sorted(tuple(point) for point in GRID["waypoints"].values())
LANES = [tuple(lane) for lane in GRID["lanes"]]

names, points = st.sampled_from(NAMES), st.sampled_from(POINTS)
steps = st.one_of(
    st.tuples(st.just("go"), names, points),
    st.tuples(st.just("go"), names, points),
    st.tuples(st.just("follow"), names, points),
    st.tuples(st.just("spin"), names, st.sampled_from([1.0, -3.0])),
    st.tuples(st.just("wait"), names, st.sampled_from([1, 10])),
    st.tuples(st.just("cancel"), names, st.none()),
    st.tuples(st.just("halt"), names, st.none()),
    st.tuples(st.just("reroute"), names, st.sampled_from(LANES)),
    st.tuples(st.just("disable"), names, st.sampled_from(["breakdown", "battery_empty"])),
    st.tuples(st.just("enable"), names, st.sampled_from(["breakdown", "battery_empty"])),
    st.tuples(st.just("slip"), names, st.sampled_from([0.25, 0.5, 1.0])),
    st.tuples(st.just("close"), names, st.sampled_from(LANES)),
    st.tuples(st.just("open"), names, st.none()),
    st.tuples(st.just("push"), names, st.none()),
    st.tuples(st.just("push"), names, st.none()),
    st.tuples(st.just("advance"), names, st.sampled_from([0.5, 2.5, 5.0])),
    st.tuples(st.just("events"), names, st.integers(1, 3)),
)


def pose_stamped(point: tuple[float, float]) -> PoseStamped:
    return PoseStamped(pose=Pose(position=Point(x=point[0], y=point[1])))


def go(name: str, point: tuple[float, float], number: int) -> SendGoal:
    return SendGoal(name, "navigate_to_pose", NavigateToPose.Goal(pose=pose_stamped(point)), f"{number:032x}")


class Walk:
    """Vehicles that get random events, and are checked after each."""

    def __init__(self, policy: str, base: dict[str, float]) -> None:
        at = ["n00", "n10", "n20", "n11"]
        robots = {name: {"type": "cart", "at": place} for name, place in zip(NAMES, at, strict=True)}
        world = {**GRID, "robot_types": {"cart": {"base": {"speed": 2.0, **base}}}, "robots": robots}
        self.run = simulate({**world, "traffic": {"policy": policy, "patience": 40.0}}, topics=EVENTS)
        self.simulator = self.run.simulator
        self.before = {name: (0.0, robot.pose()) for name, robot in self.simulator.robots.items()}

    def step(self, number: int, what: str, name: str, how: Any) -> None:
        """Trigger one event, or advance time."""
        simulator, robot = self.simulator, self.simulator.robots[name]
        closures = simulator.roster.admission.closures

        def send(action: str, message: Any) -> None:
            simulator.submit(SendGoal(name, action, message, f"{number:032x}"))

        verbs = {
            "go": lambda: simulator.submit(go(name, how, number)),
            "follow": lambda: send("follow_path", FollowPath.Goal(path={"poses": [pose_stamped(how)]})),
            "spin": lambda: send("spin", Spin.Goal(target_yaw=how)),
            "wait": lambda: send("wait", Wait.Goal(time=Duration(sec=how))),
            "cancel": lambda: simulator.submit(CancelGoal(name, "navigate_to_pose")),
            "halt": lambda: self.halt(robot),
            "reroute": lambda: robot.reroute([how]),
            "push": lambda: self.push(robot),
            "disable": lambda: robot.disable(how, how),
            "enable": lambda: robot.enable(how),
            "slip": lambda: robot.scale_speed(how),
            "close": lambda: closures.close([how, how[::-1]], "test", "closed"),
            "open": lambda: closures.open("test"),
            "advance": lambda: self.pass_events(how),
            "events": lambda: self.pass_events(0.0, how),
        }
        verbs[what]()
        self.check()

    def halt(self, robot: Robot) -> None:
        """Stop a vehicle, and abort its goal if it has one."""
        self.simulator.dispatcher.free(robot.name, "halted", "moved")
        self.simulator.env.take_urgent()
        robot.halt()

    def push(self, robot: Robot) -> None:
        """Make a vehicle yield by a free lane, if it may."""
        admission = self.simulator.roster.admission
        rules = admission._rules
        if rules is None or not robot.may_yield:
            return
        for way in rules.ways.leaving(robot):
            if rules.slots.exchange([(robot, way.slots)]):
                admission.push(robot, way.legs, robot)
                return

    def pass_events(self, seconds: float, most: float = math.inf) -> None:
        """Process events until some time has passed, but only so many."""
        until = self.simulator.now + seconds if seconds or most == math.inf else math.inf
        taken = 0
        while taken < most and self.simulator.process_events(until, 1, idle=False):
            taken += 1
            self.check()
        if until < math.inf and taken < most:
            self.simulator.advance(until)

    def check(self) -> None:
        """Fail if a vehicle is in an impossible state."""
        for name, robot in self.simulator.robots.items():
            self._check_state(robot)
            self._check_motion(name, robot)
            if self.simulator.roster.admission._rules is not None:
                self._check_slots(robot)

    def _check_state(self, robot: Robot) -> None:
        state, waits = robot.state, robot in self.simulator.roster.admission.waits
        assert bool(robot.disabled_reasons) is (state is S.DISABLED)
        assert (robot.piece is not None) is state.moves
        assert (robot.next_leg is not None or robot.piece is not None or state.waits) is not state.stands
        assert not waits or state.waits
        assert state is not S.BLOCKED or waits

    def _check_motion(self, name: str, robot: Robot) -> None:
        """Fail if a vehicle has jumped, or moved while it stood."""
        (before, there), now, here = self.before[name], self.simulator.now, robot.pose()
        self.before[name] = now, here
        assert distance(there.point, here.point) <= 2.0 * (now - before) + 1e-6

    def _check_slots(self, robot: Robot) -> None:
        """Fail if a vehicle holds slots that it is not on, or drives without a slot."""
        rules, lanes = self.simulator.roster.admission._rules, self.simulator.graph.lanes
        held, leg, here = rules.held(robot), robot.next_leg, robot.pose().point
        if robot.state.moves and leg is not None:
            assert {*rules.slots.of(leg)} <= {*held}
            return
        coming = rules.slots.of(robot.legs_ahead[0]) if robot.state.moves and robot.legs_ahead else ()
        for slot in held:
            if slot in coming:
                continue
            if slot in rules.slots.points:
                away = distance(here, rules.slots.points[slot])
            elif slot < len(lanes.points):
                away = distance(here, lanes.points[slot])
            else:
                ends = [lanes.points[lanes.names.index(end)] for end in lanes.tracks[slot - len(lanes.points)]]
                away = distance(here, foot(here, *ends))
            assert away <= 2 * SAME_PLACE, (robot.name, robot.state, here, held)


def test_a_vehicle_does_not_turn_for_a_rounding_error():
    """A robot stopped in the middle of a lane is 9e-16 m beside it."""
    walk = Walk("reserve", {"turning_rate": 0.5, "acceleration": 0.5})
    robot = walk.simulator.robots["r0"]
    stopped = [("go", (0.0, 10.0)), ("slip", 0.25), ("advance", 5.0), ("go", (-10.0, 0.0)), ("events", 3)]
    for number, (what, how) in enumerate([*stopped, ("advance", 0.5), ("go", (-10.0, 0.0)), ("events", 2)], 1):
        walk.step(number, what, "r0", how)

    assert (("n01", "n00"), -math.pi / 2) == (robot.next_leg.lane, robot.pose().yaw)


@pytest.mark.parametrize("policy", ["free", "reserve", "priority"])
@examples(60)
@given(
    base=st.fixed_dictionaries(
        {}, optional={"turning_rate": st.sampled_from([0.5, 2.0]), "acceleration": st.sampled_from([0.5, 2.0])}
    ),
    walk=st.lists(steps, min_size=20, max_size=60),
)
def test_random_walks_keep_the_invariants(policy, base, walk):
    vehicles = Walk(policy, base)
    vehicles.check()
    for number, (what, name, how) in enumerate(walk, 1):
        vehicles.step(number, what, name, how)
    for name in NAMES:
        for cause in ("breakdown", "battery_empty"):
            vehicles.simulator.robots[name].enable(cause)
    vehicles.pass_events(500.0)

    ends = {
        vehicles.run.log.changes(f"{number:032x}")[-1][1]
        for number, (what, _, _) in enumerate(walk, 1)
        if what in ("go", "follow", "spin", "wait") and vehicles.run.log.changes(f"{number:032x}")
    }
    assert ends <= {"SUCCEEDED", "ABORTED", "CANCELED"}
    assert {S.IDLE} >= {robot.state for robot in vehicles.simulator.robots.values() if not robot.waits}


def test_each_state_stands_moves_or_waits():
    assert {1} == {state.stands + state.moves + state.waits for state in VehicleState}


@pytest.mark.parametrize("event", VehicleEvent)
def test_events_follow_the_table_and_others_are_refused(event):
    for state in VehicleState:
        if (state, event) in TRANSITIONS:
            assert TRANSITIONS[state, event] is next_state(state, event)
        else:
            with pytest.raises(IllegalTransition, match=f"{event.value} is illegal .* {state.value}"):
                next_state(state, event)


def test_every_state_can_be_reached_and_left():
    reached = {VehicleState.IDLE}
    for _ in VehicleState:
        reached |= {after for (state, _), after in TRANSITIONS.items() if state in reached}
    back = {VehicleState.IDLE}
    for _ in VehicleState:
        back |= {state for (state, _), after in TRANSITIONS.items() if after in back}

    assert (set(VehicleState), set(VehicleState)) == (reached, back)


def test_only_moving_and_waiting_states_can_be_halted():
    for state, event in product(VehicleState, [VehicleEvent.HALT]):
        assert ((state, event) in TRANSITIONS) is not state.stands


def test_only_a_vehicle_that_stands_is_disabled_and_only_enabling_frees_it():
    before = {state for state, event in TRANSITIONS if event is VehicleEvent.DISABLE}
    after = {event for (state, event), to in TRANSITIONS.items() if state is VehicleState.DISABLED and to is not state}

    assert all(state.stands for state in before)
    assert {VehicleEvent.ENABLE} == after


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((2.0, 8.0), True),
        ((2.0, 8.9), True),
        ((2.9, 8.0), True),
        ((2.0, 9.0), False),
        ((2.9, 8.9), False),
        ((8.0, 2.0), False),
        ((2.0, 2.0), False),
    ],
)
def test_a_robot_within_a_metre_is_inside_a_circle(point, expected):
    run = simulate({"robots": {"eve": {"at": [2.0, 8.0]}}})

    assert expected is run.simulator.robots["eve"].motion.is_within(1.0, point)

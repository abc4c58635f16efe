"""ROS 2's wire: what messages and goals cost, against JSON's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from benchmarks._fleet import SIDE, Wanderers, grid_world, plan_everything
from benchmarks._report import Row
from benchmarks._ros2_wire import Graph, RosGoalSender, open_session, type_of
from benchmarks._timing import Rounds, Variant, interleaved, microseconds
from benchmarks._wire import GoalSender, served
from hmrsim.actions import registry
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.program.memory import collect_rarely
from hmrsim.protocol.goal import GoalEntry, GoalStatus
from hmrsim.protocol.outputs import FeedbackSent, StatusChanged
from hmrsim.services import registry as all_services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim_zenoh.ros2.names import names_of
from hmrsim_zenoh.ros2.publishing.publications import Publications
from hmrsim_zenoh.ros2.wires import RmwZenoh
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_server

if TYPE_CHECKING:
    from hmrsim.protocol.sinks import Sink
    from hmrsim.world.model import World

QUICK: dict[str, Any] = {"rounds": 20}

_AT_ONCE = 1000
"""Calls that are timed together, where one takes microseconds."""
_LIMIT = 10.0
_NEAR_NOTHING = 1.05
_NEAR_JSON = 1.3
_WIRES = (RmwZenoh(),)
_DRIVING = 20
_SPAN = 1000.0
"""Simulated seconds that robots drive in one measurement."""
_GOAL_ID = "0123456789abcdef0123456789abcdef"


def run(*, rounds: int = 300, side: int = SIDE) -> list[Row]:
    """Return what messages cost, and what goals cost against JSON's."""
    return [
        *_messages(rounds),
        _unheard(grid_world(_DRIVING, side=side), max(1, rounds // 20)),
        *_goals(rounds),
    ]


# --- messages ----------------------------------------------------------------------------------------------------


def _messages(rounds: int) -> list[Row]:
    """Return microseconds a message, in this process."""
    feedback = _feedback("robot_0")
    type_ = type_of("navigate_to_pose").feedback
    message = {"goal_id": {"uuid": bytes.fromhex(_GOAL_ID)}, "feedback": feedback.feedback}
    payload = type_.encode(message)
    executing, succeeded = (_status(status) for status in (GoalStatus.EXECUTING, GoalStatus.SUCCEEDED))
    with _published(grid_world(1, side=2)) as (_, publications):

        def change() -> None:
            publications.emit(executing)
            publications.emit(succeeded)

        calls: dict[str, tuple[Callable[[], object], float | None]] = {
            "NavigateToPose feedback: encode": (partial(type_.encode, message), _LIMIT),
            "NavigateToPose feedback: decode": (partial(type_.decode, payload), _LIMIT),
            "feedback that is sent, without a subscriber in ROS": (partial(publications.emit, feedback), None),
            "status of one goal, which is latched: two changes": (change, None),
        }
        took = interleaved([Variant(name, partial(_repeat, call)) for name, (call, _) in calls.items()], rounds // 10)
    return [
        Row(name, took.spread(name, lambda seconds: microseconds(seconds / _AT_ONCE)), "µs", at_most=at_most)
        for name, (_, at_most) in calls.items()
    ]


def _repeat(call: Callable[[], object]) -> None:
    for _ in range(_AT_ONCE):
        call()


def _feedback(robot: str) -> FeedbackSent:
    """Return feedback of a robot that drives, as the simulator gives it."""
    pose = {"position": {"x": 12.5, "y": 7.25, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}}
    header = {"stamp": {"sec": 12, "nanosec": 345_000_000}, "frame_id": "map"}
    values = {
        "current_pose": {"header": header, "pose": pose},
        "navigation_time": {"sec": 3, "nanosec": 200_000_000},
        "estimated_time_remaining": {"sec": 17, "nanosec": 5},
        "number_of_recoveries": 0,
        "distance_remaining": 17.25,
    }
    return FeedbackSent(robot, "navigate_to_pose", _GOAL_ID, values)


def _status(status: GoalStatus) -> StatusChanged:
    return StatusChanged("robot_0", "navigate_to_pose", (GoalEntry(_GOAL_ID, 1_000_000_000, status),))


@contextmanager
def _published(world: World, *sinks: Sink) -> Iterator[tuple[Simulator, Publications]]:
    """Publish of a simulation without subscribers."""
    made: list[Publications] = []
    session, (endpoint,) = open_server(SessionOptions(listen=("tcp/127.0.0.1:0",)))

    def publishing(simulator: Simulator) -> list[Publications]:
        made.append(
            Publications(
                session,
                RmwZenoh(),
                names_of(simulator),
                actions=registry(),
                services=all_services(),
                simulator=simulator,
                changed=lambda: None,
            )
        )
        return made

    with session:
        simulator = Simulator(world, RunSettings(keep_results=10), sinks, watchers=publishing)
        (publications,) = made
        publications.start()
        with open_session(endpoint) as other:
            Graph(other).when([name for name in names_of(simulator).actions if name.count("/") > 1])
        yield simulator, publications


def _unheard(world: World, rounds: int) -> Row:
    """Return the cost of feedback without a subscriber, against a simulator that is on the wire and gives none."""
    crowds = Wanderers(world), Wanderers(world)
    with _published(world, crowds[0]) as (giving, _), _published(world, crowds[1]) as (silent, _):
        silent.dispatcher.feedback.sample = lambda *_: None  # type: ignore[method-assign]
        for simulator, crowd in zip((giving, silent), crowds, strict=True):
            plan_everything(simulator)
            crowd.start(simulator, simulator.robots)
        collect_rarely()
        variants = [Variant("silent", partial(_go_on, silent)), Variant("giving", partial(_go_on, giving))]
        took = interleaved(variants, rounds)
    return Row(
        f"{len(world.robots)} robots, feedback without a subscriber, against none",
        took.spread("giving", lambda seconds: _SPAN / seconds),
        "simulated s/s",
        took.ratio("giving", to="silent"),
        ratio_at_most=_NEAR_NOTHING,
    )


def _go_on(simulator: Simulator) -> None:
    simulator.run(until=simulator.now + _SPAN)


# --- goals -------------------------------------------------------------------------------------------------------


def _goals(rounds: int) -> list[Row]:
    """Return what goals cost by ROS's wire, and by JSON's of the same simulator: paced, and while its time stands."""
    paced, standing = (RunSettings(clock=clock, keep_results=10) for clock in ("realtime", "lockstep"))
    with ExitStack() as stack:
        json_, ros = _senders(stack, paced)
        still_json, still_ros = _senders(stack, standing)
        took = interleaved(
            [
                Variant("goal to result, paced, JSON", json_.one_by_one),
                Variant("goal to result, paced, ROS 2", ros.one_by_one),
                Variant("goal, cancel, result, while time stands, JSON", still_json.canceled),
                Variant("goal, cancel, result, while time stands, ROS 2", still_ros.canceled),
            ],
            rounds,
        )
    return [_against_json(name, took) for name in took.taken]


def _against_json(name: str, took: Rounds) -> Row:
    limit = None if name.endswith("JSON") else _NEAR_JSON
    by_json = name.replace("ROS 2", "JSON")
    return Row(name, took.spread(name, microseconds), "µs", took.ratio(name, to=by_json), ratio_at_most=limit)


def _senders(stack: ExitStack, settings: RunSettings) -> tuple[GoalSender, RosGoalSender]:
    """Return who sends goals by either wire, to a robot each of one simulator."""
    world = stack.enter_context(served(grid_world(2, side=2), settings, wires=_WIRES))
    plain = stack.enter_context(world.session())
    ros = stack.enter_context(open_session(world.endpoint))
    Graph(ros).when(["/robot_0/wait", "/robot_1/wait"])
    # Where time stands, goals have to last until they are canceled.
    seconds = 1 if settings.clock == "lockstep" else 0
    goal = Wait.Goal(time=Duration(sec=seconds))
    json_ = GoalSender(plain, "robot_0/wait", {"time": {"sec": seconds}})
    return json_, RosGoalSender(ros, "robot_1", "wait", goal=goal)

"""In lockstep, world, seed and controllers determine a run, and neither network nor subscribers change it."""

from __future__ import annotations

import math
import random
from typing import NamedTuple

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup, Place
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.protocol.commands import Advance, CancelGoal, Inbox, InterestChanged, SendGoal
from hmrsim.protocol.goal import ZERO_ID, made_goal_id
from hmrsim.protocol.outputs import Answered, Granted
from hmrsim.protocol.time import KINDS, Join, Leave
from hmrsim.protocol.topics import Topic
from hmrsim.settings.run import RunSettings
from hmrsim.simulation import simulator
from hmrsim.timing import pacing
from hmrsim.timing.result_retention import Retention
from hmrsim.trace.replay import replay
from tests.simulation import simulate

pytestmark = pytest.mark.uncovered  # whole runs, of lines that other tests cover

NAMES = ("ann", "bob", "cyd")


PLACES = {
    "home": (1, 2),
    "door": (5, 2),
    "shelf": (9, 2),
    "parcel": (9, 2.3),
    "one way off": (15, 8),
    "unreachable": (15, 2),
    "in a wall": (7, 5),
    "outside": (-5, -5),
}
GOALS = {
    **{
        place: ("navigate_to_pose", NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=x, y=y)))))
        for place, (x, y) in PLACES.items()
    },
    **{time: ("wait", Wait.Goal(time=Duration.from_seconds(time))) for time in (0.0, 0.1, 1.0, 2.000000001, 4.0)},
    **{f"pick {item}": ("pickup", Pickup.Goal(target_name=item)) for item in ("parcel", "anvil", "letter")},
    "put parcel": ("place", Place.Goal(attached_object_name="parcel")),
}


class Turn(NamedTuple):
    """The next requests of a controller, independent of its answers.

    Attributes:
        commands: Each a robot, and a goal's name with the goal's id, or an action and the id to be canceled.
        ahead: How far time may move.
        wake: What to be granted at once for.
        report: The events to be reported besides.
    """

    commands: list
    ahead: float
    wake: tuple[str, ...]
    report: tuple[str, ...]

    def asked(self, name, granted, reply_to):
        until = granted.now + self.ahead
        commands = tuple(_command(*each) for each in self.commands)
        return Advance(name, granted.epoch, until, frozenset(self.wake), frozenset(self.report), commands, reply_to)


class Conditions(NamedTuple):
    """Conditions that must not matter: the network's delays, by their seed, batches of events, and subscribers."""

    network: int
    between_polls: int
    topics: tuple[Topic, ...]
    batch: int = 1_000


def _command(robot, goal, action, goal_id):
    if goal is None:
        return CancelGoal(robot, action, goal_id or ZERO_ID)
    return SendGoal(robot, *GOALS[goal], goal_id)


ROBOTS = st.sampled_from(["wall_e", "eve", "cart", "nobody"])
SENT = st.tuples(ROBOTS, st.sampled_from([*GOALS]), st.none(), st.sampled_from([None, None, None, "a" * 32, "no id"]))
CANCELED = st.tuples(
    ROBOTS,
    st.none(),
    st.sampled_from(["navigate_to_pose", "wait"]),
    st.sampled_from([None, "a" * 32, *(made_goal_id(name, number) for name in NAMES for number in (1, 2, 3))]),
)
KINDS_ASKED = st.sampled_from([(), ("result",), ("status",), ("feedback",), ("result", "feedback"), KINDS])
TURNS = st.lists(
    st.builds(
        Turn,
        st.lists(SENT | CANCELED, max_size=3),
        st.sampled_from([math.inf, math.inf, 0.0, 1.0, 4.0]) | st.floats(0.0, 5.0),
        KINDS_ASKED,
        KINDS_ASKED,
    ),
    max_size=6,
)
MISSIONS = st.lists(TURNS, min_size=1, max_size=3)
DURATIONS = st.sampled_from([math.inf, math.inf, 4.0, 8.25])
CONDITIONS = st.builds(
    Conditions,
    st.integers(0, 1000),
    st.sampled_from([1, 2, 3, 16, 1000]),
    st.sampled_from([(), *((topic,) for topic in Topic), tuple(Topic)]),
    st.sampled_from([1, 2, 7, 1000]),
)


class Controller:
    """A participant that joins, takes its turns and leaves, and receives its answers."""

    def __init__(self, name, turns, send):
        self.name = name
        self.told = []
        self.contradicted = []
        self._turns = iter(turns)
        self._send = send
        self._over = False
        send(Join(name, self))

    def take(self, answer):
        """Continue with the next turn; a repeated request must have an equal answer."""
        if self._over:
            return
        if isinstance(answer, Granted):
            if self.told[-1].epoch >= answer.epoch:
                self.contradicted += [answer] if answer not in self.told else []
                return
            self._over = answer.reason == "end"
        self.told.append(answer)
        turn = None if self._over else next(self._turns, None)
        if not self._over:
            self._send(turn.asked(self.name, answer, self) if turn else Leave(self.name))


class Network(Inbox):
    """Delivers requests in any order, late, and some of them twice, while a subscriber comes and goes."""

    def __init__(self, conditions):
        super().__init__()
        self._chance = random.Random(conditions.network)
        self._topics = self._heard = frozenset(conditions.topics)
        self._late = []
        self._arrived = {}

    def send(self, command):
        self._late.append(command)

    def poll(self):
        """Return a request, or None."""
        what = self._chance.random()
        if what < 0.1:
            self._heard = frozenset() if self._heard else self._topics
            return InterestChanged()
        if what < 0.2 and self._arrived:
            return self._chance.choice([*self._arrived.values()])
        if what < 0.6 and self._late:
            return self._arriving(self._late.pop(self._chance.randrange(len(self._late))))
        return None

    def _arriving(self, command):
        if isinstance(command, Advance):
            self._arrived[command.participant] = command
        elif isinstance(command, Leave):
            self._arrived.pop(command.participant, None)
        return command

    def wait(self, _timeout):
        """End the run if no request is left."""
        if not self._late:
            self.close()

    def emit(self, event):
        """Deliver an answer to its controller."""
        if isinstance(event, Answered) and isinstance(event.reply_to, Controller):
            event.reply_to.take(event.answer)

    def wants(self, topic):
        """Return whether the subscriber is connected."""
        return topic in self._heard


def play(mission, duration, conditions):
    """Return the trace of a mission, and its controllers."""
    network, paces = Network(conditions), []
    controllers = [Controller(name, turns, network.send) for name, turns in zip(NAMES, mission, strict=False)]
    names = [controller.name for controller in controllers]
    settings = RunSettings(clock="lockstep", duration=duration, participants=names or 1)

    def pace(simulator):
        paces.append(pacing.Pacing(simulator, network, Retention(-1), settings))
        return [paces[0].lockstep]

    run = simulate(topics=frozenset(), sinks=[network], watchers=pace, traced=True, seed=7)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pacing, "_EVENTS_BETWEEN_POLLS", conditions.between_polls)
        patch.setattr(pacing, "_EVENTS_OF_A_GRANT", conditions.batch)
        patch.setattr(simulator, "_BATCH", conditions.batch)
        paces[0].run()
    run.simulator.stop()
    return "".join(run.lines()), controllers


DRIVE = [("wall_e", "door", None, None)]
FEEDBACK = Turn([], math.inf, ("feedback",), ())
QUIET, LOUD = Conditions(0, 1, ()), Conditions(12, 1, tuple(Topic))


@given(MISSIONS, DURATIONS, CONDITIONS, CONDITIONS)
@example([[], []], math.inf, QUIET, Conditions(2, 1, ())).via("they leave before all have joined")
@example([[Turn([], 4.0, (), ())] * 4, []], 4.0, QUIET, Conditions(3, 1, ())).via("somebody asks at the very end")
@example([[FEEDBACK] * 3, [Turn(DRIVE, math.inf, (), ())]], math.inf, QUIET, Conditions(0, 2, ())).via("sampled twice")
@example([[Turn(DRIVE, 1.0, (), ()), FEEDBACK]], math.inf, QUIET, LOUD).via("sampled at the instant of listening")
def test_neither_trace_nor_answers_depend_on_the_network(mission, duration, some, others):
    trace, controllers = play(mission, duration, some)
    again, told_again = play(mission, duration, others)

    assert trace == again
    assert [each.told for each in controllers] == [each.told for each in told_again]
    assert [] == [each.contradicted for each in (*controllers, *told_again) if each.contradicted]


@given(MISSIONS, CONDITIONS)
def test_each_turn_of_each_controller_is_answered(mission, conditions):
    _, controllers = play(mission, math.inf, conditions)

    assert [1 + len(turns) for turns in mission] == [len(each.told) for each in controllers]


@given(MISSIONS, DURATIONS, CONDITIONS)
@example([[Turn(DRIVE, 1e-9, (), ())]], math.inf, QUIET).via("the first nanosecond")
def test_a_replay_is_identical(mission, duration, conditions):
    """It has no controllers, and its robots are in the order of names."""
    trace, _ = play(mission, duration, conditions)
    lines = trace.splitlines(keepends=True)
    outcome = replay(lines)

    assert None is outcome.difference
    assert (len(lines), True) == (outcome.lines, outcome.complete)

"""The work of a goal as counts: Python calls, modules, and passes from or to JSON; in one process they are exact."""

from __future__ import annotations

import sys
import tempfile
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import gymnasium

import hmrsim_gym  # noqa: F401 - registers the environments
from benchmarks._report import Row
from benchmarks.experiments import STUDY
from hmrsim.actions import registry
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.replications import execute_run
from hmrsim.fault_search.check import CheckFile
from hmrsim.fault_search.reading import check_at
from hmrsim.fault_search.run import run_case
from hmrsim.fault_search.schedule import Case, Injection
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.settings.run import RunSettings
from hmrsim.testing import simulation
from hmrsim.world.model import World
from hmrsim.world_checks import LoadedWorld
from hmrsim_gym import nearest
from hmrsim_zenoh import Client
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.hosting.loopback_host import LoopbackHost
from hmrsim_zenoh.wire.options import SessionOptions

if TYPE_CHECKING:
    from types import FrameType

QUICK: dict[str, Any] = {}

_WORLD: Final = {
    "waypoints": {"a": [0, 0], "b": [4, 0]},
    "lanes": [["a", "b"]],
    "robots": {"eve": {"at": "a"}},
}
_TREE: Final = """
<root BTCPP_format="4"><BehaviorTree ID="Rounds"><Sequence>
  <NavigateToPose goal="b"/><NavigateToPose goal="a"/><NavigateToPose goal="b"/><NavigateToPose goal="a"/>
</Sequence></BehaviorTree></root>
"""
_MISSION: Final = """
from hmrsim_zenoh import Commander

def drive(client):
    Commander(client, "eve").navigate_to("b")
"""
_WARM: Final = 5
"""Runs before the one that is counted: the first ones fill caches."""
_EPISODE: Final = 1_800.0
"""Simulated seconds of an episode."""
_MANY: Final = 50
"""Goals over Zenoh of which the mean is taken: how many queries are served together is a matter of chance."""

_PASSES: Final = frozenset({"validate_json", "validate_python", "to_json", "to_python", "from_json"})
"""The functions of pydantic's core that make models of data, and data of models."""
_JSON: Final = frozenset({("json.encoder", "encode"), ("json.decoder", "decode")})


@dataclass
class Counts:
    """The counts of calls and of conversions.

    Attributes:
        calls: The calls of each module's Python functions.
        passes: How often a model was made from data, or data from a model or from plain values.
    """

    calls: Counter[str] = field(default_factory=Counter)
    passes: int = 0

    @property
    def total(self) -> int:
        """The number of all calls."""
        return sum(self.calls.values())

    @property
    def modules(self) -> int:
        """The number of modules; the classes that `namedtuple` makes have none."""
        return sum(not module.startswith("namedtuple_") for module in self.calls)

    def note(self, frame: FrameType, event: str, function: Any) -> None:
        """Count what a thread does, as `sys.setprofile` tells it."""
        if event == "call":
            module = frame.f_globals.get("__name__", "?")
            self.calls[module] += 1
            self.passes += (module, frame.f_code.co_name) in _JSON
        elif event == "c_call":
            self.passes += getattr(function, "__name__", "") in _PASSES


@contextmanager
def counted() -> Iterator[Counts]:
    """Count what the calling thread does; exact, and the same each time on one version of Python."""
    counts = Counts()
    sys.setprofile(counts.note)
    try:
        yield counts
    finally:
        sys.setprofile(None)
        # The end of this very context.
        counts.calls["contextlib"] -= 1


def goal() -> Counts:
    """Return what one warm goal takes over one lane, from `send_goal` to its result."""
    navigate = registry()["navigate_to_pose"]
    goals = [_to(x) for x in (4.0, 0.0)]
    with LoopbackHost(World.model_validate(_WORLD)) as host, Client(session=host.open_session()) as client:
        eve = client.action_client("eve", navigate)
        for number in range(2 * _WARM):
            eve.send_goal(goals[number % 2]).result()
        with counted() as counts:
            eve.send_goal(goals[0]).result()
    return counts


def served_goal() -> Counts:
    """Return what the simulator does for one warm goal in lockstep over Zenoh: the mean of some, in all its threads.

    What Zenoh does, and how its threads hand queries over, is not counted.
    """
    navigate = registry()["navigate_to_pose"]
    goals = [_to(x) for x in (4.0, 0.0)]
    world = World.model_validate(_WORLD)
    loaded = LoadedWorld(world, Path("world"), ())
    noted = [Counts()]

    def note(frame: FrameType, event: str, function: Any) -> None:
        noted[-1].note(frame, event, function)

    # Of all threads that are started until it is set anew.
    threading.setprofile(note)
    with Host(loaded, SessionOptions(listen=("tcp/127.0.0.1:0",)), RunSettings(clock="lockstep")) as host:
        host.start()
        threading.setprofile(None)
        with Client(SessionOptions(connect=host.endpoints), clock="lockstep") as client:
            eve = client.action_client("eve", navigate)
            for number in range(2 * _WARM):
                eve.send_goal(goals[number % 2]).result()
            noted.append(Counts())
            for number in range(_MANY):
                eve.send_goal(goals[number % 2]).result()
            counts = noted[-1]
            noted.append(Counts())
    calls = Counter({module: round(number / _MANY) for module, number in counts.calls.items()})
    return Counts(+calls, round(counts.passes / _MANY))


def tree() -> Counts:
    """Return what a test takes that runs a tree of four goals, with its set-up and its end."""
    world = World.model_validate(_WORLD)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rounds.xml")
        path.write_text(_TREE)

        def run() -> None:
            with simulation(world, tree=path) as whole:
                whole.to_the_end()

        return _warm(run)


def schedule() -> Counts:
    """Return what a search takes for one schedule, a fault from the start of a mission of one goal."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "mission.py").write_text(_MISSION)
        file = CheckFile.model_validate({"world": _WORLD, "controller": {"python": "mission.py:drive"}})
        check = check_at(file, Path(folder))
        case = Case((Injection({"type": "slip", "robot": "eve", "factor": 0.5, "at": 0.0}),))

        def run() -> None:
            outcome = run_case(check, case)
            if outcome.ending != "succeeded":
                raise AssertionError(outcome.cause)

        return _warm(run)


def experiment() -> Counts:
    """Return what an experiment takes for one run of the hospital's mission, of which one of six robots drives."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "study.yaml")
        path.write_text(STUDY.format(replications=1), encoding="utf-8")
        plan = read_plan(path)
        one = plan.run(0, "one", 0)

        def run() -> None:
            row = execute_run(plan, one)
            if row.ending != "succeeded":
                raise AssertionError(row.cause)

        return _warm(run)


def decision() -> Counts:
    """Return what the mean decision of an episode in the shipped world with orders takes."""
    env: Any = gymnasium.make("hmrsim/Dispatch-v0", world="warehouse_orders", horizon=_EPISODE).unwrapped
    for seed in range(2):
        _episode(env, seed, Counts())
    counts = Counts()
    decisions = _episode(env, 1, counts)
    calls = Counter({module: round(number / decisions) for module, number in counts.calls.items()})
    return Counts(+calls, round(counts.passes / decisions))


def _episode(env: Any, seed: int, counts: Counts) -> int:
    """Count what the decisions of an episode take, each for the nearest order; return how many there are."""
    observation, _ = env.reset(seed=seed)
    decisions, over = 0, False
    while not over:
        action = nearest(observation)
        with counted() as once:
            observation, _, ended, truncated, _ = env.step(action)
        counts.calls += once.calls
        counts.passes += once.passes
        decisions, over = decisions + 1, ended or truncated
    return decisions


def _warm(run: Callable[[], None]) -> Counts:
    for _ in range(_WARM):
        run()
    with counted() as counts:
        run()
    return counts


def _to(x: float) -> NavigateToPose.Goal:
    return NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": x, "y": 0.0}}}})


def run() -> list[Row]:
    """Return the counts of each case."""
    cases = {
        "a goal, from `send_goal` to its result": (goal(), 260, 45, 0),
        "a goal in lockstep over Zenoh, the simulator's side": (served_goal(), 260, None, 3),
        "a test of a tree of four goals, with set-up and end": (tree(), 1_900, None, 6),
        "a schedule of a search, with one goal": (schedule(), 1_300, None, 4),
        "a run of an experiment, of which one robot drives": (experiment(), 4_500, None, None),
        "a decision of the Gymnasium environment": (decision(), 1_160, None, 1),
    }
    rows = []
    for name, (counts, calls, modules, passes) in cases.items():
        rows += [
            Row(f"{name}: calls", counts.total, "calls", at_most=calls),
            Row(f"{name}: modules", counts.modules, "modules", at_most=modules),
            Row(f"{name}: passes", counts.passes, "passes", at_most=passes),
        ]
    return rows

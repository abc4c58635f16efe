"""Damaged traces: a replay or a report shows the difference or the error."""

from __future__ import annotations

import json
import random
from contextlib import suppress
from functools import cache
from typing import TYPE_CHECKING, Any

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.actions import registry as actions
from hmrsim.errors import TraceError
from hmrsim.protocol.commands import SendGoal
from hmrsim.report import of_trace, section_of
from hmrsim.trace.replay import replay
from tests.profiles import examples
from tests.simulation import simulate

if TYPE_CHECKING:
    from collections.abc import Iterator

VALUES = [None, True, 0, -1, 1e308, 5e-324, 2**64, "x", "", [], {}, [1], {"a": 1}, "\x00"]


@cache
def lines() -> tuple[str, ...]:
    run = simulate(traced=True)
    run.ask("inject_fault", {"type": "breakdown", "robot": "cart", "at": 1.0, "duration": 2.0})
    drive = actions()["navigate_to_pose"].goal.model_validate({"pose": {"pose": {"position": {"x": 9.0, "y": 2.0}}}})
    wait = actions()["wait"].goal.model_validate({"time": {"sec": 1}})
    run((0.0, SendGoal("wall_e", "navigate_to_pose", drive, "1" * 32)), (0.5, SendGoal("eve", "wait", wait, None, "r")))
    position = {"pose": {"position": {"x": 5.0, "y": 2.0}}}
    run.ask("spawn_entity", {"name": "new", "uri": "robot_type:nurse", "initial_pose": position})
    run.ask("reset_simulation")
    run((0.5, SendGoal("eve", "wait", wait, None, "r")))
    run.ask("set_simulation_state", {"state": {"state": 2}})
    return tuple(run.lines())


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths of all JSON values in a value."""
    if path:
        yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for step, each in inner:
        yield from paths(each, (*path, step))


def change_value(line: str, chance: random.Random) -> str:
    body = json.loads(line)
    *way, last = chance.choice(list(paths(body)))
    inner = body
    for step in way:
        inner = inner[step]
    if isinstance(inner, dict) and chance.random() < 0.25:
        del inner[last]
    else:
        inner[last] = chance.choice(VALUES)
    return json.dumps(body) + "\n"


def damaged(chance: random.Random) -> list[str]:
    made = list(lines())
    number = chance.randrange(len(made))
    match chance.choice(["value", "value", "value", "cut", "gone", "twice", "byte"]):
        case "value":
            made[number] = change_value(made[number], chance)
        case "cut":
            made[number] = made[number][: chance.randrange(len(made[number]))] + "\n"
        case "gone":
            del made[number]
        case "twice":
            made.insert(chance.randrange(len(made)), made[number])
        case "byte":
            at = chance.randrange(len(made[number]) - 1)
            made[number] = made[number][:at] + chr(chance.randrange(256)) + made[number][at + 1 :]
    return made


@examples(300)
@given(seed=st.integers(0, 2**32))
def test_a_replay_survives_any_damage(seed):
    with suppress(TraceError):
        outcome = replay(damaged(random.Random(seed)))

        assert outcome.lines <= len(lines()) + 1


@examples(100)
@given(seed=st.integers(0, 2**32), section=st.sampled_from([None, 1, 2, 3]))
def test_a_report_survives_any_damage(seed, section):
    made = damaged(random.Random(seed))
    with suppress(TraceError):
        found = of_trace(lambda: made, section=section)

        assert len(found) == len([section_of(each) for each in found])

"""The guarantees of every kind of fault in the registry."""

from __future__ import annotations

import json

import pytest
from pydantic import ValidationError

from hmrsim.faults import registry
from hmrsim.trace.replay import replay
from tests.simulation import SMALL_WORLD, simulate

WORLD = {
    **SMALL_WORLD,
    "doors": {"gate": {"at": [[3, 1], [3, 3]]}},
    "docks": {"charger": {"at": [9, 5], "type": "charger"}},
    "lifts": {"lift": {"stops": ["island", "home"]}},
    "robot_types": {"nurse": {"components": {"claw": {}, "camera": {}, "battery": {"cells": 4}}}},
}


@pytest.fixture(params=registry().values(), ids=registry())
def fault(request):
    return request.param


def kinds(log):
    return [(time, kind) for kind in ("fault_began", "fault_missed", "fault_ended") for time, _ in log.happened(kind)]


def test_its_example_begins_and_ends(fault):
    until = {"until": 3.0} if fault.lasts else {}
    run = simulate({**WORLD, "faults": [{"type": fault.name, "at": 2.0, **fault.example, **until}]})
    log = run(until=5.0)

    assert [(2.0, "fault_began"), (3.0 if fault.lasts else 2.0, "fault_ended")] == kinds(log)


def test_its_example_begins_after_an_event(fault):
    until = {"duration": 1.0} if fault.lasts else {}
    when = {"event": "simulation_state", "nth": 2, "after": 0.5}
    run = simulate({**WORLD, "faults": [{"type": fault.name, **fault.example, **until, "when": when}]})
    run.simulator.advance(1.0)
    for state in (2, 1):
        run.ask("set_simulation_state", {"state": {"state": state}})
    log = run(until=5.0)

    assert [(1.5, "fault_began"), (2.5 if fault.lasts else 1.5, "fault_ended")] == kinds(log)


def test_its_form_asks_for_no_event(fault):
    """Users of a page see events themselves."""
    assert "when" not in fault.form()["properties"]


def test_it_can_be_injected_and_cleared(fault):
    run = simulate(WORLD)
    injected = run.ask("inject_fault", {"type": fault.name, "settings": json.dumps(fault.example)})
    active = [one.name for one in run.ask("get_faults").faults]
    cleared = run.ask("clear_fault", {"type": fault.name})

    names = [f"{fault.name}_1"] if fault.lasts else []
    assert ("", f"{fault.name}_1") == (injected.result.error_message, injected.name)
    assert (names, names) == (active, cleared.names)
    assert [] == run.ask("get_faults").faults


def test_it_leaves_the_world_as_it_was(fault):
    """After the fault, robots, items and lanes are as in a world without it, except for dead cells."""

    def state(run):
        robot = run.simulator.robots["wall_e"]
        return (
            {
                name: run.ask("get_entity_info", {"entity": name})
                for name in (*run.simulator.robots, "gate", "charger", "lift")
            },
            robot.speed,
            robot.disabled,
            robot.pose_stamped(),
            run.simulator.graph.closed,
            run.simulator.dispatcher.cut_off,
        )

    run, calm = simulate(WORLD), simulate(WORLD)
    run.ask("inject_fault", {"type": fault.name, "settings": json.dumps(fault.example)})
    run.ask("clear_fault", {})

    assert state(calm) == state(run)


def test_its_subject_has_a_tag(fault):
    run = simulate(WORLD)
    run.ask("inject_fault", {"type": fault.name, "settings": json.dumps(fault.example)})
    subject = next((fault.example[name] for name in ("robot", "door", "dock", "lift") if name in fault.example), None)
    seen = subject and run.ask("get_entity_info", {"entity": subject}).info.tags

    assert not fault.lasts or subject is None or {fault.name, fault.name.partition("_")[2]} & {*seen}


def test_two_at_once_end_one_by_one(fault):
    if not fault.lasts:
        return
    run = simulate({**WORLD, "faults": [{"type": fault.name, **fault.example, "until": until} for until in (2, 4)]})
    log = run(until=5.0)

    assert [0.0, 0.0] == [time for time, _ in log.happened("fault_began")]
    assert [2.0, 4.0] == [time for time, _ in log.happened("fault_ended")]


def test_it_rejects_unknown_settings(fault):
    with pytest.raises(ValidationError, match="colour"):
        fault.settings.model_validate({**fault.example, "colour": "red"})


def test_a_reset_ends_it(fault):
    """The world's own faults begin again."""
    run = simulate({**WORLD, "faults": [{"type": fault.name, "at": 1.0, **fault.example}]})
    run.simulator.advance(2.0)
    run.ask("reset_simulation")
    again = run(until=1.5)

    assert 2 == len(again.happened("fault_began"))


def test_a_run_with_it_replays(fault):
    robots = {name: {**robot, "script": ["Wait 3", "Go home"]} for name, robot in WORLD["robots"].items()}
    one = {"type": fault.name, **fault.example}
    run = simulate({**WORLD, "robots": robots, "faults": [{**one, "at": 1.0}]}, traced=True)
    run(until=4.0)
    run.ask("inject_fault", {"type": fault.name, "settings": json.dumps(fault.example)})
    run(until=9.0)
    outcome = replay(run.lines())

    assert run.log.happened("fault_began")
    assert (True, None) == (outcome.complete, outcome.difference)

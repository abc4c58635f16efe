"""A bug in a plugin fails its goal, its fault or its answer, and nothing else."""

from __future__ import annotations

import json
import logging
import math
import sys
from contextlib import suppress
from dataclasses import replace

import pytest
from simpy import Event, Interrupt

from hmrsim.actions import registry as actions
from hmrsim.components import registry as components
from hmrsim.errors import GoalAborted, HmrsimError, WriteError
from hmrsim.faults import registry as faults
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.commands import CallService, CancelGoal, InterestChanged, SendGoal
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.services import registry as services
from hmrsim.trace.replay import replay
from hmrsim.traffic.policies import registry as policies
from tests.simulation import SMALL_WORLD, simulate

BROKEN, OTHER, NEXT = (f"{number:032x}" for number in (1, 2, 3))


def oops(*_arguments):
    raise ZeroDivisionError("oops")


def waits(robot, seconds):
    """Wait, like a goal that holds the base."""
    yield from robot.hold(seconds)


def at_once(_robot, _goal, _report):
    yield from ()
    oops()


def later(robot, _goal, _report):
    yield from waits(robot, 1.0)
    oops()


def no_generator(_robot, _goal, _report):
    """Raise when called."""
    oops()


def returns(_robot, _goal, _report):
    return Wait.Result()


def no_event(robot, _goal, _report):
    """Yield a value that is no event."""
    yield from waits(robot, 1.0)
    yield 5


def no_result(robot, _goal, _report):
    """Return a value that is no result."""
    yield from waits(robot, 1.0)
    return "done"


def exits(robot, _goal, _report):
    yield from waits(robot, 1.0)
    sys.exit(3)


def closes(robot, _goal, _report):
    """Raise GeneratorExit."""
    yield from waits(robot, 1.0)
    raise GeneratorExit


def of_ours(robot, _goal, _report):
    """Raise an error that is meant for users of a command."""
    yield from waits(robot, 1.0)
    raise HmrsimError("no")


class SilentError(Exception):
    """An exception whose text can't be computed."""

    def __str__(self):
        raise TypeError


def silent(robot, _goal, _report):
    """Raise an exception that has a bug."""
    yield from waits(robot, 1.0)
    raise SilentError


class OddError(Exception):
    """An exception that simpy can't copy for the process that waits."""

    def __init__(self, first, second):
        super().__init__(f"{first} {second}")


def of_a_child(robot, _goal, _report):

    def child():
        yield robot._env.timeout(1.0)
        raise OddError(1, 2)

    yield robot._env.process(child())


def at_no_time(robot, _goal, _report):
    yield from waits(robot, math.nan)


def of_feedback(robot, _goal, report):
    """Have feedback that can't be computed."""
    report.sample(oops)
    yield from waits(robot, 3.0)
    return Wait.Result()


def of_a_lost_event(robot, _goal, _report):
    """Wait for an event that fails, and so raises in the process."""
    failing = Event(robot._env)
    failing.fail(ZeroDivisionError("oops"))
    yield failing


def send(robot, goal_id, seconds=2, action="wait"):
    """Return the command that sends a goal to wait."""
    return SendGoal(robot, action, Wait.Goal(time=Duration(sec=seconds)), goal_id, ("reply", goal_id))


def broken_run(process=at_once, *, strict=False, **changes):
    """Return a simulation in which `wait` of a package has a bug, and `wait` of eve has none."""
    mine = replace(actions()["wait"], name="dance", process=process, outlives_breakdown=False, **changes)
    return simulate(actions={**actions(), "dance": mine}, strict=strict)


BUGS = [at_once, later, no_generator, returns, no_event, no_result, of_a_lost_event]
BUGS += [exits, closes, of_ours, silent, of_a_child, at_no_time]


@pytest.mark.parametrize("process", BUGS)
def test_a_bug_in_an_action_aborts_only_its_goal(process):
    run = broken_run(process)
    log = run((0.0, send("wall_e", BROKEN, action="dance")), (0.0, send("eve", OTHER)), (5.0, send("wall_e", NEXT)))

    broken = [status for _, status in log.changes(BROKEN)]
    assert ["ACCEPTED", "EXECUTING", "ABORTED"] == broken
    assert (Wait.Result.UNKNOWN, "bug in dance: ") == (log.result(BROKEN).error_code, log.result(BROKEN).error_msg[:14])
    assert [(2.0, "SUCCEEDED"), (7.0, "SUCCEEDED")] == [log.changes(OTHER)[-1], log.changes(NEXT)[-1]]
    assert ["action dance"] == [fields["part"] for _, fields in log.happened("internal_error")]


def test_a_process_without_yield_gets_a_hint():
    """Authors of a first action often forget it."""
    log = broken_run(returns)((0.0, send("wall_e", BROKEN, action="dance")))

    error = "bug in dance: TypeError: its process has no `yield`: write `yield from robot.hold(…)`, not `robot.hold(…)`"
    assert error in log.result(BROKEN).error_msg


def test_a_bug_in_feedback_loses_only_the_feedback():

    def traced(*topics):
        mine = replace(actions()["wait"], name="dance", process=of_feedback)
        run = simulate(actions={**actions(), "dance": mine}, strict=False, traced=True)
        run.log.topics = frozenset(topics)
        run.simulator.submit(InterestChanged())
        return run((0.0, send("wall_e", BROKEN, action="dance"))), run.lines()

    seen, trace = traced(Topic.FEEDBACK, Topic.EVENTS)

    assert (3.0, "SUCCEEDED") == seen.changes(BROKEN)[-1]
    assert ["action dance"] == [fields["part"] for _, fields in seen.happened("internal_error")]
    assert trace == traced()[1]


def stays(robot, _goal, _report):
    while True:
        with suppress(Interrupt):
            yield from waits(robot, 1.0)


def raises_at_its_end(robot, _goal, _report):
    """Raise when canceled."""
    try:
        yield from waits(robot, 9.0)
    finally:
        oops()


@pytest.mark.parametrize("process", [stays, raises_at_its_end])
def test_a_bug_while_canceling_still_cancels_the_goal(process):
    cancel = CancelGoal("wall_e", "dance", BROKEN)
    run = broken_run(process)
    log = run((0.0, send("wall_e", BROKEN, action="dance")), (1.5, cancel), (1.5, send("wall_e", NEXT)), until=9.0)

    assert [(1.5, "CANCELED"), (3.5, "SUCCEEDED")] == [log.changes(BROKEN)[-1], log.changes(NEXT)[-1]]
    assert run.simulator.env.idle
    assert 1 == len(log.happened("internal_error"))


def test_an_action_can_disable_its_robot():
    """Its process is interrupted when it waits next."""

    def breaks(robot, _goal, _report):
        robot.disable("mine", "broken")
        yield from waits(robot, 5.0)

    run = broken_run(breaks)
    log = run((0.0, send("wall_e", BROKEN, action="dance")), until=1.0)

    assert ((0.0, "ABORTED"), "broken") == (log.changes(BROKEN)[-1], log.result(BROKEN).error_msg)
    assert (True, []) == (run.simulator.env.idle, log.happened("internal_error"))


@pytest.mark.parametrize("process", [at_once, no_event, exits])
def test_a_strict_run_raises_the_first_bug(process):
    run = broken_run(process, strict=True)

    with pytest.raises((ZeroDivisionError, RuntimeError)):
        run((0.0, send("wall_e", BROKEN, action="dance")))
    assert "ABORTED" == run.log.changes(BROKEN)[-1][1]


def test_a_bug_is_an_event_and_a_fault_of_the_robot():
    """A repeated bug is one fault, until the fault is cleared."""
    run = broken_run()
    log = run((0.0, send("wall_e", BROKEN, action="dance")), (1.0, send("wall_e", NEXT, action="dance")))

    told = {"robot": "wall_e", "part": "action dance", "error": "ZeroDivisionError: oops"}
    assert [(0.0, told), (1.0, told)] == log.happened("internal_error")
    mark = {"fault": "internal_error", "robot": "wall_e", "error": "action dance: ZeroDivisionError: oops"}
    assert [mark | {"name": "internal_error_1"}] == [fields for _, fields in log.happened("fault_began")]
    assert ["internal_error"] == run.simulator.fault_injector.active_on("wall_e")
    assert 1 == run.ask("clear_fault", {"name": "internal_error_1"}).result.result
    assert [] == run.simulator.fault_injector.active_on("wall_e")


def test_a_traceback_is_logged_once(caplog):
    """Further errors at one place are a line each."""
    run = broken_run()
    with caplog.at_level(logging.ERROR):
        run((0.0, send("wall_e", BROKEN, action="dance")), (1.0, send("wall_e", NEXT, action="dance")))

    assert ["wall_e: bug in action dance: ZeroDivisionError: oops"] * 2 == [
        each.getMessage() for each in caplog.records
    ]
    assert [True, False] == [bool(each.exc_info) for each in caplog.records]


@pytest.mark.parametrize("part", ["flaw", "frames", "not_ready"])
def test_a_bug_in_a_check_of_goals_rejects_the_goal(part):
    log = broken_run(**{part: oops})((0.0, send("wall_e", BROKEN, action="dance")))

    answer = log.answer(("reply", BROKEN))
    assert (False, "internal_error", "bug in dance: ZeroDivisionError: oops") == (
        answer.accepted,
        answer.reason,
        answer.error_msg,
    )


def test_a_bug_in_the_failure_result_leaves_an_empty_one():

    def fails(_robot, _goal, _report):
        yield from ()
        raise GoalAborted(700, "no")

    for bug in (oops, lambda *_arguments: "no"):
        log = broken_run(fails, failure=bug)((0.0, send("wall_e", BROKEN, action="dance")))

        assert ("ABORTED", Wait.Result()) == (log.changes(BROKEN)[-1][1], log.result(BROKEN))


@pytest.mark.parametrize("ends", [False, True])
def test_a_bug_in_a_fault_ends_that_fault(ends, monkeypatch):
    """It may be at the start or at the end of the fault."""
    begin = (lambda _case: oops) if ends else oops
    monkeypatch.setitem(faults(), "breakdown", replace(faults()["breakdown"], begin=begin))
    run = simulate(strict=False)
    run.ask("inject_fault", {"type": "breakdown", "robot": "wall_e", "duration": 2.0})
    run((0.0, send("eve", OTHER)))

    assert "SUCCEEDED" == run.log.changes(OTHER)[-1][1]
    assert ([2.0 * ends], []) == (
        [at for at, fields in run.log.happened("fault_ended")],
        run.simulator.fault_injector.active_on("wall_e"),
    )
    assert "fault breakdown" == run.log.happened("internal_error")[0][1]["part"]


def test_a_bug_in_a_service_is_its_answer(monkeypatch):
    for name, part in (("get_faults", "respond"), ("clear_fault", "resolve")):
        monkeypatch.setitem(services(), name, replace(services()[name], **{part: oops}))
    run = simulate(strict=False)
    asked = [("get_faults", {}), ("clear_fault", {"name": "x"})]
    for name, request in asked:
        run.simulator.submit(CallService(name, services()[name].request.model_validate(request), name))

    assert [f"bug in service {name}: ZeroDivisionError: oops" for name, _ in asked] == [
        run.log.answer(name).message for name, _ in asked
    ]


def test_a_bug_in_a_service_is_in_the_trace_only_if_its_call_is(monkeypatch):
    for name in ("get_faults", "clear_fault"):
        monkeypatch.setitem(services(), name, replace(services()[name], respond=oops))
    run = simulate(strict=False, traced=True)
    run.ask("get_faults")
    run.ask("clear_fault", {"name": "x"})

    assert 2 == len(run.log.happened("internal_error"))
    trace = run.lines()
    assert ["service clear_fault"] == [json.loads(line)["part"] for line in trace if '"internal_error"' in line]
    assert replay(trace).difference is None


def test_a_robot_works_without_a_component_that_has_a_bug(monkeypatch):
    monkeypatch.setitem(components(), "claw", replace(components()["claw"], create=oops))
    run = simulate(strict=False)
    assert [] == [*run.simulator.robots["wall_e"].components]
    monkeypatch.undo()
    assert 1 == run.ask("reset_simulation").result.result
    assert ["claw"] == [*run.simulator.robots["wall_e"].components]

    monkeypatch.setitem(components(), "claw", replace(components()["claw"], create=oops))
    assert 1 == run.ask("reset_simulation").result.result
    assert [("component claw", "eve"), ("component claw", "wall_e")] == [
        (fields["part"], fields["robot"]) for _, fields in run.log.happened("internal_error")
    ]
    assert "SUCCEEDED" == run((0.0, send("wall_e", NEXT))).changes(NEXT)[-1][1]


def test_a_bug_while_loading_a_world_keeps_the_current_one(monkeypatch):
    monkeypatch.setitem(policies(), "reserve", replace(policies()["reserve"], rule=oops))
    run = simulate(strict=False)
    run((0.0, send("eve", OTHER)), until=1.0)
    text = json.dumps({**SMALL_WORLD, "name": "other", "traffic": {"policy": "reserve"}})
    run.ask("load_world", {"resource_string": text})

    assert ["service load_world"] == [fields["part"] for _, fields in run.log.happened("internal_error")]
    assert ("small", 0.0) == (run.simulator.world.name, run.simulator.now)
    assert 1 == run.ask("set_simulation_state", {"state": {"state": 1}}).result.result
    assert "SUCCEEDED" == run((0.0, send("wall_e", NEXT))).changes(NEXT)[-1][1]


def test_a_bug_in_a_process_or_a_callback_leaves_all_others():
    run, rung = simulate(strict=False), []
    env = run.simulator.env

    def process():
        yield env.timeout(1.0)
        oops()

    env.process(process())
    env.timeout(1.0).callbacks += [oops, lambda _event: rung.append(env.now)]
    run((0.0, send("eve", OTHER)))

    assert ([1.0], "SUCCEEDED") == (rung, run.log.changes(OTHER)[-1][1])
    assert 2 == len(run.log.happened("internal_error"))


class Sink:
    """A sink with a bug."""

    def __init__(self, error):
        self.error = error

    def emit(self, _output):
        raise self.error

    def commanded(self, *_command):
        raise self.error

    def wants(self, _topic: Topic) -> bool:
        return True


def test_other_sinks_get_everything_despite_a_bug_in_one():
    run = simulate(sinks=[Sink(ZeroDivisionError("oops"))], strict=False)
    run((0.0, send("eve", OTHER)))

    assert "SUCCEEDED" == run.log.changes(OTHER)[-1][1]
    assert ["Sink"] == [fields["part"] for _, fields in run.log.happened("internal_error")]


class FullDisk(Sink):
    """A sink whose disk is full when a goal has started."""

    def __init__(self):
        super().__init__(WriteError("the trace can't be written: no space left on device"))

    def emit(self, output):
        """Raise at the second goal."""
        if isinstance(output, GoalChanged) and output.goal_id == NEXT:
            raise self.error

    def commanded(self, *_command):
        pass


def test_a_full_disk_ends_the_run_after_all_goals_have_ended():
    run = simulate(sinks=[FullDisk()], strict=False)
    run((0.0, send("eve", OTHER)), until=1.0)

    with pytest.raises(WriteError, match="no space left"):
        run.simulator.submit(send("wall_e", NEXT))
    assert "EXECUTING" == run.log.changes(NEXT)[-1][1]
    run.simulator.stop()
    assert ["ABORTED", "ABORTED"] == [run.log.changes(goal_id)[-1][1] for goal_id in (OTHER, NEXT)]


def test_runs_with_a_bug_are_reproducible():

    def traced():
        mine = replace(actions()["wait"], name="dance", process=later)
        run = simulate(actions={**actions(), "dance": mine}, strict=False, traced=True)
        run((0.0, send("wall_e", BROKEN, action="dance")), (0.5, send("eve", OTHER)))
        return run.lines()

    assert traced() == traced()

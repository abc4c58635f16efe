"""A trace that is written late: it has the bytes of one that is written at once."""

from __future__ import annotations

from hmrsim.actions import registry
from hmrsim.protocol.commands import GetResult, SendGoal, Stop
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.deferred import DeferredTrace
from hmrsim.trace.writer import Header, Trace
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD

GOAL = registry()["navigate_to_pose"].goal.model_validate({"pose": {"pose": {"position": {"x": 5.0, "y": 2.0}}}})


class Receiver:
    """Somebody who waits for an answer."""


def test_it_has_the_same_bytes_as_one_that_is_written_at_once():
    """In the middle of a run, and at its end."""
    world, settings, pieces = World.model_validate(SMALL_WORLD), RunSettings(), []
    late, trace = DeferredTrace(world, settings), Trace(Header.of(world, settings), pieces.append)
    simulator = Simulator(world, settings, [late, trace])
    simulator.submit(SendGoal("wall_e", "navigate_to_pose", GOAL, "1" * 32, Receiver()))
    trace.flush()
    middle = "".join(pieces)

    assert middle == late.text
    simulator.submit(GetResult("wall_e", "navigate_to_pose", "1" * 32, Receiver()))
    simulator.run()
    simulator.submit(Stop("it is late"))
    trace.flush()
    assert middle != "".join(pieces) == late.text


def test_it_keeps_nobody_who_waits_for_an_answer():
    """Some end with the last reference to them, which tells their senders that no more answers come."""
    world, ended = World.model_validate(SMALL_WORLD), []

    class Ending(Receiver):
        def __del__(self):
            ended.append(self)

    simulator = Simulator(world, sinks=[DeferredTrace(world, RunSettings())])
    simulator.submit(SendGoal("wall_e", "navigate_to_pose", None, "1" * 32, Ending()))
    simulator.submit(GetResult("wall_e", "navigate_to_pose", "2" * 32, Ending()))

    assert len(ended) == 2

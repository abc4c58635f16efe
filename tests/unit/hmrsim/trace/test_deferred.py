"""Traces that are written later, with the same bytes."""

from __future__ import annotations

from hmrsim.actions import registry
from hmrsim.protocol.commands import GetResult, SendGoal, Stop
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.writer import DeferredTrace, Header, Trace
from hmrsim.world.model import World
from tests.simulation import SMALL_WORLD

GOAL = registry()["navigate_to_pose"].goal.model_validate({"pose": {"pose": {"position": {"x": 5.0, "y": 2.0}}}})


class Receiver:
    """Somebody who waits for an answer."""


def test_deferred_writing_gives_the_same_bytes():
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


def test_it_keeps_no_reply_address():
    """The last reference to some of them tells their senders that no further answer comes."""
    world, ended = World.model_validate(SMALL_WORLD), []

    class Ending(Receiver):
        def __del__(self):
            ended.append(self)

    simulator = Simulator(world, sinks=[DeferredTrace(world, RunSettings())])
    simulator.submit(SendGoal("wall_e", "navigate_to_pose", None, "1" * 32, Ending()))
    simulator.submit(GetResult("wall_e", "navigate_to_pose", "2" * 32, Ending()))

    assert len(ended) == 2

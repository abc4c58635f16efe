"""Slow first-time work of a server, done before a client waits for it.

pydantic builds a message's validator and serializer upon first use, which takes 0.1 s for MoveIt's large messages.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import TYPE_CHECKING

from hmrsim.actions import registry as actions
from hmrsim.errors import NoRoute
from hmrsim.protocol.goal import WORLD
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import plain, read

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim.simulation.simulator import Simulator


def for_server(action: AnyAction) -> None:
    """Prepare to decode goals of an action and to encode their results."""
    goal: type[Message] = action.goal
    read(plain(goal), b"{}")
    encoding.message(action.result())


def steps(simulator: Simulator) -> Iterator[None]:
    """Prepare for the actions of a simulation's robots and for routes to the places of its world.

    Yields after each step; a step takes at most 0.1 s.
    """
    world, servers = simulator.world, simulator.dispatcher.servers
    served = {name for robot in (*simulator.robots, WORLD) for name in servers.actions_of(robot)}
    for name, action in actions().items():
        if name in served:
            for_server(action)
            yield
    speeds = sorted({robot.speed for robot in simulator.robots.values()})
    points = [*(place.at for place in world.places.values()), *(dock.at for dock in world.docks.values())]
    for point, speed in product(points, speeds):
        _find_ways(simulator, world.point(point), speed)
        yield


def _find_ways(simulator: Simulator, goal: tuple[float, float], speed: float) -> None:
    try:
        simulator.graph.find_ways(goal, speed)
    except NoRoute:
        # A goal to such a place is aborted with this reason.
        return

"""The service that moves a robot at velocities, without a goal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead
from hmrsim.goals.fault_effects import no_connection
from hmrsim.interfaces.hmrsim_msgs import SetVelocity
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import RequestFailed, Service

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_SECONDS: Final = 0.5
"""Simulated seconds for which a command applies, so that a robot stops without further ones."""


def _set_velocity(simulator: Simulator, request: SetVelocity.Request) -> None:
    name = request.robot
    robot, goal = simulator.roster.robots.get(name), simulator.dispatcher.goal_of(name)
    if robot is None:
        raise RequestFailed(f"robot: no robot {name!r}{instead(name, simulator.robots)}", Result.RESULT_NOT_FOUND)
    if name in simulator.dispatcher.cut_off:
        raise RequestFailed(f"robot: {no_connection(name)}", Result.RESULT_INCORRECT_STATE)
    if robot.disabled_reasons:
        raise RequestFailed("; ".join(robot.disabled_reasons.values()), Result.RESULT_INCORRECT_STATE)
    if goal is not None:
        raise RequestFailed(f"{name} executes {goal[0]} goal {goal[1]}; cancel it first", Result.RESULT_INCORRECT_STATE)
    if not robot.state.maneuvers and (robot.works or not robot.stands):
        raise RequestFailed(f"{name} is busy; wait until it stands", Result.RESULT_INCORRECT_STATE)
    blocked = robot.steer(request.linear, request.angular, _SECONDS)
    if blocked:
        raise RequestFailed(f"{name} stops before {blocked}")


SERVICES = (
    Service(SetVelocity, _set_velocity, changes_world=True, example={"robot": "tester", "linear": 0.5, "angular": 0.2}),
)

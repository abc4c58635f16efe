"""The service that moves a robot at velocities, without a goal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead
from hmrsim.goals.fault_effects import no_connection
from hmrsim.interfaces.hmrsim_msgs import SetVelocity
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import OK, Service, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_SECONDS: Final = 0.5
"""Simulated seconds for which a command applies, so that a robot stops without further ones."""


def _set_velocity(simulator: Simulator, request: SetVelocity.Request) -> Result:
    name = request.robot
    robot, goal = simulator.roster.robots.get(name), simulator.dispatcher.goal_of(name)
    if robot is None:
        return failed(f"robot: no robot {name!r}{instead(name, simulator.robots)}", Result.RESULT_NOT_FOUND)
    if name in simulator.dispatcher.cut_off:
        return failed(f"robot: {no_connection(name)}", Result.RESULT_INCORRECT_STATE)
    if robot.disabled_reasons:
        return failed("; ".join(robot.disabled_reasons.values()), Result.RESULT_INCORRECT_STATE)
    if goal is not None:
        return failed(f"{name} executes {goal[0]} goal {goal[1]}; cancel it first", Result.RESULT_INCORRECT_STATE)
    if not robot.state.maneuvers and (robot.works or not robot.stands):
        return failed(f"{name} is busy; wait until it stands", Result.RESULT_INCORRECT_STATE)
    blocked = robot.steer(request.linear, request.angular, _SECONDS)
    return failed(f"{name} stops before {blocked}") if blocked else OK


SERVICES = (
    Service(
        name="set_velocity",
        request=SetVelocity.Request,
        response=SetVelocity.Response,
        serve=lambda simulator, request: SetVelocity.Response(result=_set_velocity(simulator, request)),
        changes_world=True,
        example={"robot": "tester", "linear": 0.5, "angular": 0.2},
    ),
)

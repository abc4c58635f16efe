"""A snapshot of a running world at one instant, for a client that begins to watch; events report later changes."""

from __future__ import annotations

from collections import defaultdict
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import stamp
from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.simulation.detections import sensors_of

if TYPE_CHECKING:
    from hmrsim.goals.servers import ServedGoal
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.simulator import Simulator


def scene(simulator: Simulator) -> dict[str, Any]:
    """Return the present state, in plain values of JSON; constant data is in the world itself.

    Points and poses are in the world's unit, in the frame ``map``; yaws in radians.
    """
    roster, faults = simulator.roster, simulator.fault_injector.known
    goals, held = defaultdict[str, list["ServedGoal"]](list), defaultdict[str, list[str]](list)
    for goal in simulator.dispatcher.servers.all():
        goals[goal.server.robot.name].append(goal)
    for item in roster.items.values():
        if item.carrier:
            held[item.carrier.name].append(item.name)
    return {
        "stamp": values_of(stamp(simulator.now)),
        "robots": [
            {
                **_robot(robot),
                "waiting": roster.admission.waiting(robot),
                "cause": roster.admission.causes.link(robot, simulator.dispatcher.cut_off).to_json(),
                "connected": name not in simulator.dispatcher.cut_off,
                "holds": held[name],
                "goals": _goals(goals[name]),
            }
            for name, robot in roster.robots.items()
        ],
        "items": [
            {
                "name": item.name,
                "weight": item.weight,
                "at": [*item.position],
                "carrier": item.carrier.name if item.carrier else None,
            }
            for item in roster.items.values()
        ],
        "fixtures": [
            {"name": fixture.name, "kind": fixture.kind, "at": [*fixture.pose.point], "tags": fixture.tags}
            for fixture in roster.fixtures.values()
        ],
        "closed_lanes": [
            {"lane": [*lane], "why": "; ".join(why.values())} for lane, why in roster.admission.closures.lanes.items()
        ],
        "faults": [injected.began().to_json() for _, injected in sorted(faults.items()) if injected.end is not None],
    }


def _robot(robot: Robot) -> dict[str, Any]:
    battery = robot.energy.battery if robot.energy else None
    return {
        "name": robot.name,
        "type": robot.type,
        "radius": robot.radius,
        "flies": robot.flies,
        "speed": robot.speed,
        "pose": [*robot.pose()],
        "motion": robot.motion.to_json(),
        "route": [[*leg.end] for leg in robot.legs_ahead],
        "waits": robot.waits,
        "dock": robot.dock.name if robot.dock else None,
        "ailments": dict(robot.disabled_reasons),
        "battery": {"percentage": battery.share(robot.now), "charging": bool(battery.charging)} if battery else None,
        "sensors": [
            {
                "name": name,
                "range": sensor.range(robot.units),
                "field_of_view": getattr(sensor.settings, "field_of_view", None),
                "blind": sensor.blind,
            }
            for name, sensor in sensors_of(robot).items()
        ],
    }


def _goals(kept: list[ServedGoal]) -> list[dict[str, Any]]:
    """Return the last goal that ended, with its result, and the active goals, with their messages."""
    kept.sort(key=attrgetter("stamp"))
    ended = [goal for goal in kept if goal.status.terminal]
    return [
        {
            **goal.accepted().to_json(),
            "stamp": values_of(goal.stamp),
            "ended": None if goal.ended is None else values_of(goal.ended),
            "status": int(goal.status),
            "result": result.model_dump(mode="json") if (result := goal.result) else None,
        }
        for goal in (*ended[-1:], *(goal for goal in kept if not goal.status.terminal))
    ]

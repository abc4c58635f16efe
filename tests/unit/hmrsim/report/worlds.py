"""Small worlds whose reports can be computed by hand, with robots at 1 m/s."""

from __future__ import annotations

from hmrsim.services import registry as services
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim.trace.writer import Header, Trace
from hmrsim.world_checks.loading import world_of

WAYS = {
    "waypoints": {"home": [0, 0], "door": [4, 0]},
    "lanes": [["home", "door"]],
    "robot_types": {"cart": {"base": {"speed": 1}}},
}

ALONE = WAYS | {
    "name": "alone",
    "robots": {"wall_e": {"type": "cart", "at": "home", "script": ["Go door", "Wait 2", "Go home"]}},
}

MEETING = {
    "name": "meeting",
    "waypoints": {"west": [0, 0], "middle": [3, 0], "east": [6, 0], "south": [3, -3], "north": [3, 3]},
    "lanes": [["west", "middle"], ["middle", "east"], ["south", "middle"], ["middle", "north"]],
    "robot_types": {"cart": {"base": {"speed": 1}}},
    "traffic": {"policy": "reserve"},
    "robots": {
        "early": {"type": "cart", "at": "west", "script": ["Go east"]},
        "late": {"type": "cart", "at": "south", "script": ["Wait 2", "Go north"]},
    },
}

OPENED = {
    "name": "opened",
    "waypoints": {"west": [0, 0], "middle": [3, 0], "east": [5, 0], "north": [3, 3]},
    "lanes": [["west", "middle"], ["middle", "east"], ["middle", "north"]],
    "doors": {"gate": {"at": [[1, -1], [1, 1]], "opening_time": 1}},
    "robot_types": {"cart": {"base": {"speed": 1}}},
    "traffic": {"policy": "reserve"},
    "robots": {
        "early": {"type": "cart", "at": "east", "script": ["Go north"]},
        "late": {"type": "cart", "at": "west", "script": ["Go middle"]},
    },
}

CHARGING = {
    "name": "charging",
    "waypoints": {"home": [0, 0], "door": [4, 0]},
    "lanes": [["home", "door"]],
    "docks": {"charger": {"at": "home", "type": "charger", "power": 10}},
    "robot_types": {
        "cart": {
            "base": {"speed": 1},
            "components": {"battery": {"capacity": 100, "taper_from": 1, "drain": {"still": 0, "moving": 2}}},
        }
    },
    "robots": {
        "wall_e": {"type": "cart", "at": "door", "script": ["Go home", "Go door", "Go home", "Dock charger", "Wait 10"]}
    },
}

FAULTY = WAYS | {
    "name": "faulty",
    "robots": {"wall_e": {"type": "cart", "at": "home", "script": ["Go door"]}},
    "faults": [{"type": "breakdown", "robot": "wall_e", "name": "flat_tyre", "at": 2}],
}


def goal_to(x, y):
    return {"pose": {"pose": {"position": {"x": x, "y": y}}}}


def traced(world, *, commands=(), until=None):
    """Return the trace of a run: scripts to their end, commands at their times, then until a time."""
    lines = []
    model, settings = world_of(world, "test"), RunSettings()
    trace = Trace(Header.of(model, settings), lambda text: lines.extend(text.splitlines(keepends=True)))
    simulator = Simulator(model, settings, [trace], services=services())
    for at, command in commands:
        simulator.advance(at)
        simulator.submit(command)
    simulator.run_scripts()
    if until is not None:
        simulator.advance(until)
    trace.close(simulator.now)
    return lines

"""The list of robots: what each does, and why it waits."""

from __future__ import annotations

from hmrsim.cli.robot import rows

ROBOT = {
    "name": "mocha",
    "type": None,
    "pose": [1.0, 2.5, 0.0],
    "battery": None,
    "goals": [],
    "ailments": {},
    "holds": [],
    "dock": None,
    "connected": True,
    "waits": False,
    "waiting": None,
}
DOCK = {"name": "charger", "tags": ["dock", "charger", "full", "docked:latte", "queued:mocha"]}


def state(*fixtures, **robot):
    """Return the state of a robot in the list."""
    ((*_, state),) = rows({"robots": [{**ROBOT, **robot}], "fixtures": fixtures})
    return state


def test_the_other_columns():
    """Missing values are dashes."""
    assert [("mocha", "-", "(1, 2.5)", "-", "idle")] == list(rows({"robots": [ROBOT], "fixtures": []}))


def test_a_robot_queues_for_a_dock():
    """The state names the robots that are docked."""
    assert "dock_robot, queues for charger (docked there: latte)" == state(
        DOCK, goals=[{"action": "dock_robot", "status": 2}]
    )


def test_a_robot_waits_for_others():
    """The state names the robots that block it."""
    blockers = ["latte, idle at counter since 8 s; it has nowhere to go", "chai, driving at hall"]
    assert "waits for latte, idle at counter since 8 s; it has nowhere to go; and for chai, driving at hall" == state(
        waits=True, waiting={"for": ["latte", "chai"], "blockers": blockers}
    )


def test_a_robot_waits_for_something_else():
    """The state says what it waits for, such as a door."""
    assert "waits: kitchen is locked" == state(waits=True, waiting={"why": "kitchen is locked"})

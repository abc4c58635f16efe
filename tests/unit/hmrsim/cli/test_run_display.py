"""The log of a served world."""

from __future__ import annotations

import logging
from types import SimpleNamespace

from hmrsim.cli.run_display import LogDisplay
from hmrsim.events.facilities import DoorOpening
from hmrsim.events.robots import BatteryEmpty
from hmrsim.protocol.outputs import EventStamped
from tests.shipped import shipped


def test_events_are_logged_at_levels_without_goals(caplog):
    """An error is told at ``--log-level error``, where what is less is not."""
    display = LogDisplay("ward", logging.ERROR)

    with caplog.at_level(logging.ERROR):
        for event in (DoorOpening("gate"), BatteryEmpty("eve", 0.0, 0.0, (1.0, 2.0))):
            for sink in display.sinks:
                sink.emit(EventStamped(0, event))
        for tell in display.on_wait:
            tell()

    assert ["sim 0.000 | eve has an empty battery"] == caplog.messages


def test_the_log_begins_with_the_traffic_policy(caplog):
    """It is in the line after the one that names the world."""
    simulator = SimpleNamespace(now=0.0, world=shipped("cafe").world)
    host = SimpleNamespace(simulator=simulator, pacing=SimpleNamespace(state=SimpleNamespace(waiting_for=())))

    with caplog.at_level(logging.INFO), LogDisplay("cafe", logging.INFO).shown(host):
        pass

    assert ["sim 0.000 | cafe begins", "sim 0.000 | traffic policy: priority"] == caplog.messages[:2]

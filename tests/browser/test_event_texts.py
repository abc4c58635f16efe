"""The page's texts of events equal Python's."""

from __future__ import annotations

import json

from hmrsim.events import Event, texts
from hmrsim.events.goals import GoalAccepted, GoalStatusChanged
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world
from tests.simulation import Log

_TOLD = """async (events) => {
  const { describe, render } = await import('/model/texts.js');
  const { texts } = hmrsim.model;
  return events.map((event) => {
    const { severity, subject, text } = describe(event, { texts, world: { nameAt: () => '' } });
    return [severity, subject, texts[event.kind] ? render(texts[event.kind].text, event) : text];
  });
}"""

ID = "0" * 32


def _published(name: str) -> list[Event]:
    """Return all events of a shipped world's scripts."""
    log = Log()
    simulator = Simulator(load_world(name).world, sinks=[log])
    simulator.run_scripts(60.0)
    return [
        event.event() if isinstance(event, GoalChanged) else event.event
        for _, event in log.events
        if isinstance(event, GoalChanged | EventStamped)
    ]


def test_severity_subject_and_text_of_events_equal_pythons(viewed, open_page):
    _, url = viewed("scenario1")
    events = [event for name in ("hospital", "zoo/lift", "zoo/corridor_swap") for event in _published(name)]
    events += [GoalStatusChanged("eve", "wait", ID, 6, {"error_code": {"val": -1, "message": "no"}})]
    events += [GoalStatusChanged("_world", "simulate_steps", ID, 5, {"error_msg": "canceled"})]
    events += [GoalAccepted("eve", "wait", ID, {"time": {"sec": 2}})]

    told = open_page(url).evaluate(_TOLD, [json.loads(json.dumps({"kind": e.kind, **e.to_json()})) for e in events])

    assert len(events) > 50
    assert [[event.severity.value, event.subject, event.text()] for event in events] == told


def test_an_unknown_event_is_shown_by_its_kind(viewed, open_page):
    _, url = viewed("scenario1")
    page = open_page(url)

    assert [["info", "eve", "floor cleaned"]] == page.evaluate(_TOLD, [{"kind": "floor_cleaned", "robot": "eve"}])
    assert "stops at home" == page.evaluate(
        "async (texts) => (await import('/model/texts.js'))"
        ".describe({kind: 'stopped', robot: 'eve', at: [1, 2]}, {texts, world: {nameAt: () => 'home'}}).text",
        texts(),
    )

"""The guarantees of every kind of event in the registry."""

from __future__ import annotations

import gc
import json

import pytest
from jsonschema import Draft202012Validator

from hmrsim import events
from hmrsim.events import Event, _registry, registry
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world
from hmrsim_zenoh.schemas import event_schema
from hmrsim_zenoh.wire import encoding
from tests.simulation import Log
from tools.event_tables import main as tables


@pytest.fixture(params=registry().values(), ids=registry())
def kind(request):
    return request.param


def _example(schema):
    if "anyOf" in schema:
        return _example(schema["anyOf"][0])
    if "prefixItems" in schema:
        return [_example(item) for item in schema["prefixItems"]]
    known = {"string": "x", "number": 1.5, "integer": 1, "boolean": True, "object": {"robot": "eve"}}
    return [_example(schema["items"])] if schema["type"] == "array" else known[schema["type"]]


def example(kind):
    schema = events.model_of(kind).model_json_schema(by_alias=True)
    fields = {name: _example(field) for name, field in schema.get("properties", {}).items()}
    return kind.from_json(fields | (fields.pop(kind.rest) if kind.rest else {}))


def test_it_survives_json(kind):
    event = example(kind)

    assert event == events.from_json(json.loads(json.dumps({"kind": kind.kind, **event.to_json()})))


def test_its_text_fills_in_all_fields(kind):
    text = example(kind).describe()

    assert text
    assert not {*"{}[]|"} & {*text}
    assert text == text.strip()
    assert "  " not in text


def test_its_schema_accepts_it_and_requires_its_fields(kind):
    validator = Draft202012Validator(event_schema())
    head = {"kind": kind.kind, "stamp": {"sec": 1, "nanosec": 0}}

    assert [] == [*validator.iter_errors({**head, **json.loads(json.dumps(example(kind).to_json()))})]
    assert bool([*validator.iter_errors(head)]) == bool(kind._fields)


@pytest.mark.parametrize("name", ["crossing", "door", "lift", "charger_queue"])
def test_published_events_match_their_schemas(name):
    validator = Draft202012Validator(event_schema())
    log = Log()
    simulator = Simulator(load_world(f"zoo/{name}").world, sinks=[log])
    simulator.run_scripts()
    events = [event for _, event in log.events if isinstance(event, GoalChanged | EventStamped)]
    published = [encoding.event_payload(event) for event in events]

    assert published
    assert [] == [error for payload in published for error in validator.iter_errors(json.loads(payload))]


def test_declarations_have_no_flaws():
    assert [] == [*events.flaws()]


def test_the_tables_in_the_docs_are_up_to_date():
    assert 0 == tables(["--check"])


def test_flaws_are_found(monkeypatch):
    class Bad(
        Event, kind="bad", severity="dreadful", text="{nothing} {robot:loud}", changes="mood", sets={"robot": "happy"}
    ):
        robot: str

    monkeypatch.setattr(_registry, "registry", lambda: {"bad": Bad})
    monkeypatch.setattr(_registry, "_concrete", lambda _event: [Bad])
    found = [*events.flaws()]
    monkeypatch.setattr(_registry, "registry", dict)

    assert [
        "has no docstring",
        "robot has no description",
        "is shown with 'nothing', which is not one of its fields",
        "is shown with a format 'loud', which does not exist",
        "has the severity 'dreadful', which does not exist",
        "changes 'mood', which is no part of a scene",
        "sets 'robot', which is a field of it",
    ] == [line.rpartition("Bad: ")[2] for line in found]
    assert [f"{__name__}: Bad is not in EVENTS"] == [*events.flaws()]


@pytest.mark.parametrize("allocations", range(1, 8))
def test_a_class_is_made_while_garbage_is_collected(allocations):
    before = gc.get_threshold()
    gc.set_threshold(allocations, 1, 1)
    try:

        class EventStamped(Event, kind="of_this_test", severity="info", subject=("robot",), text="is there"):
            robot: str

    finally:
        gc.set_threshold(*before)

    assert "wall_e" == EventStamped(robot="wall_e").robot

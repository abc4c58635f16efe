"""Events as frozen, typed values that can be read from JSON."""

from __future__ import annotations

import copy
import pickle

import pytest

from hmrsim.events import Severity, UnknownEvent, from_json
from hmrsim.events._text import render
from hmrsim.events.facilities import DoorOpened, DoorOpening
from hmrsim.events.faults import FaultMissed
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.traffic import Deadlock, MadeRoom, Waiting


def test_an_event_is_frozen():
    event = DoorOpening("gate")

    with pytest.raises(AttributeError):
        event.door = "other"
    with pytest.raises(AttributeError):
        event.colour = "red"


def test_events_are_equal_if_their_kind_and_fields_are():
    """Events are tuples, but those of different kinds are never equal."""
    assert DoorOpening("gate") == DoorOpening(door="gate", by="")
    assert DoorOpening("gate") != DoorOpened("gate")
    assert 2 == len({DoorOpening("gate"), DoorOpening("gate"), DoorOpened("gate")})


@pytest.mark.parametrize("again", [copy.deepcopy, lambda event: pickle.loads(pickle.dumps(event))])
def test_an_event_can_be_copied(again):
    event = MadeRoom("eve", (0.0, 0.0), (1.0, 0.0), "ann")

    assert event == again(event)
    assert type(event) is type(again(event))


def test_json_has_fields_in_order_without_underscores_and_defaults():
    assert [("robot", "eve"), ("from", [0.0, 0.0]), ("to", [1.0, 0.0]), ("by", "ann")] == [
        *MadeRoom("eve", (0.0, 0.0), (1.0, 0.0), "ann").to_json().items()
    ]
    assert {"robot": "eve", "at": [1.0, 2.0], "for": []} == Waiting("eve", (1.0, 2.0), for_=()).to_json()
    assert {"door": "gate"} == DoorOpening("gate").to_json()


def test_settings_of_a_fault_become_fields_in_json():
    event = FaultMissed("slip", "wet", {"robot": "eve", "at": 3.0}, "no robot")
    fields = event.to_json()

    assert ["fault", "name", "robot", "at", "why"] == [*fields]
    assert event == from_json({"kind": "fault_missed", "stamp": {"sec": 3, "nanosec": 0}, **fields})


def test_unknown_fields_are_ignored():
    """A newer version may write further fields."""
    assert DoorOpening("gate") == from_json({"kind": "door_opening", "door": "gate", "speed": 3})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"door": "gate"}, "kind is not text"),
        ({"kind": "door_opening"}, "door: Field required"),
        ({"kind": "door_opening", "door": 7}, "door: Input should be a valid string"),
        ({"kind": "stopped", "robot": "eve", "at": [1.0, float("inf")]}, "at.1: Input should be a finite number"),
        ({"kind": "stopped", "robot": "eve", "at": [1.0, True]}, "at.1: Input should be a valid number"),
    ],
)
def test_an_error_names_each_invalid_field(fields, message):
    with pytest.raises(ValueError, match=message):
        from_json(fields)


def test_an_unknown_kind_keeps_its_fields():
    event = from_json({"kind": "floor_cleaned", "robot": "eve", "area": 2.5, "path": [[1, 2]], "stamp": 7})

    assert isinstance(event, UnknownEvent)
    assert ("floor_cleaned", {"robot": "eve", "area": 2.5, "path": [[1, 2]]}) == (event.kind, event.to_json())
    assert ("eve floor cleaned: area 2.5", Severity.INFO) == (event.describe(), event.severity)


def test_a_description_starts_with_the_subject():
    assert "eve waits for ann" == Waiting("eve", (1.0, 2.0), for_=("ann",)).describe()
    assert "deadlock of ann and eve" == Deadlock(("ann", "eve"), ()).describe()


@pytest.mark.parametrize(
    ("status", "severity"), [(2, Severity.DEBUG), (4, Severity.INFO), (5, Severity.WARNING), (6, Severity.ERROR)]
)
def test_a_severity_may_depend_on_a_field(status, severity):
    assert severity is GoalStatusChanged("eve", "wait", "1" * 32, status).severity


def test_a_goal_of_the_world_has_no_robot_as_subject():
    assert "" == GoalStatusChanged("_world", "simulate_steps", "1" * 32, 4).subject


@pytest.mark.parametrize(
    ("template", "fields", "text"),
    [
        ("goes to {stop}", {"stop": "roof"}, "goes to roof"),
        ("goes to {stop}", {}, "goes to "),
        ("opens[ for {by}]", {}, "opens"),
        ("opens[ for {by}]", {"by": ""}, "opens"),
        ("opens[ for {by}]", {"by": "eve"}, "opens for eve"),
        ("waits[: {why}| for {for:and}| for its turn]", {"why": "a door", "for": ["eve"]}, "waits: a door"),
        ("waits[: {why}| for {for:and}| for its turn]", {"for": ["ann", "bob", "eve"]}, "waits for ann, bob and eve"),
        ("waits[: {why}| for {for:and}| for its turn]", {"for": []}, "waits for its turn"),
        ("[{present=true}is there|is gone]", {"present": True}, "is there"),
        ("[{present=true}is there|is gone]", {"present": False}, "is gone"),
        ("[{status=6}ABORTED][{status=6}: {result:error}]", {"status": 6, "result": {"error_msg": ""}}, "ABORTED"),
        ("[{status=6}: {result:error}]", {"status": 6, "result": {"error_code": {"val": -1, "message": "no"}}}, ": no"),
        ("[{status=6}: {result:error}]", {"status": 6, "result": {"result": {"error_message": "no"}}}, ": no"),
        ("wait accepted[: {goal:goal}]", {"goal": {"time": 3}}, "wait accepted"),
        ("{at:point}", {"at": [1.0, 2.125]}, "(1, 2.12)"),
        ("{points:end}", {"points": [[1, 2], [3, 4]]}, "(3, 4)"),
        ("{percentage:percent}", {"percentage": 0.204}, "20%"),
        ("{lane:lane}", {"lane": ["a", "b"]}, "a-b"),
        ("{waited}", {"waited": 100.0}, "100"),
    ],
)
def test_a_template_is_filled_in(template, fields, text):
    assert text == render(template, fields)


def test_a_caller_can_add_formats():
    assert "at home" == render("at {at:point}", {"at": [1.0, 2.0]}, {"point": lambda _at: "home"})

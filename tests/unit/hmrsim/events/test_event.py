"""What every event is: a frozen, typed value that can be read from its JSON."""

from __future__ import annotations

import copy
import pickle

import pytest

from hmrsim.events import Severity, UnknownEvent, from_json
from hmrsim.events.facilities import DoorOpened, DoorOpening
from hmrsim.events.faults import FaultMissed
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.traffic import Deadlock, MadeRoom, Waiting


def test_an_event_is_frozen():
    """Fields of an event can't be set, and no others can be added."""
    event = DoorOpening("gate")

    with pytest.raises(AttributeError):
        event.door = "other"
    with pytest.raises(AttributeError):
        event.colour = "red"


def test_events_are_equal_if_their_kind_and_fields_are():
    """Events of different kinds are never equal, although both are tuples."""
    assert DoorOpening("gate") == DoorOpening(door="gate", by="")
    assert DoorOpening("gate") != DoorOpened("gate")
    assert 2 == len({DoorOpening("gate"), DoorOpening("gate"), DoorOpened("gate")})


@pytest.mark.parametrize("again", [copy.deepcopy, lambda event: pickle.loads(pickle.dumps(event))])
def test_an_event_can_be_copied(again):
    """An event can be copied and pickled."""
    event = MadeRoom("eve", (0.0, 0.0), (1.0, 0.0), "ann")

    assert event == again(event)
    assert type(event) is type(again(event))


def test_json_has_names_without_underscores_and_no_defaults():
    """JSON has the fields in the order of their declaration."""
    assert [("robot", "eve"), ("from", [0.0, 0.0]), ("to", [1.0, 0.0]), ("by", "ann")] == [
        *MadeRoom("eve", (0.0, 0.0), (1.0, 0.0), "ann").to_json().items()
    ]
    assert {"robot": "eve", "at": [1.0, 2.0], "for": []} == Waiting("eve", (1.0, 2.0), for_=()).to_json()
    assert {"door": "gate"} == DoorOpening("gate").to_json()


def test_settings_of_a_fault_are_fields_of_their_own_in_json():
    """The settings of a fault become fields in JSON, and are read from them."""
    event = FaultMissed("slip", "wet", {"robot": "eve", "at": 3.0}, "no robot")
    fields = event.to_json()

    assert ["fault", "name", "robot", "at", "why"] == [*fields]
    assert event == from_json({"kind": "fault_missed", "stamp": {"sec": 3, "nanosec": 0}, **fields})


def test_fields_that_are_unknown_are_passed_over():
    """Unknown fields, as of a newer version, are ignored."""
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
def test_fields_that_are_wrong_are_named(fields, message):
    """An error names each invalid field."""
    with pytest.raises(ValueError, match=message):
        from_json(fields)


def test_an_unknown_kind_keeps_its_fields():
    """An event of unknown kind shows its fields, except nested ones."""
    event = from_json({"kind": "floor_cleaned", "robot": "eve", "area": 2.5, "path": [[1, 2]], "stamp": 7})

    assert isinstance(event, UnknownEvent)
    assert ("floor_cleaned", {"robot": "eve", "area": 2.5, "path": [[1, 2]]}) == (event.kind, event.to_json())
    assert ("eve floor cleaned: area 2.5", Severity.INFO) == (event.describe(), event.severity)


def test_an_event_describes_itself():
    """The description of an event starts with its subject, unless that is the whole world."""
    assert "eve waits for ann" == Waiting("eve", (1.0, 2.0), for_=("ann",)).describe()
    assert "deadlock of ann and eve" == Deadlock(("ann", "eve"), ()).describe()


@pytest.mark.parametrize(
    ("status", "severity"), [(2, Severity.DEBUG), (4, Severity.INFO), (5, Severity.WARNING), (6, Severity.ERROR)]
)
def test_a_severity_may_depend_on_a_field(status, severity):
    """The severity can depend on a field, such as the status of a goal."""
    assert severity is GoalStatusChanged("eve", "wait", "1" * 32, status).severity


def test_what_the_world_does_is_about_no_robot():
    """A goal of the world has no robot as its subject."""
    assert "" == GoalStatusChanged("_world", "simulate_steps", "1" * 32, 4).subject

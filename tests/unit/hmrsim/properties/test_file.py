"""Files of properties: their content, and the errors that are reported."""

from __future__ import annotations

import json

import pytest
import yaml
from jsonschema import Draft202012Validator

from hmrsim.errors import PropertyError
from hmrsim.properties import check_properties, properties_of, read_properties
from tests.paths import ROOT
from tests.watching import ward

EXAMPLE = """
properties:
  medicine_arrives: {eventually: {item: medicine, at: ward_a, carried: false}, within: 600}
  charged:          {always: {battery: "*", above: 0.05}}
  keep_out:         {never: {robot: eve, at: lab}}
  in_time:
    {whenever: {event: order_placed}, then: {event: order_delivered, where: {order: $order}}, within: 900}
  retries:          {whenever: {goal: aborted, robot: "*"}, then: {goal: accepted, robot: $robot}, within: 30}
  door_used:        {sometimes: {event: door_opened}}
  rounds:           {patrolling: [ward_a, ward_b], robot: eve, every: 300}
  order_of_visits:  {ordered_visit: [pharmacy, ward_a], robot: wall_e}
  few_visits:       {upper_restricted_avoidance: {robot: eve, at: lab}, count: 3}
  react:
    {instantaneous_reaction: {event: fault_began, where: {fault: breakdown}}, then: {robot: $robot, is: stopped}}
  recharged:        {formula: {always: {eventually: {battery: eve, above: 0.5}, within: 600}}}
built_in: {no_deadlock: false, nobody_stranded: true, no_vain_goals: 3}
"""


def told(said: object) -> list[str]:
    """Return the errors of properties: path and message."""
    with pytest.raises(PropertyError) as error:
        properties_of(said)
    return [f"{problem.path}: {problem.message}" for problem in error.value.problems]


def test_the_example_file_is_read(tmp_path):
    """True stands for the default of a built-in property."""
    (tmp_path / "p.yaml").write_text(EXAMPLE)

    read = read_properties(tmp_path / "p.yaml")

    assert (11, False, 120.0, 3) == (
        len(read.properties),
        read.built_in.no_deadlock,
        read.built_in.nobody_stranded,
        read.built_in.no_vain_goals,
    )


def test_a_property_given_as_a_model_does_not_hide_errors():
    lab = properties_of({"properties": {"lab": {"never": {"robot": "eve", "at": "lab"}}}}).properties["lab"]

    assert told({"properties": {"lab": lab, "hall": {"nevr": {}}}}) == [
        "properties.hall: is no property; did you mean 'never'?"
    ]


def test_the_schema_accepts_all_of_some_formulas():
    """An editor does not confuse formulas with conditions."""
    schema = json.loads((ROOT / "schemas" / "properties.schema.json").read_text())
    lab = {"robot": "eve", "at": "lab"}

    for formula in ({"all": [lab]}, {"any": [lab, lab]}, {"not": lab}):
        assert Draft202012Validator(schema).is_valid({"properties": {"lab": {"formula": formula}}})


def test_the_schema_accepts_the_example_and_marks_errors():
    schema = json.loads((ROOT / "schemas" / "properties.schema.json").read_text())
    data = yaml.safe_load(EXAMPLE)

    valid = Draft202012Validator(schema)

    assert ([], False) == (
        [error.message for error in valid.iter_errors(data)],
        valid.is_valid({"properties": {"x": {"never": {"robot": "eve", "att": "lab"}}}}),
    )


def test_all_errors_of_a_file_have_line_path_and_remedy(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(
        "properties:\n"
        "  a: {eventualy: {robot: eve, at: lab}}\n"
        "  b: {never: {robot: eve, att: lab}}\n"
        "  c: {sometimes: {event: door_opend}}\n"
        "built_in: {no_deadlok: 3}\n"
    )

    with pytest.raises(PropertyError) as error:
        read_properties(path)

    assert [
        (2, "properties.a", "is no property; did you mean 'eventually'?"),
        (3, "properties.b.never.att", "unknown key 'att'; did you mean 'at'?"),
        (4, "properties.c.sometimes.event", "there is no kind of event 'door_opend'; did you mean 'door_opened'?"),
        (5, "built_in.no_deadlok", "unknown key 'no_deadlok'; did you mean 'no_deadlock'?"),
    ] == [(each.line, each.path, each.message) for each in error.value.problems]


def test_conditions_are_checked_at_any_depth():
    nested = {"sometimes": {"all": [{"not": {"any": [{"lane": ["a"], "is": "closed"}, {"robot": "eve"}]}}]}}

    assert [
        "properties.x.sometimes.all.0.not.any.0.lane: expected the two waypoints where the lane begins and ends, got 1",
        "properties.x.sometimes.all.0.not.any.1: expected at: PLACE, is: STATE, or both",
    ] == told({"properties": {"x": nested}})


def test_a_mapping_has_the_errors_of_a_mapping_only():
    """It is not reported that the value could also be false."""
    assert [
        "built_in.recovers.within: is missing",
        "built_in.recovers.withn: unknown key 'withn'; did you mean 'within'?",
    ] == told({"built_in": {"recovers": {"withn": 3}}})


def test_a_field_of_no_trigger_is_an_error():
    """``$order`` needs a trigger with such a field, and stands in ``then`` only."""
    delivered = {"event": "order_delivered", "where": {"order": "$ordr"}}

    assert [
        "properties.x.then.where.order: the trigger has no field 'ordr'; did you mean 'order'?",
        "properties.y.never.robot: '$robot' stands for a field of a trigger's event; it can be used in `then` of one",
    ] == told(
        {
            "properties": {
                "x": {"whenever": {"event": "order_placed"}, "then": delivered},
                "y": {"never": {"robot": "$robot", "at": "lab"}},
            }
        }
    )


def test_the_name_of_a_built_in_property_is_taken():
    assert ["properties.goals_end: 'goals_end' is a property that is built in; give another name"] == told(
        {"properties": {"goals_end": {"sometimes": {"event": "door_opened"}}}}
    )


def test_a_file_without_a_mapping_is_an_error(tmp_path):
    (tmp_path / "p.yaml").write_text("[1, 2]")

    with pytest.raises(PropertyError, match=r"expected a mapping with properties, built_in or both, got \[1, 2\]"):
        read_properties(tmp_path / "p.yaml")


def test_a_missing_file_is_an_error(tmp_path):
    with pytest.raises(PropertyError, match=r"none\.yaml: no such file"):
        read_properties(tmp_path / "none.yaml")


def test_a_star_among_the_fields_of_an_event_is_an_error():
    assert ["properties.x.never.where.robot: for each robot, put robot: '*' beside where"] == told(
        {"properties": {"x": {"never": {"event": "picked", "where": {"robot": "*"}}}}}
    )


def test_an_order_can_not_name_a_place_twice():
    """A sequence may do so."""
    twice = ["lab", "hall", "lab"]

    assert ["properties.x.ordered_visit.2: 'lab' is there already; a place can have one position in an order"] == told(
        {"properties": {"x": {"ordered_visit": twice, "robot": "eve"}, "y": {"sequenced_visit": twice, "robot": "eve"}}}
    )


def checked(**said: object) -> list[tuple[str, str]]:
    """Return the findings on properties in a world: severity, path and message."""
    properties = properties_of({"properties": said})
    return [
        (problem.severity, f"{problem.path}: {problem.message}")
        for problem in properties.problems(check_properties(properties, ward()))
    ]


def test_names_of_the_world_are_no_findings():
    assert [] == checked(
        a={"never": {"robot": "*", "at": "charger"}},
        b={"sometimes": {"all": [{"item": "medicine", "at": "ward_a"}, {"item": "pills_7", "carried_by": "eve"}]}},
        c={"always": {"any": [{"battery": "*", "above": 0.1}, {"door": "gate", "is": "open"}]}},
        d={"never": {"any": [{"order": "pills_3", "is": "late"}, {"lane": ["hall", "lab"], "is": "closed"}]}},
        e={"never": {"any": [{"fault": "slip"}, {"goal": "aborted", "robot": "eve", "action": "wait"}]}},
        f={"whenever": {"event": "door_opened", "where": {"door": "gate"}}, "then": {"event": "order_placed"}},
        g={"fair_visit": ["lab", "ward_b"], "robot": "cart"},
    )


def test_names_that_the_world_lacks_are_errors_with_the_known_ones():
    found = checked(
        a={"never": {"robot": "eva", "at": "lap"}},
        b={"never": {"item": "medicin", "carried": True}},
        c={"always": {"battery": "cart", "above": 0.1}},
        d={"never": {"door": "gat", "is": "open"}},
        e={"never": {"lane": ["lab", "hal"], "is": "closed"}},
        f={"never": {"fault": "slipp"}},
        g={"never": {"goal": "aborted", "action": "wayt"}},
        h={"never": {"event": "door_opened", "where": {"door": "gat"}}},
        i={"visit": ["lab", "ward_c"], "robot": "eve"},
    )

    assert [
        "properties.a.never.robot: no robot 'eva'; did you mean 'eve'?",
        "properties.a.never.at: no waypoint, place or dock 'lap'; did you mean 'lab'?",
        "properties.b.never.item: no item 'medicin'; did you mean 'medicine'?",
        "properties.c.always.battery: cart has no battery; these have one: eve, wall_e",
        "properties.d.never.door: no door 'gat'; did you mean 'gate'?",
        "properties.e.never.lane: no lane 'lab-hal'; did you mean 'lab-hall'?",
        "properties.f.never.fault: no kind of fault 'slipp'; did you mean 'slip'?",
        "properties.g.never.action: no action 'wayt'; did you mean 'wait'?",
        "properties.h.never.where.door: no door 'gat'; did you mean 'gate'?",
        "properties.i.visit.1: no waypoint, place or dock 'ward_c'; did you mean 'ward_b'?",
    ] == [message for severity, message in found if severity == "error"]


def test_a_property_that_the_world_can_not_exercise_is_a_warning():
    found = checked(
        a={"never": {"event": "lift_called"}},
        b={"never": {"event": "deadlock"}},
        c={"never": {"order": "letters_1", "is": "late"}},
        d={"sometimes": {"robot": "cart", "is": "charging"}},
        e={"sometimes": {"event": "script_ended"}},
    )

    assert [
        ("warning", "properties.a.never.event: lift_called never comes in this world: it has no lifts"),
        (
            "warning",
            (
                "properties.b.never.event: deadlock never comes in this world: robots pass through each other "
                "under the traffic policy free"
            ),
        ),
        (
            "warning",
            (
                "properties.c.never.order: no demand brings an order 'letters_1', so that only a client can; "
                "there are pills_1"
            ),
        ),
        ("warning", "properties.d.sometimes.is: cart has no battery, and never charges"),
        ("warning", "properties.e.sometimes.event: script_ended never comes in this world: no robot has a script"),
    ] == found


def test_a_finding_has_the_line_of_its_file(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("properties:\n  x:\n    never:\n      robot: eva\n      at: lab\n")
    properties = read_properties(path)

    (problem,) = properties.problems(check_properties(properties, ward()))

    assert f"{path}:4: properties.x.never.robot: no robot 'eva'; did you mean 'eve'?" == str(problem)

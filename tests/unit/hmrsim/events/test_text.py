"""Templates of texts."""

from __future__ import annotations

import pytest

from hmrsim.events._text import render


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
    """An optional part is omitted unless all of its fields are present."""
    assert text == render(template, fields)


def test_a_reader_can_have_formats_of_its_own():
    """A caller can add formats, such as one that names points."""
    assert "at home" == render("at {at:point}", {"at": [1.0, 2.0]}, {"point": lambda _at: "home"})

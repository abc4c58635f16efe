"""The output of commands: YAML, JSON and files."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli.options import UnknownName, WrongUse
from hmrsim.cli.output import show_json, yaml_text
from hmrsim.cli.topic import field_of, field_path


def test_text_has_nine_digits():
    """Nine digits hide the rounding errors of binary arithmetic."""
    assert "x: 0.3\ny: 2.0\nsec: 1234567891\n" == yaml_text({"x": 0.1 + 0.2, "y": 2.0, "sec": 1_234_567_891})


def test_json_has_all_digits(capsys):
    show_json([0.1 + 0.2])

    assert [0.1 + 0.2] == json.loads(capsys.readouterr().out)


MESSAGE = {"pose": {"position": {"x": 1.5, "y": 2.0}}, "covariance": [[1, 2], [3, 4]], "name": "mocha"}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pose.position.x", 1.5),
        ("pose.position", {"x": 1.5, "y": 2.0}),
        ("covariance[1][0]", 3),
        ("covariance[-1]", [3, 4]),
        ("name", "mocha"),
    ],
)
def test_fields_are_found_by_dots_and_brackets(text, value):
    assert value == field_of(MESSAGE, field_path(text))


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("pose.positon", "field 'pose' has no field 'positon'; did you mean 'position'?"),
        ("nam", "the message has no field 'nam'; did you mean 'name'?"),
        ("pose.position.x.y", "field 'pose.position.x' has no field 'y'"),
        ("pose[0]", "field 'pose' is not a list"),
        ("covariance[2]", r"field 'covariance' has 2 entries, and none at \[2\]"),
        ("covariance[-3]", r"field 'covariance' has 2 entries, and none at \[-3\]"),
        ("covariance.x", "field 'covariance' has no field 'x'"),
    ],
)
def test_a_missing_field_lists_the_known_fields(text, error):
    with pytest.raises(UnknownName, match=f"^{error}"):
        field_of(MESSAGE, field_path(text))


@pytest.mark.parametrize("text", ["", ".", "a.", ".a", "a b", "a[x]", "[0]", "a[0", "a..b"])
def test_malformed_fields_are_wrong_use(text):
    with pytest.raises(WrongUse, match=r"^--field: .*expected one such as pose\.pose\.position"):
        field_path(text)
